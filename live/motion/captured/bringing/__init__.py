"""Bringing over: a strange skeleton's pose onto ours."""
