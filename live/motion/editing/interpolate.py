"""Interpolation between two clips of one step: diagonal from side and forward walk, any length from short and long."""

from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.clip import read_clip
from live.motion.editing.foot_correction import ANKLES, BALLS, solve_legs
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import (
    StepClip,
    check_same_structure,
    corresponding_samples,
    measured_direction,
    measured_distance,
)

_FULL_TURN_COSINE: Final = -0.98
"""Below this cosine (on S³) the arc is nearly a full turn and ill-defined: the shorter arc is used."""


def interpolate(a: StepClip, b: StepClip, weight: float, *, hold_feet: bool = True) -> StepClip:
    """Return the clip that is `a` at weight 0 and `b` at 1: SLERP per joint, linear root, no time alignment (T045).

    The arc between two rotations is the shorter one at the start of the step and then changes continuously, so that it
    never jumps to the other side when the two headings diverge. A foot is in contact if it is in both clips.
    Interpolated joints alone let planted feet slide. With `hold_feet`, leg IK puts the balls of the feet at their
    interpolated positions, so a foot that is planted in both clips stays planted. Without it the legs are plain SLERP.

    At weights between 0 and 1 the result has the tempo and the samples of `a`; direction and distance are measured
    (T047). ValueError for clips of different steps or different structural variations (T046), or a weight outside
    [0, 1].
    """
    if not 0.0 <= weight <= 1.0:
        raise ValueError(f"weight {weight}: 0 to 1 expected")
    check_same_structure(a, b)
    if weight in (0.0, 1.0):
        return b if weight else a
    root_a, rotation_a = a.clip.root_position.astype(np.float64), a.clip.rotation.astype(np.float64)
    root_b, rotation_b, contact = read_clip(b.clip, corresponding_samples(b, a))
    begin = round(a.first)
    root = (1.0 - weight) * root_a + weight * root_b
    rotation = follow_arc(rotation_a, rotation_b, weight, begin)
    if hold_feet:
        poses = [forward_kinematics(*pose) for pose in ((root_a, rotation_a), (root_b, rotation_b))]
        feet = follow_arc(poses[0][1][:, ANKLES], poses[1][1][:, ANKLES], weight, begin)
        balls = (1.0 - weight) * poses[0][0][:, BALLS] + weight * poses[1][0][:, BALLS]
        soles = quaternion.rotate(feet, SKELETON.offsets[list(BALLS)].astype(np.float64))
        rotation = solve_legs(root, rotation, balls - soles, feet)
    clip = replace(
        a.clip,
        name=f"{a.clip.name} + {weight:.0%} {b.clip.name}",
        root_position=root.astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        contact=a.clip.contact & contact,
    )
    step = replace(a, clip=clip)
    return replace(step, direction=measured_direction(step), distance_m=measured_distance(step))


def follow_arc(a: Float, b: Float, weight: float, begin: int) -> Float:
    """SLERP from `a` to `b` (T, ..., 4) along arcs that are continuous in time and the shorter ones at `begin`."""
    a, b = quaternion.align_signs(a), quaternion.align_signs(b)
    begin = min(max(begin, 0), len(a) - 1)
    b = b * np.where(np.sum(a[begin] * b[begin], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(cosine < _FULL_TURN_COSINE, -b, b)
    angle = np.arccos(np.clip(np.where(cosine < _FULL_TURN_COSINE, -cosine, cosine), -1.0, 1.0))
    near = angle < 1e-4  # linear interpolation: the sine is too small to divide by
    sine = np.where(near, 1.0, np.sin(angle))
    weight_a = np.where(near, 1.0 - weight, np.sin((1.0 - weight) * angle) / sine)
    weight_b = np.where(near, weight, np.sin(weight * angle) / sine)
    return quaternion.unit(weight_a * a + weight_b * b)
