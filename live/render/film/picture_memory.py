"""What pictures remember of the pictures before them: how far back a film in parts has to go for the same picture.

A pass remembers moments (`Renderer.follow`: cheap, nothing is drawn) or light, which has to be drawn. How much of both
follows from the picture's parameters alone, so that no OpenGL is needed to know it.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.base.custom_pass import NUMBERS_PER_PASS
from live.base.picture_parameters import CUSTOM_PASS_SLICE
from live.base.stage_snapshot import Scene
from live.render.pass_context import Memory
from live.render.passes.custom_pass import reads_last_picture
from live.render.passes.focus_pass import FocusPass
from live.render.passes.plan_pass import PlanPass
from live.render.passes.stage_pass import LONG_STILL
from live.render.passes.styled_pass import StylePasses
from live.render.passes.trail_pass import TrailsPass
from live.render.worlds.ripple_pass import RipplePass

MEMORIES: Final[tuple[Callable[[Float64], Memory], ...]] = (
    StylePasses.memory, RipplePass.memory, PlanPass.memory, FocusPass.memory, TrailsPass.memory,
)  # fmt: skip
"""Memory of each pass that has one, by the parameter row of the picture."""
EASING_MEMORY_S: Final = 3.0
"""Arms that keep off others follow through filters of 0.03 s (`ArmEasing`): 100 time constants [s]."""
STILL_FRAMES: Final = 2 * LONG_STILL
"""Frames by which the backdrop decides how it is drawn."""
DRAWN_FRAMES: Final = 2
"""Frames that are always drawn before the first one of a part: motion blur remembers one, and the other is compared
with the last picture of the part before."""
_FORGOTTEN: Final = 2.0**-26
"""Share of a trail's light that no half float holds beside what is drawn now."""


@dataclass(frozen=True, slots=True)
class Reach:
    """First frames that have to be followed, and drawn, before a part begins."""

    follow: int
    draw: int


def least_reach(fps: float) -> int:
    """Return how many frames before a part have to be followed at least, whatever its pictures show."""
    return DRAWN_FRAMES + max(math.ceil(EASING_MEMORY_S * fps), STILL_FRAMES) + 1


class PictureMemory:
    """The memory of the pictures of one show, frame by frame; call `add` for each in order."""

    def __init__(self, scene: Scene, first: int = 0) -> None:
        """`first`: number of the first frame that will be added."""
        self.first = first
        self._feedback = [
            CUSTOM_PASS_SLICE.start + slot * NUMBERS_PER_PASS
            for slot, own in enumerate(scene.custom_passes)
            if reads_last_picture(own)
        ]
        self._rows: list[tuple[float, float, float, float, float, bool]] = []

    def add(self, row: Float64, time: float, beat: float, *, frozen: bool = False) -> None:
        """Add a frame: its parameters, time [s] and beat, and whether the picture is frozen."""
        each = [memory(row) for memory in MEMORIES]
        half_life = max(one.half_life for one in each)
        if any(row[place] > 0.0 for place in self._feedback):
            half_life = math.inf
        beats, seconds = max(one.beats for one in each), max(EASING_MEMORY_S, *(one.seconds for one in each))
        self._rows.append((time, beat, beats, seconds, half_life, frozen))

    def reach(self, frame: int, *, patience: float = 1.0) -> Reach:
        """Return how far back a part has to go that begins with `frame`, the last one added; `patience`: so many times
        as far. A number below `first` says that more frames are needed."""
        rows = self._rows[: frame - self.first + 1]
        at = len(rows) - 1
        draw = self._drawn(rows, patience)
        anchor = min(draw, at)
        while anchor > 0 and rows[anchor][5]:  # a frozen picture is that of the last frame before
            anchor -= 1
        follow = min(self._followed(rows, place, patience) for place in {anchor, at})
        if self.first and (draw <= 0 or follow <= 0):
            return Reach(self.first - 1, self.first - 1)
        return Reach(self.first + max(follow, 0), self.first + max(draw, 0))

    def _drawn(self, rows: Sequence[tuple[float, float, float, float, float, bool]], patience: float) -> int:
        """Return the first row whose light is left in the last one, at most DRAWN_FRAMES before it."""
        place, left = len(rows) - 1, 1.0
        while place > 0 and rows[place][4] > 0.0 and left > _FORGOTTEN**patience:
            passed = rows[place][1] - rows[place - 1][1]
            left *= 0.5 ** (max(passed, 0.0) / rows[place][4])
            place -= 1
        return min(place, len(rows) - 1 - round(DRAWN_FRAMES * patience))

    def _followed(
        self, rows: Sequence[tuple[float, float, float, float, float, bool]], at: int, patience: float
    ) -> int:
        """Return the first row that the one `at` remembers."""
        if at <= 0:
            return at
        time, beat, beats, seconds = rows[at][:4]
        times = np.array([row[0] for row in rows[: at + 1]])
        counted = np.array([row[1] for row in rows[: at + 1]])
        since = int(np.searchsorted(times, time - patience * seconds))
        earlier = np.flatnonzero(counted < beat - patience * beats)
        since = min(since, int(earlier[-1]) if len(earlier) else 0)
        return min(since, at - round(STILL_FRAMES * patience)) - 1
