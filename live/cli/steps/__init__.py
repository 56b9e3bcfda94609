"""Cli.steps."""
