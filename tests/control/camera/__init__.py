"""Tests of cameras that see performers."""
