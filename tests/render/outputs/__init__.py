"""Tests of the projector outputs."""
