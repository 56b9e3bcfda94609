"""Meetings: how many pairs of dancers come too near to each other on their ways."""
