"""Finishing: units that end now."""
