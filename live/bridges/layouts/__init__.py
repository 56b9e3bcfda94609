"""Bridge to tablets: layouts for TouchOSC and Open Stage Control, by `live layout`."""

from collections.abc import Mapping

from live.app.bridges import Bridge, Command


def commands() -> Mapping[str, Command]:
    """`live layout`."""
    from live.bridges.layouts.layout_command import layout

    return {"layout": layout}


BRIDGE = Bridge(name="layouts", commands=commands)
