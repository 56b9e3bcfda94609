"""Kernel for the depth of limbs: what one camera hardly tells follows from the lengths of bones and usual poses."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.motion.capture.landmark_kernels import (
    ANKLE,
    ELBOW,
    HIP,
    KNEE,
    SHOULDER,
    WRIST,
    Vector,
    cross,
    dot,
    less,
    middle,
    row,
    unit,
)

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

ROUNDS = 8
"""How often all bones are brought to their lengths in turn; more changes no pose by a millimetre."""


@inline_kernel
def _move(points: Any, n: int, way: Vector, far: float) -> None:
    for c in range(3):
        points[n, c] += far * way[c]


@inline_kernel
def _usual_depth(points: Float64, eye: Vector, deep: Vector, facing: float, weight: float, usual: Float64) -> None:
    """Mix the depth of trunk, arms and legs with that of usual poses: see `USUAL_DEPTH` of the limbs.

    `facing`: the dancer's size [skeletons] where they face along the camera's ray; `weight`: share of the usual.
    """
    seen = points.copy()
    rise = _dot_depth(middle(points, SHOULDER), middle(points, HIP), deep)
    share = weight * (usual[0, 0] - 1.0)
    shift = share * rise + usual[0, 1] * facing
    for n in range(HIP):
        _move(points, n, unit(less(row(points, n), eye)), shift)
    for side in range(2):
        for part in range(4):
            n = (ELBOW, WRIST, KNEE, ANKLE)[part] + side
            share = 1.0 + weight * (usual[1 + part, 0] - 1.0)
            told = share * _dot_depth(row(seen, n), row(seen, n - 2), deep) + usual[1 + part, 1] * facing
            ray = unit(less(row(points, n), eye))
            _move(points, n, ray, told - _dot_depth(row(points, n), row(points, n - 2), deep))


@inline_kernel
def _dot_depth(a: Vector, b: Vector, deep: Vector) -> float:
    return dot(less(a, b), deep)


@inline_kernel
def _fit_lengths(points: Float64, rays: Float64, bones: Int64, lengths: Float64, spread: Float64, size: float) -> None:
    """Bring all bones to their lengths; of their ends those move most, and that way, that are least sure."""
    for b in range(bones.shape[0]):
        i, j = bones[b, 0], bones[b, 1]
        way = less(row(points, j), row(points, i))
        far = max(math.sqrt(dot(way, way)), 1e-6)
        way = (way[0] / far, way[1] / far, way[2] / far)
        di, dj = dot(way, row(rays, i)), dot(way, row(rays, j))
        ai, aj = spread[i, 0] ** 2, spread[j, 0] ** 2
        bi, bj = (spread[i, 1] ** 2 - ai) * di, (spread[j, 1] ** 2 - aj) * dj
        pull = (far - size * lengths[b]) / (ai + bi * di + aj + bj * dj)
        for c in range(3):
            points[i, c] += pull * (ai * way[c] + bi * rays[i, c])
            points[j, c] -= pull * (aj * way[c] + bj * rays[j, c])


@kernel("void(f8[:,::1], f8[::1], f8[::1], f8, f8[:,::1], f8[::1], i8[:,::1], f8[::1], f8[:,::1])")
def fit_limbs(
    points: Float64, eye: Float64, depth: Float64, size: float, usual: Float64, down: Float64, bones: Int64,
    lengths: Float64, spread: Float64,
) -> None:  # fmt: skip
    """Move landmarks `points` (33, 3) [m] so that trunk and limbs of a body of this `size` fit.

    `eye` (3,): place of the camera; `depth` (3,): the direction in which the points are least sure, or zero: then
    nothing is known of usual depths, and points are equally sure in all directions. `usual` (5, 2): for trunk, upper
    arm, forearm, thigh, shin the share of the seen depth and what is added [m] for a dancer who faces along `depth`.
    `down` (2,) [m]: how much farther along the upper bone elbow and knee lie than they are seen. `bones` (B, 2) and
    their `lengths` (B,) [m]; `spread` (33, 2) [m]: standard deviation across and along the ray.
    """
    seen = points.copy()
    deep, place = (depth[0], depth[1], depth[2]), (eye[0], eye[1], eye[2])
    if dot(deep, deep) > 0.25:
        aside = unit(less(row(points, HIP), row(points, HIP + 1)))
        forward = cross(aside, unit(less(middle(points, SHOULDER), middle(points, HIP))))
        facing = dot(forward, deep)
        _usual_depth(points, place, deep, size * facing, facing * facing, usual)
    rays = np.zeros_like(points)
    for n in range(SHOULDER, points.shape[0]):
        if dot(deep, deep) > 0.25:
            ray = unit(less(row(points, n), place))
            rays[n, 0], rays[n, 1], rays[n, 2] = ray
    for side in range(2):
        for part in range(2):
            n = (ELBOW, KNEE)[part] + side
            way, ray = unit(less(row(points, n), row(points, n - 2))), row(rays, n)
            along = dot(way, ray)
            _move(points, n, (way[0] - along * ray[0], way[1] - along * ray[1], way[2] - along * ray[2]),
                  down[part] * size)  # fmt: skip
    for _ in range(ROUNDS):
        _fit_lengths(points, rays, bones, lengths, spread, size)
    for side in range(2):
        # hands and feet move with wrists and ankles
        wrist, ankle = WRIST + side, ANKLE + side
        moved = less(row(points, wrist), row(seen, wrist))
        for n in range(wrist + 2, HIP, 2):
            for c in range(3):
                points[n, c] = seen[n, c] + moved[c]
        moved = less(row(points, ankle), row(seen, ankle))
        for n in range(ankle + 2, points.shape[0], 2):
            ray = row(rays, n)
            _move(points, n, ray, dot(moved, ray))
