"""Beats of a recording."""
