"""The pointer's tools as data: what a click or a stroke on the floor of the window places there.

A stroke is what is drawn between pressing and letting go. Everything goes through the same registry as OSC.
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
WALKED: Final = "0"
"""The tool that draws a way while it is walked."""
SHORTEST: Final = 0.3
"""A stroke has to be this long [m] to be one."""
MOST_POINTS: Final = 14
"""Points that are kept of a stroke: so many fit into a text."""


@dataclass(frozen=True, slots=True)
class Tool:
    """What the pointer does after its key was pressed: `shape` says what is made of the stroke for `address`."""

    description: str
    address: str
    shape: Literal["place", "line", "drawn", "region"]
    shifted: str = ""
    """The address with Shift held; empty: the same."""


TOOLS: Final[dict[str, Tool]] = {
    "A": Tool("attractor (Shift: repulsor), follows the pointer", "/dance/attract", "place", "/dance/repel"),
    "L": Tool("line they gather along (Shift: leave)", "/dance/attract/line", "line", "/dance/repel/line"),
    "D": Tool("drawn line they gather along", "/dance/attract/drawn", "drawn"),
    "R": Tool("region they come into (Shift: leave)", "/dance/attract/region", "region", "/dance/repel/region"),
    "X": Tool("bar they cross to the other side", "/dance/cross", "line"),
    "U": Tool("flow in the stroke's direction", "/dance/flow", "line"),
    "V": Tool("vortex (Shift: outwards)", "/dance/flow/vortex", "place", "/dance/flow/radial"),
    "P": Tool("path they follow", "/dance/path", "drawn"),
    "T": Tool("way the formation travels", "/dance/travel", "drawn"),
    "0": Tool("way that walkers walk while it is drawn (Shift: a new one)", "/dance/partner/path", "place"),
}
"""Tools by the key that chooses them; the first is the one at the start."""


def event_for_stroke(tool: str, points: Points, shift: bool, time: float) -> ControlEvent | None:
    """The event of a stroke (x, z) [m] that was let go at `time` [s of the show]; None if it makes none.

    The attractor acts while it is drawn, not when it is let go: see `event_for_place`.
    """
    what = TOOLS[tool]
    address = what.shifted if shift and what.shifted else what.address
    if not points or not all(math.isfinite(value) for point in points for value in point):
        return None
    first, last = points[0], points[-1]
    if what.shape == "place":
        return _event(address, last if tool == WALKED else first, time)
    if what.shape == "region":
        return _event(address, (*first, max(math.dist(first, last), SHORTEST)), time)
    if _length(points) < SHORTEST:
        return None
    if what.shape == "line":
        return None if math.dist(first, last) < SHORTEST else _event(address, (*first, *last), time)
    return _event(address, (", ".join(f"{x:.2f} {z:.2f}" for x, z in _thinned(points)),), time)


def event_for_place(tool: str, x: float, z: float, shift: bool, time: float) -> ControlEvent | None:
    """The event of the pointer at (x, z) [m] while it is pressed, for tools that act at once; None for others, and
    where the floor is too far away or not hit (NaN)."""
    what = TOOLS[tool]
    if tool == WALKED:
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
    """At most MOST_POINTS of the points, evenly chosen, the first and the last among them."""
    count = min(len(points), MOST_POINTS)
    return [points[round(k * (len(points) - 1) / (count - 1))] for k in range(count)]
