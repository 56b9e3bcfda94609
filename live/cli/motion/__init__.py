"""Cli.motion."""
