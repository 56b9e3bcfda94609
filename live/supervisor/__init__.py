"""Processes, failover (was alive)."""
