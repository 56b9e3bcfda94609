"""Threats: whose way meets somebody else's within the next moments, whatever was planned."""
