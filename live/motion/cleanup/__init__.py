"""Tracking faults."""
