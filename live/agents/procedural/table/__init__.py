"""The elements in force as rows of numbers."""
