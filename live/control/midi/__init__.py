"""Midi."""
