"""Footfall detection: time, place and strength of the dancers' footfalls, for sound (T130)."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.base.stage_snapshot import StageView
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.show.show import Show

BALL: Final = 0
HEEL: Final = 1
FLAT: Final = 2
"""The part of a shoe that strikes; FLAT: both at once, a stamp."""

_ANKLES: Final = np.array([SKELETON.index(f"{side}Foot") for side in ("left", "right")])
_TOES: Final = np.array([SKELETON.index(f"{side}Toes") for side in ("left", "right")])
SAMPLE_INTERVAL: Final = 1.0 / 240.0
"""Sampling interval of contacts [s]: a brush of the floor may be shorter than a frame."""
RAISED: Final = 0.022
"""A heel or ball of a standing foot raised to this height [m] strikes when it comes down ..."""
DOWN: Final = 0.004
"""... to this height [m]."""
LANDED: Final = 0.012
"""A foot of a dancer captured live stands once its sole is this near to the floor [m], until it is RAISED."""
MIN_STRENGTH: Final = 0.35
FULL_STRENGTH_LIFT: Final = 0.12
"""A foot that falls from this height [m] strikes with full strength; one that never left the floor, with SOFTEST."""


@dataclass(frozen=True, slots=True)
class Footfall:
    """One strike of one shoe."""

    time: float
    """Seconds of the show."""
    dancer: int
    foot: int
    """0 left, 1 right."""
    part: int
    """BALL, HEEL or FLAT."""
    strength: float
    """0 to 1."""
    place: tuple[float, float]
    """On the stage (x, z) [m]."""


class FootfallDetector:
    """Finds the footfalls between frames. `detect` must be called for every frame, right after it was filled.

    A foot strikes when the clips annotate a new contact, at the exact moment whatever the frame rate, and when the heel
    or ball of a standing foot comes down in the drawn frames.
    """

    def __init__(self, show: Show) -> None:
        self._show = show
        self._time: float | None = None
        feet = (len(show.group), 2)
        self._contact: Bool = np.ones(feet, np.bool_)
        self._highest: Float64 = np.zeros(feet)
        self._heights: Float64 = np.zeros((2, *feet))
        self._raised: Bool = np.zeros((2, *feet), np.bool_)

    def detect(self, view: StageView) -> list[Footfall]:
        """Return the footfalls since the last frame, in order of time."""
        position = view.joint_position
        there = view.present
        heights = np.stack((position[:, _TOES, 1] - TOES_OVER_SOLE, position[:, _ANKLES, 1] - SOLE_BELOW_ANKLE)).astype(
            np.float64
        )  # (ball or heel, A, foot)
        if self._time is None:
            self._time, self._heights, self._raised = view.time, heights, heights > RAISED
            self._contact = self._show.dancers.contact(self._fraction(view.time))
            return []
        before = self._time
        falls = [fall for fall in self._landings(before, view, heights) if there[fall.dancer]]
        landed = {(fall.dancer, fall.foot) for fall in falls}
        drops = self._drops(before, view, heights)
        falls += [fall for fall in drops if there[fall.dancer] and (fall.dancer, fall.foot) not in landed]
        self._time, self._heights = view.time, heights
        return sorted(falls, key=lambda fall: (fall.time, fall.dancer, fall.foot, fall.part))

    def _fraction(self, time: float) -> float:
        return self._show.span.fraction(self._show.timeline.beat_at(time))

    def _landings(self, before: float, view: StageView, heights: Float64) -> list[Footfall]:
        """Return the footfalls from contacts in the clips. A fall just before a measure line is reported on it."""
        falls: list[Footfall] = []
        steps = max(1, math.ceil((view.time - before) / SAMPLE_INTERVAL))
        was, seen = self._contact, self._show.dancers.captured_dancers()
        for step in range(1, steps + 1):
            time = before + (view.time - before) * step / steps
            contact = self._show.dancers.contact(self._fraction(float(time)))
            if len(seen):  # dancers captured live have no clip annotations
                low = heights[:, seen].min(axis=0)
                contact[seen] = np.where(was[seen], low < RAISED, low < LANDED) if step == steps else was[seen]
            for dancer, foot in np.argwhere(contact & ~was):
                ball, heel = heights[:, dancer, foot]
                part = BALL if heel > RAISED else HEEL if ball > RAISED else FLAT
                strength = min(
                    MIN_STRENGTH + (1.0 - MIN_STRENGTH) * self._highest[dancer, foot] / FULL_STRENGTH_LIFT, 1.0
                )
                falls.append(self._fall(float(time), view, int(dancer), int(foot), part, strength))
            was = contact
        self._contact = was.copy()
        self._highest = np.where(was, 0.0, np.maximum(self._highest, heights.min(axis=0)))
        return falls

    def _drops(self, before: float, view: StageView, heights: Float64) -> list[Footfall]:
        """Return the footfalls of heels and balls of standing feet."""
        falls: list[Footfall] = []
        down = self._raised & (heights < DOWN) & self._contact
        for part, dancer, foot in np.argwhere(down):
            high, low = self._heights[part, dancer, foot], heights[part, dancer, foot]
            share = min(max((high - DOWN) / max(high - low, 1e-6), 0.0), 1.0)
            time = before + share * (view.time - before)
            falls.append(self._fall(time, view, int(dancer), int(foot), HEEL if part else BALL, 0.6))
        self._raised = (self._raised | (heights > RAISED)) & (heights >= DOWN)
        return falls

    @staticmethod
    def _fall(time: float, view: StageView, dancer: int, foot: int, part: int, strength: float) -> Footfall:
        x, _, z = view.joint_position[dancer, _ANKLES[foot]]
        return Footfall(time, dancer, foot, part, float(strength), (float(x), float(z)))
