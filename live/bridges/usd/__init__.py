"""Universal Scene Description (USD) as a motion format: all dancers of a show, for Blender, Houdini, Unreal or Maya."""

from live.app.bridges import Bridge

BRIDGE = Bridge(name="usd")
"""The USD format: written only, with the package usd-core."""
