"""Floor height of a recording, and hip positions that keep the supporting feet in place."""

from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.rest_pose_alignment import SIDES, SourcePoints
from live.motion.skeleton import SKELETON

SUPPORT_HEIGHT: Final = 0.05
"""The weight of a foot in placing the hips falls by a factor e per this height [m] over its floor."""
FLOOR_PERCENTILE: Final = 5.0
DRIFT_HEIGHT: Final = 0.08
"""If the lowest sole is this high [m] over the floor for half of the time, the recording drifts vertically."""
DRIFT_WINDOW: Final = 2.0
"""Window [s] in which a foot certainly touches the floor (a jump lasts less than 1 s)."""
_HIP_MIDDLE: Final = SKELETON.offsets[SKELETON.index("leftUpperLeg")].astype(np.float64) * (0.0, 1.0, 1.0)


def find_floor(lowest: Float, sample_rate: float) -> Float:
    """Return the floor height [m] at each sample, (T,), from the height `lowest` (T,) of the lowest sole."""
    floor = np.full(lowest.shape, np.percentile(lowest, FLOOR_PERCENTILE))
    if np.median(lowest - floor) < DRIFT_HEIGHT:
        return floor
    half = max(1, round(0.5 * DRIFT_WINDOW * sample_rate))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(lowest, half, mode="edge"), 2 * half + 1)
    least = np.pad(windows.min(axis=-1), half, mode="edge")
    return np.asarray(np.convolve(least, np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid"))


def place_hips(points: SourcePoints, world: Float, rotation: Float, scale: float) -> Float:
    """Return hip positions [m], (T, 3): between the source's hip joints, then moved so that supporting feet stay in
    place.

    Legs of other proportions put the feet a few centimetres away from the source's. The hips compensate that
    difference, weighted by each foot's height over the floor; bone directions do not change.
    """
    root = scale * points.middle("UpperLeg") - quaternion.rotate(world[:, 0], _HIP_MIDDLE)
    positions, _ = forward_kinematics(root, rotation)
    total, weights = np.zeros_like(root), np.full((len(root), 1), 1e-9)
    for side, _ in SIDES:
        target = scale * points.at(side + "Foot")
        height = target[:, 1] - np.percentile(target[:, 1], FLOOR_PERCENTILE)
        weight = np.exp(-np.clip(height / SUPPORT_HEIGHT, 0.0, 15.0))[:, None]
        total += weight * (target - positions[:, SKELETON.index(side + "Foot")])
        weights += weight
    return np.asarray(root + total / weights)
