"""Poses of live-captured people."""
