"""What can be measured of a step clip: its way (T040, T131), its contacts on the beats, how far its feet slide."""

import itertools
import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

IN_PLACE: Final = 0.15
"""A step that gets less than this far [m] in a measure is danced in place."""
LONG: Final = 0.55
"""A step that gets farther than this [m] in a measure is a long one (T131: sketches go 0.35 or 0.75)."""
_FEET: Final = tuple((SKELETON.index(f"{side}Foot"), SKELETON.index(f"{side}Toes")) for side in ("left", "right"))


def travel(step: StepClip) -> Float64:
    """Way of the hips (x, z) [m] from the first to the last measure line, in the clip's own axes, shape (2,)."""
    ends = np.array((step.first, step.first + step.measures * step.samples_per_measure))
    low = np.clip(ends.astype(np.int64), 0, step.clip.sample_count - 1)
    high = np.minimum(low + 1, step.clip.sample_count - 1)
    part = (ends - low)[:, None]
    root = step.clip.root_position.astype(np.float64)
    begin, end = ((1.0 - part) * root[low] + part * root[high])[:, (0, 2)]
    return np.asarray(end - begin, np.float64)


def measured_distance(step: StepClip) -> float:
    """Length of that way [m]."""
    return float(np.hypot(*travel(step)))


def measured_direction(step: StepClip) -> str:
    """The one of DIRECTIONS (T131) that comes nearest to the way: clips begin facing +z, her left is at +x."""
    x, z = travel(step)
    distance = math.hypot(x, z) / step.measures
    if distance < IN_PLACE:
        return "in place"
    size = "short" if distance < LONG else "long"
    if abs(z) >= abs(x):
        return f"{size} {'forward' if z > 0 else 'back'}"
    return f"{size} {'left' if x > 0 else 'right'}"


def beat_contacts(step: StepClip) -> Float64:
    """Share of each beat during which the left and the right foot are on the floor, 0 to 1, shape (beats, 2)."""
    per_beat = step.samples_per_measure / step.beats_per_measure
    edges = np.round(step.first + np.arange(step.beats + 1) * per_beat).astype(np.int64)
    edges = np.clip(edges, 0, step.clip.sample_count - 1)
    return np.stack(
        [step.clip.contact[low : max(high, low + 1)].mean(axis=0) for low, high in itertools.pairwise(edges)]
    )


def foot_slide(step: StepClip) -> float | None:
    """Mean speed over the floor [m/s] of the feet while they are in contact; None if neither ever is.

    Of heel and ball the one that stands stiller counts, as in the report of a film.
    """
    first, last = int(step.first), math.ceil(step.first + step.measures * step.samples_per_measure)
    part = slice(first, last + 1)
    position, _ = forward_kinematics(
        step.clip.root_position[part].astype(np.float64), step.clip.rotation[part].astype(np.float64)
    )
    feet = position[:, np.array(_FEET)]  # (T, foot, heel or ball, 3)
    moved = np.hypot(*np.diff(feet, axis=0)[..., (0, 2)].transpose(3, 0, 1, 2)) * step.clip.sample_rate
    stands = step.clip.contact[part][1:] & step.clip.contact[part][:-1]
    speed = moved.min(axis=-1)[stands]
    return float(speed.mean()) if len(speed) else None
