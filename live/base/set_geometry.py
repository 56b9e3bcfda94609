"""Geometry of set items (boxes, cylinders and steps) as triangles in stage coordinates."""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32

Form = Literal["box", "cylinder", "steps"]

SIDES: Final = 32
"""Number of sides of a cylinder."""


@dataclass(frozen=True, slots=True)
class SetItem:
    """One item: form, centre (x, z) [m], width, height and depth [m]."""

    form: Form
    at: tuple[float, float]
    size: tuple[float, float, float]
    turn_deg: float = 0.0
    """Rotation, as a dancer's heading [degrees]."""
    lift: float = 0.0
    """Height of its underside above the floor [m]."""
    colour: tuple[float, float, float] = (0.10, 0.10, 0.12)
    steps: int = 4
    """Number of steps; they rise away from the audience."""


def item_triangles(item: SetItem) -> tuple[Float32, Float32]:
    """Return corners and normals of its triangles, each (T, 3, 3), counter-clockwise seen from outside."""
    corners, normals = _unit_triangles(item.form, item.steps if item.form == "steps" else 0)
    size = np.array(item.size)
    corners, normals = corners * size, normals / size
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    turn = math.radians(item.turn_deg)
    cos, sin = math.cos(turn), math.sin(turn)
    about = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    place = np.array([item.at[0], item.lift, item.at[1]])
    return (corners @ about.T + place).astype(np.float32), (normals @ about.T).astype(np.float32)


@lru_cache(maxsize=64)
def _unit_triangles(form: Form, steps: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return corners and normals of an item of one metre; cached, since 40 steps take 5 ms. Not to be changed."""
    if form == "cylinder":
        return _cylinder()
    if form == "steps":
        parts = [_box(low, high) for low, high in _stairs(steps)]
        return np.concatenate([corners for corners, _ in parts]), np.concatenate([normals for _, normals in parts])
    return _box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5))


def _stairs(count: int) -> list[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Return adjacent boxes, each higher than the one before it, starting at the audience's side."""
    edges = [0.5 - n / count for n in range(count + 1)]
    return [((-0.5, 0.0, edges[n + 1]), (0.5, (n + 1) / count, edges[n])) for n in range(count)]


def _box(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    corners, normals = [], []
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, 1):
            quad = np.tile(np.array(low, np.float64), (4, 1))
            quad[:, axis] = (low, high)[side][axis]
            quad[[1, 2], one] = high[one]
            quad[[2, 3], other] = high[other]
            normal = np.zeros(3)
            normal[axis] = 2.0 * side - 1.0
            order = (0, 1, 2, 0, 2, 3) if side else (0, 2, 1, 0, 3, 2)
            corners.append(quad[list(order)].reshape(2, 3, 3))
            normals.append(np.tile(normal, (2, 3, 1)))
    return np.concatenate(corners), np.concatenate(normals)


def _cylinder() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    angle = np.linspace(0.0, math.tau, SIDES + 1)
    rim = np.stack([0.5 * np.sin(angle), np.zeros(SIDES + 1), 0.5 * np.cos(angle)], axis=1)
    up = np.array([0.0, 1.0, 0.0])
    corners, normals = [], []
    for a, b in pairwise(rim):
        across_a, across_b = 2.0 * a, 2.0 * b
        corners += [[a, b, b + up], [a, b + up, a + up], [up, a + up, b + up], [0.0 * up, b, a]]
        normals += [[across_a, across_b, across_b], [across_a, across_b, across_a], [up] * 3, [-up] * 3]
    return np.array(corners), np.array(normals)
