"""Commands about the step library: list, add, check, dance, partner, texture. It may import every layer."""
