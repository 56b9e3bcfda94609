"""Timing of frames: the budget by which quality follows, and statistics."""
