"""The stage for phones: where dancers and elements are, in few bytes, the same for all phones.

A frame is u8 verb, u8 time until the next frame [10 ms], u8 number of places, u8 number of elements. Then come three
bytes for each place: x, z, and the number of the dancer's group from 1 (0: nobody). A dancer keeps their place from
frame to frame, so that phones move the light smoothly. Then the elements: u8 shape, level and radius, u8 number of
points, and x, z of each. x and z are shares of the stage from the left and from the back, with an eighth of its size
around it; levels are 255ths, radii 255ths of the stage's width.

Of more than `MAX_PLACES` dancers the phones get an even choice. The sizes are bounded: a frame has 28 bytes for eight
dancers, 196 for `MAX_PLACES`, and with all elements 436 at most.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Int32
from live.base.element_kinds import (
    ATTRACTOR,
    CROSSING,
    DRAWN,
    FLOW,
    PARTICIPANT,
    PATH,
    REPULSOR,
    SPREADER,
    UNIFORM,
)

STAGE: Final = 6
"""Verb of a frame."""
STAGE_EVERY: Final = 0.2
"""Interval of frames [s]; it is longer with many phones."""
MAX_PLACES: Final = 64
MAX_ELEMENTS: Final = 12
MAX_POINTS: Final = 8
"""Points of an element; of a longer line an even choice."""
MARGIN: Final = 0.125
"""What is told of the surroundings of the stage, as a share of its size on each side."""
GATHER, LEAVE, SPREAD, CROSS, GO, AROUND = 1, 2, 3, 4, 5, 6
"""Shapes of elements as phones draw them: to a place, away from it, apart, over a line, along a line, around."""
_SHAPES: Final = {
    ATTRACTOR: GATHER, PARTICIPANT: GATHER, REPULSOR: LEAVE, SPREADER: SPREAD, CROSSING: CROSS, PATH: GO,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class ElementLight:
    """An element to show: kind and flow as in `live.base.element_kinds`, points (x, z) [m], radius [m], level."""

    kind: int
    flow: int
    points: tuple[tuple[float, float], ...]
    radius: float
    level: float


def shape_of(kind: int, flow: int) -> int:
    """Return the shape of an element; 0 for one that has no place, such as wandering."""
    if kind == FLOW:
        return GO if flow in (UNIFORM, DRAWN) else AROUND
    return _SHAPES.get(kind, 0)


class StageLights:
    """Encodes frames, and keeps each dancer's place in them. Thread: one."""

    def __init__(self) -> None:
        self._places: npt.NDArray[np.int64] = np.full(MAX_PLACES, -1)
        """Dancer at each place; -1: nobody."""

    def frame(
        self, position: Float32, group: Int32, elements: Iterable[ElementLight], half: tuple[float, float]
    ) -> bytes:
        """Return the frame of A dancers at `position` (A, 2) [m] of a stage of the half sizes `half` [m].

        `group` (A,): 0 for those who are not on the stage, else the number of their group, from 1.
        """
        places = self._assign(group)
        count = int(np.flatnonzero(places >= 0)[-1]) + 1 if (places >= 0).any() else 0
        places = places[:count]
        rows = np.zeros((count, 3), np.uint8)
        there = places >= 0
        rows[there, :2] = _shares(position[places[there]], half)
        rows[there, 2] = np.minimum(group[places[there]], 255)
        shown, number = bytearray(), 0
        for element in elements:
            shape = shape_of(element.kind, element.flow)
            if not shape or element.level <= 0.0:
                continue
            points = np.array(element.points, np.float64).reshape(-1, 2)
            if len(points) > MAX_POINTS:
                points = points[np.linspace(0, len(points) - 1, MAX_POINTS).astype(int)]
            level, radius = (
                round(255 * min(max(value, 0.0), 1.0)) for value in (element.level, element.radius / (2.0 * half[0]))
            )
            shown += bytes((shape, level, radius, len(points))) + _shares(points, half).tobytes()
            number += 1
            if number == MAX_ELEMENTS:
                break
        return bytes((STAGE, 0, count, number)) + rows.tobytes() + bytes(shown)

    def _assign(self, group: Int32) -> npt.NDArray[np.int64]:
        """Return the dancer at each place: who is there stays there, others take the free places."""
        places = self._places
        places[places >= len(group)] = -1
        known = np.flatnonzero(places >= 0)
        places[known[group[places[known]] == 0]] = -1
        there = group > 0
        there[places[places >= 0]] = False
        free = np.flatnonzero(places < 0)
        if len(free) and there.any():
            come = np.flatnonzero(there)
            some = min(len(free), len(come))
            places[free[:some]] = come[np.linspace(0, len(come) - 1, some).astype(int)]
        return places


def _shares(points: npt.NDArray[np.floating], half: tuple[float, float]) -> npt.NDArray[np.uint8]:
    """Return (x, z) [m] as bytes, shape (N, 2); what is outside stands at the border."""
    shares = 0.5 + 0.5 * points / np.array(half)
    found: npt.NDArray[np.uint8] = np.clip(np.rint(255 * (shares + MARGIN) / (1.0 + 2.0 * MARGIN)), 0, 255).astype(
        np.uint8
    )
    return found


def with_interval(frame: bytes, seconds: float) -> bytes:
    """Return a frame that says when the next one comes [s]."""
    return bytes((frame[0], min(max(round(100.0 * seconds), 1), 255))) + frame[2:]


def colour_texts(colours: npt.NDArray[np.floating]) -> tuple[str, ...]:
    """Return linear colours (N, 3) as #rrggbb, each as bright as its hue can be: lights, not clothes."""
    bright = np.maximum(colours, 0.0) ** (1.0 / 2.2) + 0.08
    whole = np.rint(255 * bright / bright.max(axis=1, keepdims=True)).astype(int)
    return tuple(f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in whole.tolist())
