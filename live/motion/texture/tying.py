"""Tying: a textured step begins and ends so near to its sketch that whatever joins the one joins the other.

Steps are joined where poses at their measure lines are alike. A sketch's arms may be anywhere there as far as the
recordings know, so there the upper body goes back towards the sketch, no farther than it must.
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.texture_settings import UPPER

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]

APART_M: Final = 0.06
"""How far upper joints may be from the sketch's at a measure line, root mean square: well within what is joined."""
WINDOW_BEATS: Final = 0.75
"""How long before a measure line poses are compared and blended (T036)."""
EASE_BEATS: Final = 0.5
"""How long it takes to come and to go."""
_ALL: Final = SKELETON.joint_count


def tied(step: StepClip, textured: Clip, most: float = APART_M) -> tuple[Clip, tuple[float, float]]:
    """`textured`, a clip of the sketch `step`, tied to it; and how much of it is left at both measure lines, 0 to 1.

    Legs and hips stay: they hardly leave the sketch's.
    """
    beat = step.samples_per_measure / step.beats_per_measure
    first, last = step.first, step.first + step.measures * step.samples_per_measure
    begin = _kept(step.clip, textured, first - WINDOW_BEATS * beat, first, most)
    end = _kept(step.clip, textured, last - WINDOW_BEATS * beat, last, most)
    at = np.arange(textured.sample_count)
    rise = _ease((at - first) / (EASE_BEATS * beat))
    fall = _ease((last - WINDOW_BEATS * beat - at) / (EASE_BEATS * beat))
    share = np.minimum(begin + (1.0 - begin) * rise, end + (1.0 - end) * fall)
    rotation = textured.rotation.astype(np.float64)
    joints = list(UPPER)
    rotation[:, joints] = quaternion.slerp(step.clip.rotation[:, joints], rotation[:, joints], share[:, None])
    signed = np.ascontiguousarray(quaternion.continuous(rotation), np.float32)
    return replace(textured, rotation=signed), (begin, end)


def _kept(sketch: Clip, textured: Clip, first: float, last: float, most: float) -> float:
    """The share of the texture with which joints are `most` from the sketch's between two samples."""
    part = slice(max(0, int(first)), int(np.ceil(last)) + 1)
    places = []
    for clip in (sketch, textured):
        rotation = clip.rotation[part].astype(np.float64)
        rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
        places.append(forward_kinematics(np.zeros((len(rotation), 3)), rotation)[0])
    apart = float(
        np.sqrt((np.linalg.norm(places[0] - places[1], axis=-1)[:, list(UPPER)] ** 2).sum(axis=1).max() / _ALL)
    )
    return min(1.0, most / max(apart, 1e-9))


def _ease(u: Float) -> Float64:
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))
