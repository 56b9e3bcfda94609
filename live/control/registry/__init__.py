"""The table of controls."""
