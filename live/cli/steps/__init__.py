"""Commands for the step library: list, add, check, dance, partner, texture. They may import every layer."""
