"""Phones in a show."""
