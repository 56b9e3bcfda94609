"""Synthetic walks: a body of swinging legs along a path with sharp corners, at a steady rhythm."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON

Float64 = npt.NDArray[np.float64]
RATE = 60.0
CYCLE_S = 1.0
"""Time of two steps [s]."""
SPEED = 1.2
CORNER_S = 0.25
"""Time in which the direction changes [s]."""
SWING_RAD = 0.237
"""So that the foot that stands under the body does not move [rad]."""


@dataclass(frozen=True)
class Corner:
    """A corner of a path: when, and by how much the direction changes to the left [rad]."""

    time: float
    angle: float


def headings(corners: list[Corner], time: Float64) -> Float64:
    """Direction of the path at each time [rad]."""
    found = np.zeros_like(time)
    for corner in corners:
        share = np.clip((time - corner.time) / CORNER_S + 0.5, 0.0, 1.0)
        found += corner.angle * share * share * (3.0 - 2.0 * share)
    return found


def places(corners: list[Corner], time: Float64) -> Float64:
    """x and z of a walker at steady speed, (n, 2) [m]."""
    heading = headings(corners, time)
    step = SPEED * np.gradient(time)
    return np.cumsum(np.stack((np.sin(heading), np.cos(heading)), axis=1) * step[:, None], axis=0)


def walk(name: str, corners: list[Corner], seconds: float, phase: float = 0.0) -> Clip:
    """A walker whose left foot lands at each whole cycle, from `phase` [cycles] at the beginning on."""
    time = np.arange(round(seconds * RATE) + 1) / RATE
    cycle = phase + time / CYCLE_S
    root = np.zeros((len(time), 3))
    root[:, (0, 2)] = places(corners, time)
    root[:, 1] = SKELETON.rest_positions()[0, 1]
    rotation = np.zeros((len(time), JOINT_COUNT, 4))
    rotation[..., 0] = 1.0
    half = 0.5 * headings(corners, time)
    rotation[:, 0, 0], rotation[:, 0, 2] = np.cos(half), np.sin(half)
    contact = np.zeros((len(time), 2), np.bool_)
    for foot, side in enumerate(("left", "right")):
        own = cycle - 0.5 * foot  # at 0 this foot lands, ahead
        angle = -SWING_RAD * np.cos(2.0 * np.pi * own)  # about x: negative swings ahead
        rotation[:, SKELETON.index(side + "UpperLeg"), 0] = np.cos(0.5 * angle)
        rotation[:, SKELETON.index(side + "UpperLeg"), 1] = np.sin(0.5 * angle)
        contact[:, foot] = own % 1.0 < 0.6
    return Clip(name, root.astype(np.float32), rotation.astype(np.float32), RATE, contact)
