"""Vocabulary of a recording: its measures, which of them repeat, the steps they make, names. It may import what `graph`
may."""
