"""Cli.inspect."""
