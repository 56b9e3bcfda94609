"""Parameters, cues, scenes, undo."""
