"""Scenarios are benchmarks of collision avoidance: who starts where and goes where. It may import what `agents` may."""
