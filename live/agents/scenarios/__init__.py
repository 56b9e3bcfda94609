"""Scenarios: agents, goals and walls on which avoidance is judged, read from JSON or generated, run and measured."""
