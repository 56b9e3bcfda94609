"""Render nodes: machines and processes that draw a leader's show in lockstep. It may import `supervisor` and below."""
