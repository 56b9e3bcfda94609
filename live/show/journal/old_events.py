"""Events of older journals (formats 1 and 2) in the form of today.

Until format 2 each kind of parameter had an event of its own, and some events had other fields.
"""

from collections.abc import Callable
from typing import Any, Final

from live.base import motion_parameters as motion
from live.base.picture_parameters import BY_ADDRESS, GROUP_PARAMETERS

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


_UPGRADES: Final[dict[str, Callable[[Values], Values]]] = {
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
