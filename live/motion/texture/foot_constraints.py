"""Constraints on textured motion: planted feet stay in place, and measure lines stay close to the sketch (P020).

The order is the paper's: first the pelvis and the upper body, then IK brings the legs to the sketch's feet, then the
legs are textured, only while a foot is off the floor.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothstep
from live.motion.editing.foot_correction import (
    ANKLES,
    LEG_LENGTH,
    MAX_LEG_SHARE,
    UPPER_LEGS,
    correct_floor,
    find_feet,
    lower_hips,
    smooth_upper_bound,
    solve_legs,
)
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.frequency_bands import Chart
from live.motion.texture.texture_settings import LEGS, UPPER

FADE_S: Final = 0.12
"""Time over which a leg's texture fades in and out next to a stance [s]."""
MAX_SOLE_HEIGHT: Final = 0.05
"""A sole lower than this [m] is kept where the sketch has it."""
_SIDE_OF: Final = {joint: 0 if SKELETON.names[joint].startswith("left") else 1 for joint in LEGS}


def apply_foot_constraints(
    sketch: Clip, root: Float, rotation: Float, legs: Mapping[int, Float64], charts: Sequence[Chart]
) -> Clip:
    """Return the clip with the hips at `root` (T, 3), `rotation` (T, J, 4) above the legs, and textured legs.

    `legs` maps leg joints to the offsets (T, 3) added to their angles in the `charts`. Ankles and feet stay where
    `sketch` has them while they are in contact. Where a leg does not reach, the hips sink.
    """
    moved = not np.array_equal(root, sketch.root_position) or not np.array_equal(rotation[:, 0], sketch.rotation[:, 0])
    if moved:
        position, world = forward_kinematics(
            sketch.root_position.astype(np.float64), sketch.rotation.astype(np.float64)
        )
        ankles, feet = position[:, ANKLES], world[:, ANKLES]
        legs_own = np.linalg.norm(position[:, UPPER_LEGS] - ankles, axis=-1)
        root = lower_hips(root, rotation, ankles, np.maximum(legs_own, MAX_LEG_SHARE * LEG_LENGTH), sketch.sample_rate)
        rotation = solve_legs(root, rotation, ankles, feet)
    if legs:
        free = texture_weights(sketch.contact, find_feet(sketch).height, sketch.sample_rate)
        for joint, change in legs.items():
            angles = charts[joint].angles(rotation[:, joint]) + free[:, _SIDE_OF[joint], None] * change
            rotation[:, joint] = np.where(
                free[:, _SIDE_OF[joint], None] > 0.0, charts[joint].rotations(angles), rotation[:, joint]
            )
    clip = replace(
        sketch,
        root_position=np.ascontiguousarray(root, np.float32),
        rotation=np.ascontiguousarray(quaternion.align_signs(rotation), np.float32),
    )
    return correct_floor(clip).clip if legs or moved else clip


def texture_weights(contact: Bool, height: Float, rate: float) -> Float64:
    """Return the weight of texture for each leg, (T, 2), smooth in time.

    It is 0 while the foot is in contact or its sole, at `height` (T, 2) [m], is low, because the foot would skate.
    It is 1 from `FADE_S` away from that.
    """
    held = (contact | (height < MAX_SOLE_HEIGHT)).astype(np.float64)
    return np.asarray(1.0 - smooth_upper_bound(held, max(1, round(0.5 * FADE_S * rate))))


MAX_DISTANCE_M: Final = 0.06
"""Largest rms distance of upper joints from the sketch's at a measure line: well within the transition threshold."""
WINDOW_BEATS: Final = 0.75
"""Window before a measure line in which poses are compared and blended (T036)."""
FADE_BEATS: Final = 0.5
"""Duration of the fade in and out."""
_ALL: Final = SKELETON.joint_count


def blend_to_sketch(
    step: StepClip, textured: Clip, max_distance: float = MAX_DISTANCE_M
) -> tuple[Clip, tuple[float, float]]:
    """Blend `textured`, a clip of the sketch `step`, towards the sketch near both measure lines.

    Steps are joined where poses at their measure lines are alike, so the upper body returns towards the sketch there,
    by no more than needed. Legs and hips stay: they hardly differ from the sketch's. Return the clip and the share of
    texture left at both measure lines, 0 to 1.
    """
    beat = step.samples_per_measure / step.beats_per_measure
    first, last = step.first, step.first + step.measures * step.samples_per_measure
    begin = _texture_share(step.clip, textured, first - WINDOW_BEATS * beat, first, max_distance)
    end = _texture_share(step.clip, textured, last - WINDOW_BEATS * beat, last, max_distance)
    at = np.arange(textured.sample_count)
    rise = smoothstep((at - first) / (FADE_BEATS * beat))
    fall = smoothstep((last - WINDOW_BEATS * beat - at) / (FADE_BEATS * beat))
    share = np.minimum(begin + (1.0 - begin) * rise, end + (1.0 - end) * fall)
    rotation = textured.rotation.astype(np.float64)
    joints = list(UPPER)
    rotation[:, joints] = quaternion.slerp(step.clip.rotation[:, joints], rotation[:, joints], share[:, None])
    signed = np.ascontiguousarray(quaternion.align_signs(rotation), np.float32)
    return replace(textured, rotation=signed), (begin, end)


def _texture_share(sketch: Clip, textured: Clip, first: float, last: float, max_distance: float) -> float:
    """Return the share of texture at which joints are `max_distance` from the sketch's between two samples."""
    part = slice(max(0, int(first)), int(np.ceil(last)) + 1)
    places = []
    for clip in (sketch, textured):
        rotation = clip.rotation[part].astype(np.float64)
        rotation[:, 0] = (1.0, 0.0, 0.0, 0.0)
        places.append(forward_kinematics(np.zeros((len(rotation), 3)), rotation)[0])
    apart = float(
        np.sqrt((np.linalg.norm(places[0] - places[1], axis=-1)[:, list(UPPER)] ** 2).sum(axis=1).max() / _ALL)
    )
    return min(1.0, max_distance / max(apart, 1e-9))
