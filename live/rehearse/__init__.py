"""Rehearsing without people: a made-up band, made-up players and phones, faults, and long runs that watch the show."""
