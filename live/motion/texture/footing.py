"""Footing: feet that stand go on standing where the sketch has them, whatever pelvis and legs get (P020).

The order is the paper's: the pelvis and the upper body first; then the legs reach for the sketch's feet; that motion
is textured in the legs, only while a foot is off the floor.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.editing.feet import ANKLES, find_feet
from live.motion.editing.floor import correct_floor, cover
from live.motion.editing.legs import reach_with_feet
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.texture.charts import Chart
from live.motion.texture.texture_settings import LEGS

Float64 = npt.NDArray[np.float64]
Float = npt.NDArray[np.floating]
Bool = npt.NDArray[np.bool_]

EASE: Final = 0.12
"""Seconds beside a stance over which a leg's texture comes and goes."""
LOW: Final = 0.05
"""A sole lower than this [m] goes where the sketch has it."""
STRETCHED: Final = 0.992
"""The hips sink rather than stretch a leg to more than this share of its length, or than the sketch does."""
_HIPS: Final = tuple(SKELETON.index(side + "UpperLeg") for side in ("left", "right"))
_LEG: Final = float(
    sum(np.linalg.norm(SKELETON.offsets[SKELETON.index(f"left{joint}")]) for joint in ("LowerLeg", "Foot"))
)
_SIDE_OF: Final = {joint: 0 if SKELETON.names[joint].startswith("left") else 1 for joint in LEGS}


def stand(sketch: Clip, root: Float, rotation: Float, legs: Mapping[int, Float64], charts: Sequence[Chart]) -> Clip:
    """The clip with the hips at `root` (T, 3), `rotation` (T, J, 4) above the legs, and the legs' texture.

    `legs` holds for joints of the legs what is added to their angles (T, 3) in the `charts`. Ankles and feet are where
    `sketch` has them while they are in contact; where a leg does not reach, the hips sink.
    """
    moved = not np.array_equal(root, sketch.root_position) or not np.array_equal(rotation[:, 0], sketch.rotation[:, 0])
    if moved:
        position, world = forward_kinematics(
            sketch.root_position.astype(np.float64), sketch.rotation.astype(np.float64)
        )
        ankles, feet = position[:, ANKLES], world[:, ANKLES]
        legs_own = np.linalg.norm(position[:, _HIPS] - ankles, axis=-1)
        root = _sunk(root, rotation, ankles, np.maximum(legs_own, STRETCHED * _LEG), sketch.sample_rate)
        rotation = reach_with_feet(root, rotation, ankles, feet)
    if legs:
        free = freedom(sketch.contact, find_feet(sketch).height, sketch.sample_rate)
        for joint, change in legs.items():
            angles = charts[joint].angles(rotation[:, joint]) + free[:, _SIDE_OF[joint], None] * change
            rotation[:, joint] = np.where(
                free[:, _SIDE_OF[joint], None] > 0.0, charts[joint].rotations(angles), rotation[:, joint]
            )
    clip = replace(
        sketch,
        root_position=np.ascontiguousarray(root, np.float32),
        rotation=np.ascontiguousarray(quaternion.continuous(rotation), np.float32),
    )
    return correct_floor(clip).clip if legs or moved else clip


def freedom(contact: Bool, height: Float, rate: float) -> Float64:
    """How much texture each leg may have, (T, 2), smooth in time: none while its foot is in contact or its sole, at
    `height` (T, 2) [m], is low, for it would skate; all from `EASE` away from that on."""
    held = (contact | (height < LOW)).astype(np.float64)
    return np.asarray(1.0 - cover(held, max(1, round(0.5 * EASE * rate))))


def _sunk(root: Float, rotation: Float, ankles: Float, longest: Float, rate: float) -> Float:
    """The hips lowered, softly in time, so that no leg is longer than `longest` (T, 2) [m]."""
    for _ in range(2):
        position, _ = forward_kinematics(root, rotation)
        way = position[:, _HIPS] - ankles
        flat = way[..., 0] ** 2 + way[..., 2] ** 2
        highest = np.sqrt(np.maximum(longest**2 - flat, 0.0))
        depth = np.maximum(way[..., 1] - highest, 0.0).max(axis=1, keepdims=True)
        if not depth.any():
            return root
        root = root - np.array((0.0, 1.0, 0.0)) * cover(depth, max(1, round(0.08 * rate)))
    return root
