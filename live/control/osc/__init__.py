"""Osc and oscquery."""
