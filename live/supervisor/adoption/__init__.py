"""Supervisor.adoption."""
