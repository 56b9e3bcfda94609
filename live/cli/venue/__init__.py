"""Cli.venue."""
