"""The springs of one character: chains of bones (hair, skirts, tails) that swing below the joints of the dancer.

The model is that of VRM: https://github.com/vrm-c/vrm-specification, VRMC_springBone-1.0. Bones and colliders are given
in the rest pose of the engine's skeleton, in which every joint's axes are those of the world.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float32, Int32, Int64

MAX_SPRINGS: Final = 96
"""Maximum number of bones that swing in one character; the others move with the joint or bone above."""
MAX_COLLIDERS: Final = 48
"""Maximum number of colliders of one character."""
STIFFNESS, DRAG, GRAVITY_X, GRAVITY_Y, GRAVITY_Z, HIT_RADIUS = range(6)
"""Columns of `SpringRig.setting`: pull towards the rest direction [m/s per tick's second], share of the motion that is
lost in a tick, pull of gravity [likewise], radius of the bone's tip [m]."""
SETTINGS: Final = 6


@dataclass(frozen=True, slots=True, eq=False)
class SpringRig:
    """B bones, parents first, and C colliders."""

    parent: Int32
    """Bone above, -1: the chain begins here; shape (B,)."""
    joint: Int32
    """Joint of the skeleton from which the bone's chain hangs, shape (B,)."""
    centre: Int32
    """Joint in whose space the bone's inertia is computed, -1: the world; shape (B,)."""
    head: Float32
    """Where the bone begins in the rest pose [m], shape (B, 3)."""
    tail: Float32
    """Where it ends [m], shape (B, 3)."""
    setting: Float32
    """Stiffness, drag, gravity and radius, shape (B, 6)."""
    hits: Int64
    """Bit c is set if the bone collides with collider c, shape (B,)."""
    collider_joint: Int32
    """Joint that carries each collider, shape (C,)."""
    collider: Float32
    """Both ends of its axis in the rest pose, and its radius [m], shape (C, 7); equal ends: a sphere."""

    @property
    def count(self) -> int:
        """Number of bones B."""
        return len(self.parent)

    @staticmethod
    def empty() -> "SpringRig":
        """Return a rig without bones."""
        none, rows, bits = np.zeros(0, np.int32), np.zeros((0, 3), np.float32), np.zeros(0, np.int64)
        setting, colliders = np.zeros((0, SETTINGS), np.float32), np.zeros((0, 7), np.float32)
        return SpringRig(none, none, none, rows, rows, setting, bits, none, colliders)
