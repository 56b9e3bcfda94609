"""Acclaim files (ASF/AMC) as a motion format: the recordings of the CMU library."""

from live.app.bridges import Bridge

BRIDGE = Bridge(name="acclaim")
