"""Cli.beats."""
