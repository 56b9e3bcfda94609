"""Supervisor.network."""
