"""Pictures out: from `live.base.stage_view` to the screen; knows nothing else of the show."""
