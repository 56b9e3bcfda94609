"""Events of older journals (formats 1 and 2) in the form of today.

Until format 2 each kind of parameter had an event of its own, and some events had other fields.
"""

import contextlib
from collections.abc import Callable
from typing import Any, Final

from live.base import motion_parameters as motion
from live.base.picture_parameters import BY_ADDRESS, GROUP_PARAMETERS
from live.control.registry.control import parse_points

LAST_OLD_FORMAT: Final = 2
"""Journals up to this format have such events."""

_MOTION: Final = {
    "warp_beats": motion.WARP, "warp_sequence": motion.WARP_SEQUENCE, "larger": motion.LARGER,
    "amplitude": motion.AMPLITUDE, "amplitude_sequence": motion.AMPLITUDE_SEQUENCE, "mix": motion.MIX,
    "arms": motion.ARMS, "texture": motion.TEXTURE, "head": motion.HEAD, "obedience": motion.OBEDIENCE,
    "lock": motion.FOOT_LOCK, "on_support": motion.TURN_ON_SUPPORT, "face_average": motion.FACE_AVERAGE,
    "mirror": motion.MIRRORED,
}  # fmt: skip
"""Parameter by its old name in SetMotion."""

Values = dict[str, Any]


def _set_motion(old: Values) -> Values:
    row = _MOTION.get(str(old.pop("parameter", "")))
    address = "/dance/motion/unknown" if row is None else row.address
    return old | {"type": "SetParameter", "address": address, "value": [old.pop("value", 0.0)]}


def _set_picture(old: Values) -> Values:
    numbers = [old.pop(name, 0.0) for name in ("x", "y", "z")]
    address = str(old.pop("parameter", ""))
    row = BY_ADDRESS.get(address) or GROUP_PARAMETERS.get(address)
    return old | {"type": "SetParameter", "address": address, "value": numbers[: 1 if row is None else row.size]}


def _set_latency(old: Values) -> Values:
    return old | {"milliseconds": 1000.0 * old.pop("seconds", 0.0)}


def _learn_midi(old: Values) -> Values:
    given = str(old.pop("given", "")).split("\n")
    return old | dict(zip(("first", "second", "third", "fourth"), given, strict=False))


def _points(text: str) -> list[tuple[float, float]]:
    """Return the points of a text; none if they are invalid, which the show refuses."""
    try:
        return list(parse_points(text))
    except ValueError:
        return []


def _place_element(old: Values) -> Values:
    return old | {"points": _points(old["points"])} if old.get("points") else {**old, "points": [(0.0, 0.0)]}


def _drawn(old: Values) -> Values:
    return old | {"points": _points(str(old.get("points", "")))}


def _element(kind: str, **fixed: Any) -> Callable[[Values], Values]:
    """Return the upgrade of an event that placed an element of one kind at a point."""

    def upgrade(old: Values) -> Values:
        if kind != "spread":
            if "x" not in old or "z" not in old:
                raise ValueError(f"event {old['type']}: its place is missing")
            old["points"] = [(old.pop("x"), old.pop("z"))]
        return {"kind": kind, **old, **fixed, "type": "PlaceElement"}

    return upgrade


def _integer_rows(text: str) -> list[list[int]]:
    """Return the rows of whole numbers in a text; invalid ones are left out."""
    rows = []
    for entry in "" if text == "-" else text.split(","):
        with contextlib.suppress(ValueError):
            rows.append([int(word) for word in entry.split()])
    return rows


def _audience(old: Values) -> Values:
    for name, width in (("places", 4), ("lights", 5)):
        text = old.pop(name, "")
        if text:
            old[name] = [row for row in _integer_rows(text) if len(row) == width]
    votes = old.pop("votes", "")
    return old | ({"votes": _integer_rows(votes)[0]} if votes else {})


_UPGRADES: Final[dict[str, Callable[[Values], Values]]] = {
    "Attract": _element("attract"),
    "Repel": _element("repel"),
    "Spread": _element("spread"),
    "Voice": _element("attract", measures=2.0, fair=True, drag=True),
    "PlaceElement": _place_element,
    "Travel": _drawn,
    "AudienceHeard": _audience,
    "SetMotion": _set_motion,
    "SetPicture": _set_picture,
    "SetLatency": _set_latency,
    "LearnMidi": _learn_midi,
    "SetMetre": lambda old: old | {"beats": round(old.get("beats", 4))},
}


def upgrade_event(old: Values) -> Values:
    """Return an event of an older journal, as a JSON object, in the form of today."""
    upgrade = _UPGRADES.get(str(old.get("type")))
    return old if upgrade is None else upgrade(dict(old))
