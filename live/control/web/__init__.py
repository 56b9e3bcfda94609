"""Operator's page."""
