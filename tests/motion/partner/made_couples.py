"""Synthetic couples: two standing bodies that are placed and turned as told."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON

Float64 = npt.NDArray[np.float64]
RATE = 60.0


def dancer(x: npt.ArrayLike, z: npt.ArrayLike, heading: npt.ArrayLike, count: int, name: str = "dancer") -> Clip:
    """A body in the rest pose at x, z [m] with a heading [rad], each (count,) or one number."""
    root = np.zeros((count, 3), np.float32)
    root[:, 0], root[:, 1], root[:, 2] = x, SKELETON.rest_positions()[0, 1], z
    rotation = np.zeros((count, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    half = 0.5 * np.broadcast_to(np.asarray(heading, np.float64), (count,))
    rotation[:, 0, 0], rotation[:, 0, 2] = np.cos(half), np.sin(half)
    return Clip(name, root, rotation, RATE, np.ones((count, 2), np.bool_))


def ramp(count: int, begin: float, end: float, amount: float) -> Float64:
    """0 until `begin` [s], `amount` from `end` on, smooth between, (count,)."""
    share = np.clip((np.arange(count) / RATE - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(amount * share * share * (3.0 - 2.0 * share))


def reaching(clip: Clip) -> Clip:
    """The same dancer with the right arm straight ahead, its palm at the back of one who stands 0.5 m before."""
    rotation = clip.rotation.copy()
    rotation[:, SKELETON.index("rightUpperArm")] = (np.cos(np.pi / 4), 0.0, np.sin(np.pi / 4), 0.0)
    return replace(clip, rotation=rotation)


def facing_couple(count: int, distance: npt.ArrayLike, turn: npt.ArrayLike = 0.0) -> tuple[Clip, Clip]:
    """A leader at the origin who faces the hall and reaches ahead, and a follower before him who faces him and turns by
    `turn` [rad]."""
    leader = reaching(dancer(0.0, 0.0, 0.0, count, "leader"))
    return leader, dancer(0.0, distance, np.pi + np.asarray(turn), count, "follower")
