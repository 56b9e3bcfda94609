"""Orientation of clips: mean facing and turning a clip to the audience (T122), and head facing (T123-T125).

Head facing keeps the head towards the audience while the body turns, within the limits of the neck.
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import gaussian_filter
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

_MIN_HORIZONTAL = 0.2
"""A forward axis with a shorter horizontal part points up or down and defines no heading."""


def heading_of(rotation: npt.NDArray[np.floating]) -> Float64:
    """Return the heading [rad] of world rotations (..., 4): 0 faces the audience (+z), positive towards +x, in [-π, π].

    It is that of the forward axis, or, if that points up or down (lying, bent double), perpendicular to the left axis.
    """
    rotation = np.asarray(rotation, np.float64)
    forward = quaternion.rotate(rotation, np.array((0.0, 0.0, 1.0)))
    left = quaternion.rotate(rotation, np.array((1.0, 0.0, 0.0)))
    level = np.hypot(forward[..., 0], forward[..., 2]) >= _MIN_HORIZONTAL
    return np.asarray(
        np.where(level, np.arctan2(forward[..., 0], forward[..., 2]), np.arctan2(-left[..., 2], left[..., 0]))
    )


def circular_mean(headings: npt.ArrayLike) -> float:
    """Return the direction [rad] of the sum of unit vectors towards all `headings`; 0 if they cancel (T122)."""
    total = complex(np.exp(1j * np.asarray(headings, np.float64)).sum())
    return float(np.angle(total)) if abs(total) > 1e-9 * max(1, np.size(headings)) else 0.0


def average_orientation(clip: Clip) -> float:
    """Return the mean heading of the hips over the clip [rad]."""
    return circular_mean(heading_of(clip.rotation[:, 0]))


def turn_clip(clip: Clip, yaw: float) -> Clip:
    """Return the whole clip turned by `yaw` [rad] about the hips' position at its first sample."""
    turn = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(yaw))
    centre = clip.root_position[0].astype(np.float64) * (1.0, 0.0, 1.0)
    rotation = clip.rotation.astype(np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    return replace(
        clip,
        root_position=(quaternion.rotate(turn, clip.root_position - centre) + centre).astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
    )


def face_audience(clip: Clip) -> Clip:
    """Return the clip turned so that its average orientation is zero (T122), for clips built by a random walk."""
    return turn_clip(clip, -average_orientation(clip))


HEAD_LIMIT: Final = np.radians(60.0)
"""The head turns no farther than this to either side (T124)."""
SIGMA: Final = 0.12
"""Width of the Gaussian [s] that smooths the added turn (T124; not printed there)."""
NECK_SHARE: Final = 0.5
"""Share of the added turn applied at the neck; the head's world rotation follows T125 in any case."""

_CHEST, _NECK, _HEAD = (SKELETON.index(name) for name in ("upperChest", "neck", "head"))
_Y: Final = np.array((0.0, 1.0, 0.0))


def face_head(
    clip: Clip,
    *,
    target: float = 0.0,
    limit: float = HEAD_LIMIT,
    sigma: float = SIGMA,
    neck_share: float = NECK_SHARE,
) -> Clip:
    """Return the clip with the head turned about the vertical towards `target` [rad, 0 = the audience].

    The turn at each sample is that of `head_turn`; the head's rotation in the world becomes R_θ R_head and its local
    one follows from its parents' (T125). ValueError for a limit outside (0, π) or a negative sigma.
    """
    theta = head_turn(clip, target=target, limit=limit, sigma=sigma)
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    neck = quaternion.mul(quaternion.from_axis_angle(_Y, neck_share * theta), world[:, _NECK])
    head = quaternion.mul(quaternion.from_axis_angle(_Y, theta), world[:, _HEAD])
    rotation = clip.rotation.copy()
    rotation[:, _NECK] = quaternion.mul(quaternion.inverse(world[:, _CHEST]), neck)
    rotation[:, _HEAD] = quaternion.mul(quaternion.inverse(neck), head)
    return replace(clip, rotation=rotation)


def head_turn(clip: Clip, *, target: float = 0.0, limit: float = HEAD_LIMIT, sigma: float = SIGMA) -> Float64:
    """Return the turn θ [rad] to add to the head at each sample, (T,) (T123, T124).

    θ = target - atan2(v_x, v_z) for the head's forward axis v (with the quadrant that arctg loses). Samples where θ or
    the resulting angle between head and chest exceeds `limit` are dropped (spins), gaps are filled linearly, and a
    Gaussian of `sigma` [s] smooths the result. Finally the angle between head and chest is clamped to the limit, or
    to its original value if that is larger.
    """
    if not 0.0 < limit < np.pi or not sigma >= 0.0:
        raise ValueError(f"limit {limit} and sigma {sigma}: 0 to π and at least 0 expected")
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    theta = wrap(target - heading_of(world[:, _HEAD]))
    turned = wrap(heading_of(world[:, _HEAD]) - heading_of(world[:, _CHEST]))  # already, on the chest
    kept = (np.abs(theta) <= limit) & (np.abs(turned + theta) <= limit)
    theta = fill_gaps(theta, kept)
    if sigma > 0.0:
        theta = np.asarray(gaussian_filter(theta, sigma * clip.sample_rate), np.float64)
    lowest, highest = np.minimum(-limit, turned), np.maximum(limit, turned)
    return np.asarray(np.clip(turned + theta, lowest, highest) - turned)


def fill_gaps(values: Float64, kept: npt.NDArray[np.bool_]) -> Float64:
    """Return values (T,) with those that are not `kept` interpolated linearly; 0 if none is kept."""
    if not kept.any():
        return np.zeros_like(values)
    places = np.arange(len(values))
    return np.interp(places, places[kept], values[kept])


def wrap(angle: npt.NDArray[np.floating]) -> Float64:
    """Return the same angles in [-π, π) [rad]."""
    return np.asarray(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)
