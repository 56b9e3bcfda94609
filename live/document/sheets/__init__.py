"""Sheets for real dancers: storyboard, a page for each dancer, and marks for the musician (abstract and 1.2.1)."""
