"""Sections, sequences, improvisation."""
