"""Ways out of a collision: how much room each of them lacks to all who are near."""
