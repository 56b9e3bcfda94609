"""Orientation: which way a body faces over a clip, and the whole clip turned to the public (T122)."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip

Float64 = npt.NDArray[np.float64]

_UPRIGHT = 0.2
"""A forward axis whose level part is shorter than this points up or down, and says nothing about the heading."""


def heading_of(rotation: npt.NDArray[np.floating]) -> Float64:
    """Heading [rad] of world rotations (..., 4): 0 faces the public (+z), positive towards +x, in [-π, π].

    Of their forward axis, or, where that points up or down (lying, bent double), of what is to the right of their left.
    """
    rotation = np.asarray(rotation, np.float64)
    forward = quaternion.rotate(rotation, np.array((0.0, 0.0, 1.0)))
    left = quaternion.rotate(rotation, np.array((1.0, 0.0, 0.0)))
    level = np.hypot(forward[..., 0], forward[..., 2]) >= _UPRIGHT
    return np.asarray(
        np.where(level, np.arctan2(forward[..., 0], forward[..., 2]), np.arctan2(-left[..., 2], left[..., 0]))
    )


def circular_mean(headings: npt.ArrayLike) -> float:
    """Direction [rad] of the sum of unit vectors towards all `headings`; 0 where they cancel (T122)."""
    total = complex(np.exp(1j * np.asarray(headings, np.float64)).sum())
    return float(np.angle(total)) if abs(total) > 1e-9 * max(1, np.size(headings)) else 0.0


def average_orientation(clip: Clip) -> float:
    """The mean heading of the hips over the clip [rad]."""
    return circular_mean(heading_of(clip.rotation[:, 0]))


def turn_clip(clip: Clip, yaw: float) -> Clip:
    """The whole clip turned by `yaw` [rad] about the place where the hips are at its first sample."""
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(yaw))
    centre = clip.root_position[0].astype(np.float64) * (1.0, 0.0, 1.0)
    rotation = clip.rotation.astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    return replace(
        clip,
        root_position=(quaternion.rotate(turn, clip.root_position - centre) + centre).astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
    )


def face_public(clip: Clip) -> Clip:
    """The clip turned so that its average orientation is zero (T122): for what a random walk has put together."""
    return turn_clip(clip, -average_orientation(clip))
