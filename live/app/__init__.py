"""Composition root: session, loops (was in cli)."""
