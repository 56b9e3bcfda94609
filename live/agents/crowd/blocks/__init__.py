"""Blocks: agents who lie one after another, as lanes."""
