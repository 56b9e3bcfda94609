"""Expecting: where the follower will be."""
