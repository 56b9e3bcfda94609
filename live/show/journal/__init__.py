"""Journal, replay, snapshots."""
