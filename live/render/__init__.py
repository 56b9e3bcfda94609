"""Pictures out: from `live.base.stage_snapshot` to the screen; knows nothing else of the show."""
