"""What each dancer is doing."""
