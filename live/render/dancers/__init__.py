"""Instanced drawing of dancers: styles, trails, particles. Imports are limited as in `render`."""
