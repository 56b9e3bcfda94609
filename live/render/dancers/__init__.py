"""Instancing, styles, trails."""
