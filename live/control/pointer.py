"""Pointer tools: events for clicks and strokes on the stage floor in the window.

A stroke lasts from pressing to releasing the button. All events go through the same registry as OSC.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY

SOURCE: Final = "pointer"
Points = Sequence[tuple[float, float]]
WALK_TOOL: Final = "0"
"""The tool that draws a path while it is walked."""
MIN_STROKE: Final = 0.3
"""Minimum length of a stroke [m]."""
MAX_POINTS: Final = 512
"""Maximum number of points kept of a stroke."""


@dataclass(frozen=True, slots=True)
class Tool:
    """A pointer tool, chosen by a key; `shape` states how a stroke becomes the arguments of `address`."""

    description: str
    address: str
    shape: Literal["place", "line", "drawn", "region"]
    shifted: str = ""
    """The address with Shift held; empty: the same."""


TOOLS: Final[dict[str, Tool]] = {
    "A": Tool("attractor (Shift: repulsor), follows the pointer", "/dance/attract", "place", "/dance/repel"),
    "L": Tool("line that attracts dancers (Shift: repels)", "/dance/attract/line", "line", "/dance/repel/line"),
    "D": Tool("drawn line that attracts dancers", "/dance/attract/drawn", "drawn"),
    "R": Tool("region that attracts dancers (Shift: repels)", "/dance/attract/region", "region", "/dance/repel/region"),
    "X": Tool("line that dancers cross to the other side", "/dance/cross", "line"),
    "U": Tool("flow in the stroke's direction", "/dance/flow", "line"),
    "V": Tool("vortex (Shift: outwards)", "/dance/flow/vortex", "place", "/dance/flow/radial"),
    "P": Tool("path that dancers follow", "/dance/path", "drawn"),
    "T": Tool("path of the formation", "/dance/travel", "drawn"),
    "0": Tool("path walked while it is drawn (Shift: a new one)", "/dance/partner/path", "place"),
}
"""Tools by their keys; the first is active at the start."""


def event_for_stroke(tool: str, points: Points, shift: bool, time: float) -> ControlEvent | None:
    """Return the event of a stroke (x, z) [m] released at `time` [s of the show]; None if it makes none.

    The attractor acts during the stroke, not at its end: see `event_for_place`.
    """
    what = TOOLS[tool]
    address = what.shifted if shift and what.shifted else what.address
    if not points or not all(math.isfinite(value) for point in points for value in point):
        return None
    first, last = points[0], points[-1]
    if what.shape == "place":
        return _event(address, last if tool == WALK_TOOL else first, time)
    if what.shape == "region":
        return _event(address, (*first, max(math.dist(first, last), MIN_STROKE)), time)
    if _length(points) < MIN_STROKE:
        return None
    if what.shape == "line":
        return None if math.dist(first, last) < MIN_STROKE else _event(address, (*first, *last), time)
    return _event(address, (", ".join(f"{x:.2f} {z:.2f}" for x, z in _thinned(points)),), time)


def event_for_place(tool: str, x: float, z: float, shift: bool, time: float) -> ControlEvent | None:
    """Return the event of the pointer pressed at (x, z) [m]; None for tools that do not act at once.

    None also where the floor is too far away or not hit (NaN).
    """
    what = TOOLS[tool]
    if tool == WALK_TOOL:
        return _event(what.address, (float(x), float(z), "*", shift), time)
    if tool != "A":
        return None
    return _event(what.shifted if shift else what.address, (float(x), float(z)), time)


def _event(address: str, values: Sequence[object], time: float) -> ControlEvent | None:
    result = REGISTRY.call(address, values, time, SOURCE)
    return result if isinstance(result, ControlEvent) else None


def _length(points: Points) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def _thinned(points: Points) -> list[tuple[float, float]]:
    """Return at most MAX_POINTS of the points, evenly chosen, including the first and the last."""
    count = min(len(points), MAX_POINTS)
    return [points[round(k * (len(points) - 1) / (count - 1))] for k in range(count)]
