"""Tests of layouts: values that a widget sends at both ends of its range are accepted by its control."""

import json

import numpy as np
import py2tosc
import pytest

from live.bridges.layouts.stage_control import session_text
from live.bridges.layouts.touchosc import write_touchosc
from live.control.events.events import ControlEvent
from live.control.registry.control import ROLE_RANKS
from live.control.registry.registry import READABLE, REGISTRY
from live.control.registry.rejections import Rejection
from live.control.web.surface import MAX_PAGE_WIDGETS, make_surface
from tests.fixtures.mostly_long import mostly_long

NAMES = {"/dance/step": ["kick", "turn, then hold"], "/dance/formation": ["circle"], "/dance/scene": ["night {1}"]}


def surface(role="operator"):
    return make_surface(REGISTRY, role=role, names=NAMES, reach=(5.0, 3.0))


def call_control(address, values):
    return REGISTRY.call(address, values, 1.0, "osc")


def tosc_messages(document):
    """Every message of a TouchOSC layout: its address, the message, and its values at either end of the control."""
    for node in document.root.walk():
        for message in node.messages:
            ends = []
            for end in (0, 1):
                values = []
                for part in message.arguments:
                    low, high = part.scale_min, part.scale_max
                    text = part.value
                    if py2tosc.PartialType(part.type) is py2tosc.PartialType.VALUE:
                        text = np.float32(low + end * (high - low))
                    kind = {"INTEGER": int, "FLOAT": float, "STRING": str}[py2tosc.Conversion(part.conversion).value]
                    values.append(kind(text))
                ends.append(values)
            yield "".join(part.value for part in message.path), message, ends


def test_every_control_has_a_widget_or_is_listed_omitted():
    for role in ("operator", "musician"):
        made = surface(role)
        mine = {control.address for control in REGISTRY if ROLE_RANKS[control.role] <= ROLE_RANKS[role]}
        shown = {widget.address for page in made.pages for widget in page.widgets}
        assert not shown & set(made.omitted)
        asked = {f"/dance/{name}" for name in ("ping", "get", "subscribe", "unsubscribe")}
        assert shown | set(made.omitted) | asked == mine | asked
        assert all(0 < len(page.widgets) <= MAX_PAGE_WIDGETS for page in made.pages)
    assert {"/dance/go", "/dance/attract", "/dance/light/level", "/dance/step", "/dance/blackout"} <= shown | {
        widget.address for page in surface().pages for widget in page.widgets
    }


@pytest.mark.long
def test_touchosc_messages_match_show_controls(tmp_path):
    file = tmp_path / "a.tosc"
    write_touchosc(surface(), file)
    document = py2tosc.load(file)
    assert py2tosc.validate(document) == []
    addresses = set()
    for address, message, ends in tosc_messages(document):
        addresses.add(address)
        if message.send:
            for values in ends:
                assert not isinstance(call_control(address, values), Rejection), (address, values)
        if message.receive and not message.send:
            assert address in READABLE
    steps = [ends[0] for address, _, ends in tosc_messages(document) if address == "/dance/step"]
    assert steps == [["kick"], ["turn, then hold"]]
    assert addresses - {"/dance/subscribe"} == {widget.address for page in surface().pages for widget in page.widgets}


def test_open_stage_control_messages_are_accepted():
    session = json.loads(session_text(surface(), "10.0.0.7:9010"))
    assert session["type"] == "session"
    assert "/dance/subscribe" in session["content"]["onCreate"]
    widgets = [widget for tab in session["content"]["tabs"] for widget in tab["widgets"]]
    assert len({widget["id"] for widget in widgets}) == len(widgets) > 100
    for widget in widgets:
        assert widget["target"] == "10.0.0.7:9010"
        for end in ("min", "max"):
            match widget["type"], widget.get("mode"):
                case "fader", _:
                    values = [widget["range"][end]]
                case "rgb", _:
                    values = [widget["range"][end]] * 3
                case "xy", _:
                    values = [widget["rangeX"][end], widget["rangeY"][end]]
                case "button", "toggle":
                    values = [widget["off" if end == "min" else "on"]]
                case "button", "tap":
                    values = [widget["on"]]
                case "button", "momentary":
                    values = []
            sent = [float(np.float32(value)) if isinstance(value, float) else value for value in values]
            assert not isinstance(call_control(widget["address"], sent), Rejection), widget


@mostly_long(("pad", "world"), [((0.0, 0.0), (-5.0, 3.0)), ((1.0, 1.0), (5.0, -3.0))], quick=[0])
def test_lower_pad_edge_maps_to_audience_side(tmp_path, pad, world):
    write_touchosc(surface(), tmp_path / "a.tosc")
    for address, message, _ in tosc_messages(py2tosc.load(tmp_path / "a.tosc")):
        if address == "/dance/attract":
            places = [
                float(part.scale_min) + along * (float(part.scale_max) - float(part.scale_min))
                for part, along in zip(message.arguments, pad, strict=True)
            ]
            event = call_control(address, places)
            assert isinstance(event, ControlEvent)
            assert event.points[0] == pytest.approx(world)
            return
    pytest.fail("there is no pad to attract")


def test_range_ends_are_accepted_in_single_precision():
    for control in REGISTRY:
        for index, argument in enumerate(control.arguments):
            if argument.type == "float":
                for edge in (argument.minimum, argument.maximum):
                    assert argument.check(float(np.float32(edge))) == pytest.approx(edge), (control.address, index)
