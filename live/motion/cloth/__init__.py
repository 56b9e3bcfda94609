"""What moves by itself: springs of characters. May import what `motion` may."""
