"""Writer for Open Stage Control sessions (JSON) of a `Surface`. Its server uses one port to send to and receive from
the engine.
"""

import json
import math
from typing import Any, Final

from live.control.web.surface import Page, Surface, Widget

VERSION: Final = "1.26.0"
"""First program version that supports this file format."""
COLUMNS: Final = 6
RENEW_INTERVAL: Final = 1800
"""Interval at which the subscription is renewed [s]; it lasts an hour."""


def session_text(surface: Surface, endpoint: str) -> str:
    """Return the session as text; all widgets send to `endpoint` (host:port)."""
    tabs = [_tab(number, page, endpoint) for number, page in enumerate(surface.pages)]
    hear = f'send("{endpoint}", "/dance/subscribe", "/dance", {{type: "i", value: 3600}})'
    root = {
        "type": "root",
        "id": "root",
        "colorBg": "#101014",
        "tabs": tabs,
        # values are sent at once, and the subscription is renewed before it ends
        "onCreate": f"{hear}\nsetInterval(() => {{ {hear} }}, {RENEW_INTERVAL * 1000})",
    }
    whole = {"createdWith": "Open Stage Control", "version": VERSION, "type": "session", "content": root}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def _tab(number: int, page: Page, endpoint: str) -> dict[str, Any]:
    widgets = [_widget(f"{number}_{index}", widget, endpoint) for index, widget in enumerate(page.widgets)]
    return {
        "type": "tab",
        "id": f"tab_{number}",
        "label": page.title,
        "layout": "grid",
        "gridTemplate": min(COLUMNS, math.ceil(math.sqrt(len(widgets)))),
        "widgets": widgets,
    }


def _widget(name: str, widget: Widget, endpoint: str) -> dict[str, Any]:
    made: dict[str, Any] = {
        "id": f"w{name}",
        "address": widget.address,
        "target": endpoint,
        "comments": widget.label,
        "decimals": 3,
    }
    if widget.kind == "button":
        made |= {"type": "button", "label": widget.label, "wrap": True}
        # "tap" sends a value and no release; "momentary" sends the address alone
        return made | ({"mode": "tap", "on": widget.values[0]} if widget.values else {"mode": "momentary"})
    if widget.kind == "toggle":
        made |= {
            "type": "button",
            "mode": "toggle",
            "on": 1,
            "off": 0,
            "typeTags": "i",
            "label": widget.label,
            "wrap": True,
        }
        return made | {"default": int(widget.start[0]) if widget.start else ""}
    made["html"] = widget.label
    if widget.kind == "pad":
        made |= {
            "type": "xy",
            "snap": True,
            "rangeX": {"min": widget.minimum[0], "max": widget.maximum[0]},
            # the audience is below, where z is largest
            "rangeY": {"min": widget.maximum[1], "max": widget.minimum[1]},
        }
        if widget.once:
            send = f'send("{endpoint}", "{widget.address}", value[0], value[1])'
            made |= {"bypass": True, "onTouch": f'if (event.type === "stop") {send}'}
        return made
    made["range"] = {"min": widget.minimum[0], "max": widget.maximum[0]}
    if widget.kind == "colour":
        return made | {"type": "rgb", "snap": True, "default": list(widget.start) or ""}
    return made | {
        "type": "fader",
        "horizontal": True,
        "doubleTap": True,
        "default": widget.start[0] if widget.start else "",
    }
