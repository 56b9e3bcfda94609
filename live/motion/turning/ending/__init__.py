"""Where measures end on the stage, and in which axes the next ones join, for all dancers in one pass."""
