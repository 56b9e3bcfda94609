"""Names for found steps, in words of dancers: where the step goes, turns, jumps, what the legs and arms do.

A name depends on the step's most typical occurrence alone, so that the same recording gives the same names again. Steps
that would have one name are numbered in order of appearance.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.graph.node_features import heading_of
from live.graph.step_library import plain_name
from live.graph.vocabulary.measures import Measures
from live.motion.skeleton import SKELETON
from live.motion.step_clip import IN_PLACE_DISTANCE, LONG_DISTANCE

QUARTER_TURN: Final = 60.0
HALF_TURN: Final = 135.0
WHOLE_TURN: Final = 270.0
"""Change of heading over the step from which it is called a quarter, a half or a full turn [degrees]."""
LOW_HIPS: Final = 0.82
FLOOR_HIPS: Final = 0.5
"""Height of the hips, as a share of that when standing, below which a dance is low, or on the floor."""
JUMP_HEIGHT: Final = 0.1
"""Height of both feet over where they stand from which a step is a jump [m]."""
KICK_HEIGHT: Final = 0.5
"""The same of one foot for a kick [m]."""
RANGE: Final = 0.3
"""Way of the hips there and back [m] from which a step in place goes from side to side, or forward and back."""
SWAY: Final = 0.06
"""The same for a sway [m]."""
ARM_SHARE: Final = 0.4
"""Share of the step for which an arm must be held so that the name says it."""
WIDE_HAND: Final = 0.5
"""Horizontal distance of a hand from the neck with an arm held out to the side [m]."""
_HEAD, _HIPS, _NECK = (SKELETON.index(name) for name in ("head", "hips", "neck"))
_HANDS, _SHOULDERS, _FEET, _TOES = (
    [SKELETON.index(side + name) for side in ("left", "right")] for name in ("Hand", "UpperArm", "Foot", "Toes")
)
_SIDES: Final = ("left", "right")


@dataclass(frozen=True, slots=True, eq=False)
class StepFacts:
    """What a step does, in the dancer's axes at its beginning."""

    pose: Float64
    """Poses of the typical occurrence, hips at x = z = 0 and facing +z at the beginning [m], (K, J, 3)."""
    contact: Bool
    """Left and right foot on the floor, (K, 2)."""
    turn: float
    """Change of heading, positive to the dancer's left [rad]."""
    way: tuple[float, float]
    """Travel to the left (x) and ahead (z) [m]."""
    measures: int
    seconds: float
    """Length of the typical occurrence [s]."""

    @property
    def distance_m(self) -> float:
        """Length of the travel [m]."""
        return float(np.hypot(*self.way))


def step_facts(measures: Measures, start: int, length: int) -> StepFacts:
    """Return the facts of the `length` measures from `start` on."""
    pose = np.concatenate([measures.pose[start + n, (1 if n else 0) :] for n in range(length)])
    contact = np.concatenate([measures.contact[start + n, (1 if n else 0) :] for n in range(length)])
    heading = np.unwrap(heading_of(pose))
    place = (pose - pose[0, _HIPS] * (1.0, 0.0, 1.0)) @ _turned(-heading[0])
    return StepFacts(
        pose=place,
        contact=contact,
        turn=float(heading[-1] - heading[0]),
        way=(float(place[-1, _HIPS, 0]), float(place[-1, _HIPS, 2])),
        measures=length,
        seconds=float(measures.seconds[start : start + length].sum()),
    )


def _turned(yaw: float) -> Float64:
    """Return the matrix that turns row vectors by `yaw` about +Y: +z towards +x."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def standing_heights(measures: Measures) -> tuple[float, float]:
    """Return the heights of the hips and of the ankles of the standing dancer [m]."""
    hips = float(np.percentile(measures.pose[:, :, _HIPS, 1], 90.0))
    return hips, float(np.percentile(measures.pose[:, :, _FEET, 1], 10.0))


def name_steps(facts: Sequence[StepFacts], heights: tuple[float, float], taken: Iterable[str] = ()) -> list[str]:
    """Return a name for each step; equal ones are numbered, and no name is one of `taken`."""
    used = {plain_name(name) for name in taken}
    names = []
    for fact in facts:
        base = name = describe_step(fact, heights)
        number = 1
        while plain_name(name) in used:
            number += 1
            name = f"{base} {number}"
        used.add(plain_name(name))
        names.append(name)
    return names


def describe_step(facts: StepFacts, heights: tuple[float, float]) -> str:
    """Return the words for one step, such as "quarter turn left, arms high"."""
    hips, ankle = heights
    words = [_main_words(facts, ankle)]
    height = float(np.median(facts.pose[:, _HIPS, 1])) / hips
    if height < FLOOR_HIPS:
        words = [f"{words[0]} on the floor"]
    elif height < LOW_HIPS:
        words.append("low")
    lifted = facts.pose[:, _FEET, 1].max(axis=0) - ankle
    if lifted.max() > KICK_HEIGHT and height >= FLOOR_HIPS:
        words.append("kicks" if lifted.min() > KICK_HEIGHT else f"kick {_SIDES[int(np.argmax(lifted))]}")
    return ", ".join([*words, *_arm_words(facts.pose)])


def _main_words(facts: StepFacts, ankle: float) -> str:
    """Return what the step does on the floor."""
    air = facts.pose[:, _FEET, 1].min(axis=1) - ankle > JUMP_HEIGHT
    jump = bool((air[1:] & air[:-1]).any())
    degrees = np.degrees(abs(facts.turn))
    if degrees >= QUARTER_TURN:
        size = "quarter" if degrees < HALF_TURN else "half" if degrees < WHOLE_TURN else "full"
        return f"{'jump, ' if jump else ''}{size} turn {'left' if facts.turn > 0 else 'right'}"
    far = facts.distance_m / facts.measures
    x, z = facts.way
    where = ("forward" if z > 0 else "back") if abs(z) >= abs(x) else ("left" if x > 0 else "right")
    if far >= IN_PLACE_DISTANCE:
        return f"{'jump' if jump else 'travel' if far >= LONG_DISTANCE else 'step'} {where}"
    if jump:
        return "jump in place"
    across, ahead = np.ptp(facts.pose[:, _HIPS, 0]), np.ptp(facts.pose[:, _HIPS, 2])
    if max(across, ahead) >= RANGE:
        return "side to side" if across > ahead else "forward and back"
    landings = int((facts.contact[1:] & ~facts.contact[:-1]).sum())
    if landings >= facts.measures + 1:
        return "step in place"
    if landings:
        return "touch"
    return "sway" if max(across, ahead) >= SWAY else "stand"


def _arm_words(pose: Float64) -> list[str]:
    """Return what the arms do for much of the step, if anything."""
    high = (pose[:, _HANDS, 1] > pose[:, [_HEAD], 1]).mean(axis=0) >= ARM_SHARE
    if high.all():
        return ["arms high"]
    if high.any():
        return [f"{_SIDES[int(np.argmax(high))]} arm high"]
    flat = np.hypot(*np.moveaxis((pose[:, _HANDS] - pose[:, [_NECK]])[..., (0, 2)], -1, 0))
    level = np.abs(pose[:, _HANDS, 1] - pose[:, _SHOULDERS, 1]) < 0.25
    wide = ((flat > WIDE_HAND) & level).mean(axis=0) >= ARM_SHARE
    if wide.all():
        return ["arms wide"]
    return [f"{_SIDES[int(np.argmax(wide))]} arm out"] if wide.any() else []
