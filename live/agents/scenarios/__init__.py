"""Benchmark scenarios for collision avoidance: starts, goals, walls. It may import what `agents` may."""
