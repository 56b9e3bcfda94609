"""Rehearse.chaos."""
