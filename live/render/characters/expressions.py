"""Blend shapes of a character that its face moves: VRM's expressions, ARKit's shapes and those of VRoid, by name.

Each *channel* is driven by one column of `StageView.face`. Its shape is a weighted sum of the file's blend shapes: the
first alternative of the table of which the file has any.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from live.base.body.expression import (
    BLINK_LEFT,
    BLINK_RIGHT,
    BROW,
    EFFORT,
    GAZE_PITCH,
    GAZE_YAW,
    MOUTH_OPEN,
    SMILE,
)

_LOOK: Final = 1.0 / 0.6
"""A look of 0.6 rad is the whole blend shape."""


@dataclass(frozen=True, slots=True)
class Channel:
    """One way in which a face changes."""

    name: str
    column: int
    """Column of the face that drives it, ..."""
    factor: float
    """... times this; the product, 0 to 1, is the weight of the blend shapes."""
    alternatives: tuple[tuple[tuple[str, float], ...], ...]
    """Blend shapes and their weights, the best alternative first; "vrm:" and a name is a preset of VRM 1.0."""


def _both(name: str, weight: float) -> tuple[tuple[str, float], ...]:
    return (f"{name}Left", weight), (f"{name}Right", weight)


CHANNELS: Final = (
    Channel("blinkLeft", BLINK_LEFT, 1.0, (
        (("vrm:blinkLeft", 1.0),), (("eyeBlinkLeft", 1.0),), (("Fcl_EYE_Close_L", 1.0),), (("blinkLeft", 1.0),),
        (("eyesClosedLeft", 1.0),),
    )),
    Channel("blinkRight", BLINK_RIGHT, 1.0, (
        (("vrm:blinkRight", 1.0),), (("eyeBlinkRight", 1.0),), (("Fcl_EYE_Close_R", 1.0),), (("blinkRight", 1.0),),
        (("eyesClosedRight", 1.0),),
    )),
    Channel("browUp", BROW, 1.0, (
        (("browInnerUp", 1.0), *_both("browOuterUp", 0.6)), _both("browUp", 1.0), (("Fcl_BRW_Surprised", 1.0),),
        (("browsUp", 1.0),),
    )),
    Channel("browDown", BROW, -1.0, (_both("browDown", 1.0), (("Fcl_BRW_Angry", 1.0),), (("browsDown", 1.0),))),
    Channel("mouthOpen", MOUTH_OPEN, 1.0, (
        (("jawOpen", 0.8),), (("vrm:aa", 1.0),), (("Fcl_MTH_A", 1.0),), (("mouthOpen", 0.8),), (("viseme_aa", 1.0),),
    )),
    Channel("smile", SMILE, 1.0, (
        _both("mouthSmile", 0.8), (("mouthSmile", 0.8),), (("Fcl_MTH_Fun", 1.0),), (("vrm:relaxed", 0.7),),
        (("vrm:happy", 0.5),),
    )),
    Channel("frown", SMILE, -1.0, (
        _both("mouthFrown", 0.8), (("mouthFrown", 0.8),), (("Fcl_MTH_Sorrow", 0.8),), (("Fcl_MTH_Down", 0.8),),
        (("vrm:sad", 0.5),),
    )),
    Channel("lookLeft", GAZE_YAW, _LOOK, (
        (("vrm:lookLeft", 1.0),), (("eyeLookOutLeft", 1.0), ("eyeLookInRight", 1.0)),
    )),
    Channel("lookRight", GAZE_YAW, -_LOOK, (
        (("vrm:lookRight", 1.0),), (("eyeLookInLeft", 1.0), ("eyeLookOutRight", 1.0)),
    )),
    Channel("lookUp", GAZE_PITCH, _LOOK, ((("vrm:lookUp", 1.0),), _both("eyeLookUp", 1.0))),
    Channel("lookDown", GAZE_PITCH, -_LOOK, ((("vrm:lookDown", 1.0),), _both("eyeLookDown", 1.0))),
    Channel("effort", EFFORT, 1.0, (
        (*_both("eyeSquint", 0.6), *_both("mouthPress", 0.5), *_both("noseSneer", 0.3)),
    )),
)  # fmt: skip
"""All channels; both eyes are closed by `BOTH_EYES` if a file has no blend shape for each."""
CHANNEL_NAMES: Final = tuple(channel.name for channel in CHANNELS)
LOOKS: Final = frozenset(number for number, name in enumerate(CHANNEL_NAMES) if name.startswith("look"))
"""Channels that are left out if the eyes have bones."""
BLINKS: Final = (CHANNEL_NAMES.index("blinkLeft"), CHANNEL_NAMES.index("blinkRight"))
MOUTH: Final = CHANNEL_NAMES.index("mouthOpen")
BOTH_EYES: Final = (("vrm:blink",), ("eyesClosed",), ("Fcl_EYE_Close",), ("blink",))
"""Blend shapes that close both eyes, split at the middle of the face."""

VRM_0_PRESETS: Final = {
    "blink_l": "blinkLeft", "blink_r": "blinkRight", "a": "aa", "i": "ih", "u": "ou", "e": "ee", "o": "oh",
    "joy": "happy", "sorrow": "sad", "fun": "relaxed", "lookleft": "lookLeft", "lookright": "lookRight",
    "lookup": "lookUp", "lookdown": "lookDown",
}  # fmt: skip
"""Presets of VRM 0.x by those of VRM 1.0, where they differ."""

Target = tuple[int, int]
"""Mesh, and number of a blend shape in it."""
Bind = tuple[Target, float]


@dataclass(frozen=True, slots=True)
class Expressions:
    """Blend shapes for each channel, as (mesh, number) and weights."""

    binds: Mapping[int, tuple[Bind, ...]]
    """By channel."""
    both_eyes: tuple[Bind, ...] = ()
    """Those that close both eyes; empty if each eye has its own."""

    def by_mesh(self) -> dict[int, dict[int, list[tuple[int, float]]]]:
        """Return for each mesh and its blend shapes the channels and weights; channel -1: both eyes."""
        found: dict[int, dict[int, list[tuple[int, float]]]] = {}
        for channel, binds in (*self.binds.items(), (-1, self.both_eyes)):
            for (mesh, number), weight in binds:
                found.setdefault(mesh, {}).setdefault(number, []).append((channel, weight))
        return found


def find_expressions(names: Mapping[int, Sequence[str]], presets: Mapping[str, tuple[Bind, ...]]) -> Expressions:
    """Return the blend shapes that faces move. `names`: those of each mesh's blend shapes; `presets`: binds of VRM's
    expressions by the names of VRM 1.0."""
    known: dict[str, list[Bind]] = {}
    for mesh, targets in names.items():
        for number, name in enumerate(targets):
            for plain in _plain(name):
                known.setdefault(plain, []).append(((mesh, number), 1.0))

    def binds(name: str, weight: float) -> list[Bind]:
        found = presets.get(name[4:], ()) if name.startswith("vrm:") else known.get(_plain(name)[0], ())
        return [(target, share * weight) for target, share in found]

    result: dict[int, tuple[Bind, ...]] = {}
    for number, channel in enumerate(CHANNELS):
        for alternative in channel.alternatives:
            found = [bind for name, weight in alternative for bind in binds(name, weight)]
            if found:
                result[number] = tuple(found)
                break
    both: tuple[Bind, ...] = ()
    if not any(channel in result for channel in BLINKS):
        both = next((tuple(found) for (name,) in BOTH_EYES if (found := binds(name, 1.0))), ())
    return Expressions(result, both)


def _plain(name: str) -> list[str]:
    """Return the forms of a name to compare: without separators and MPFB's "!ex-", and from "Fcl" on, which VRoid puts
    after the mesh's name."""
    whole = re.sub(r"[^a-z0-9]", "", name.lower().removeprefix("!ex-"))
    at = whole.find("fcl")
    return [whole, whole[at:]] if at > 0 else [whole]
