"""Events of journals of format 1 and 2 are read in the form of today."""

import pytest

from live.control.events import events
from live.control.events.event_json import event_from_json
from live.show.journal.old_events import upgrade_event

STAMP = {"time": 1.5, "source": "osc"}


@pytest.mark.parametrize(
    ("old", "event"),
    [
        (
            {"type": "Attract", "x": 1.0, "z": -2.0, "strength": 3.0, "next": True},
            events.PlaceElement(kind="attract", points=((1.0, -2.0),), strength=3.0, next=True, **STAMP),
        ),
        (
            {"type": "Repel", "x": 1.0, "z": 0.5, "drag": True, "group": "ember"},
            events.PlaceElement(kind="repel", points=((1.0, 0.5),), drag=True, group="ember", **STAMP),
        ),
        ({"type": "Spread", "measures": 2.0}, events.PlaceElement(kind="spread", measures=2.0, **STAMP)),
        (
            {"type": "Voice", "x": 1.0, "z": 0.5, "strength": 2.5},
            events.PlaceElement(
                kind="attract", points=((1.0, 0.5),), strength=2.5, measures=2.0, fair=True, drag=True, **STAMP
            ),
        ),
        (
            {"type": "PlaceElement", "kind": "cross", "points": "0.0 -4.0, 0.0 4.0"},
            events.PlaceElement(kind="cross", points=((0.0, -4.0), (0.0, 4.0)), **STAMP),
        ),
        ({"type": "PlaceElement", "kind": "wander"}, events.PlaceElement(kind="wander", **STAMP)),
        (
            {"type": "PlaceElement", "kind": "path", "points": "a b"},
            events.PlaceElement(kind="path", points=(), **STAMP),
        ),
        ({"type": "Travel", "points": "0 1, 2 3"}, events.Travel(points=((0.0, 1.0), (2.0, 3.0)), **STAMP)),
        (
            {"type": "SetMotion", "parameter": "lock", "value": 0.0},
            events.SetParameter(address="/dance/motion/foot_lock", value=(0.0,), **STAMP),
        ),
        (
            {"type": "SetMotion", "parameter": "warp_beats", "value": 0.25, "group": "ember"},
            events.SetParameter(address="/dance/motion/warp", value=(0.25,), group="ember", **STAMP),
        ),
        (
            {"type": "SetPicture", "parameter": "/dance/light/key", "x": 0.5, "measures": 2.0},
            events.SetParameter(address="/dance/light/key", value=(0.5,), measures=2.0, **STAMP),
        ),
        (
            {"type": "SetPicture", "parameter": "/dance/light/key/colour", "x": 0.5, "y": 0.25},
            events.SetParameter(address="/dance/light/key/colour", value=(0.5, 0.25, 0.0), **STAMP),
        ),
        (
            {"type": "AudienceHeard", "phones": 3, "order": 2, "places": "500 0 1000 1,1 2", "lights": "-"},
            events.AudienceHeard(phones=3, order=2, places=((500, 0, 1000, 1),), lights=(), **STAMP),
        ),
        (
            {"type": "AudienceHeard", "phones": 3, "order": 2, "votes": "7 100 50"},
            events.AudienceHeard(phones=3, order=2, votes=(7, 100, 50), **STAMP),
        ),
        ({"type": "SetMetre", "beats": 3.0}, events.SetMetre(beats=3, **STAMP)),
        (
            {"type": "SetLatency", "what": "display", "seconds": 0.125},
            events.SetLatency(what="display", milliseconds=125.0, **STAMP),
        ),
        (
            {"type": "LearnMidi", "address": "/dance/go", "given": "a\nb=1"},
            events.LearnMidi(address="/dance/go", first="a", second="b=1", **STAMP),
        ),
        ({"type": "Tap"}, events.Tap(**STAMP)),
    ],
)
def test_older_forms_are_read(old, event):
    assert event_from_json(upgrade_event(old | STAMP)) == event


def test_an_old_event_without_its_place_is_refused():
    with pytest.raises(ValueError, match="missing"):
        upgrade_event({"type": "Attract", "x": 1.0, **STAMP})
