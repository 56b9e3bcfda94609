"""Windows and monitors."""
