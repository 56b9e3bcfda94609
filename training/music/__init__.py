"""Composition: pieces of many styles as notes in beats, with a tempo to perform them in."""
