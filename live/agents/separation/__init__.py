"""Keeping paths apart."""
