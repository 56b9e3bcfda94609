"""Points spread evenly over a body's skin, with random numbers, for dancers drawn as particles."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Int32
from live.base.body.catalogue import DEFAULT_BODY
from live.render.body.body_mesh import LIGHT, BodyMesh, build_body, strongest_weights
from live.render.body.drawn_joints import DRAWN_COUNT

_SEED: Final = 11


@dataclass(frozen=True, slots=True, eq=False)
class BodyPoints:
    """P points in order of appearance; any first n of them are spread evenly, too."""

    position: Float32
    """In the rest pose [m], shape (P, 3)."""
    normal: Float32
    """Unit, shape (P, 3)."""
    joint: Int32
    """The joints that move each point, shape (P, 4)."""
    weight: Float32
    """Weight of each of these joints, rows sum to 1, shape (P, 4)."""
    random: Float32
    """Rank in the order from 0 to 1, and three random numbers, shape (P, 4)."""


@cache
def build_points(count: int, name: str = DEFAULT_BODY) -> BodyPoints:
    """Return `count` points on the body of that name; deterministic."""
    return points_on(build_body(LIGHT, name), count)


def points_on(mesh: BodyMesh, count: int) -> BodyPoints:
    """Return `count` points on a surface; deterministic."""
    draw = np.random.default_rng(_SEED)
    corners = mesh.triangle[_pick_triangles(mesh, count)]
    share = _barycentric(draw.random((count, 2)))
    dense = np.zeros((len(mesh.position), DRAWN_COUNT))
    for column in range(mesh.joint.shape[1]):
        dense[np.arange(len(dense)), mesh.joint[:, column]] += mesh.weight[:, column]
    mixed = {
        "position": (mesh.position[corners] * share[:, :, None]).sum(axis=1),
        "normal": (mesh.normal[corners] * share[:, :, None]).sum(axis=1),
    }
    joint, weight = strongest_weights((dense[corners] * share[:, :, None]).sum(axis=1))
    chance = np.column_stack([(np.arange(count) + 0.5) / count, draw.random((count, 3))])
    normal = mixed["normal"] / np.maximum(np.linalg.norm(mixed["normal"], axis=1, keepdims=True), 1e-9)
    return BodyPoints(
        mixed["position"].astype(np.float32), normal.astype(np.float32), joint, weight, chance.astype(np.float32)
    )


def _pick_triangles(mesh: BodyMesh, count: int) -> npt.NDArray[np.int64]:
    """Return a triangle for each point, by area, with the van der Corput sequence, so that any first n are even."""
    a, b, c = (mesh.position[mesh.triangle[:, corner]].astype(np.float64) for corner in range(3))
    area = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    place = np.zeros(count)
    number, part = np.arange(count), 0.5
    while number.any():
        place += part * (number & 1)
        number, part = number >> 1, 0.5 * part
    return np.asarray(np.searchsorted(area, place * area[-1]))


def _barycentric(draw: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return uniform barycentric coordinates for random numbers (N, 2), shape (N, 3)."""
    root = np.sqrt(draw[:, 0])
    return np.column_stack([1.0 - root, root * (1.0 - draw[:, 1]), root * draw[:, 1]])
