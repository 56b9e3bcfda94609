"""Audience phones in a show: votes and touches become parameters. It may import what `show` may."""
