"""Skinned triangle mesh of the dancer's body in several levels of detail.

A coarse cage is subdivided and projected onto the implicit surface of the body. The skin weights are subdivided with
it, so they are as smooth as the skin and never leak from one limb to another.
"""

from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32, Int64
from live.base.body.catalogue import DEFAULT_BODY
from live.base.disk.array_cache import ArrayCache, Arrays, digest_of_code
from live.render.body.body_variants import bun_of, parts_of
from live.render.body.cage import Cage, build_bun_cage, build_cage
from live.render.body.implicit_surface import Shape
from live.render.body.mesh_simplify import simplify, subdivide

COARSE: Final = 0
"""Level for shadows and reflections."""
LIGHT: Final = 1
"""Level for software rendering and many dancers."""
FINE: Final = 2
"""Level for a graphics card and few dancers."""
DISTANT: Final = 3
"""Level for dancers far from the camera; at 12 m it looks like `LIGHT`."""
LEVELS: Final = (COARSE, LIGHT, FINE, DISTANT)

_SUBDIVISIONS: Final = (0, 1, 2, 1)
_TRIANGLES: Final = {LIGHT: 1220, DISTANT: 640}
"""Triangle counts of simplified levels."""
_INFLUENCES: Final = 4
_PROJECTIONS: Final = 4
_OCCLUSION_REACH: Final = (0.06, 0.10, 0.16)
_CACHE: Final = ArrayCache("body", max_entries=64)
_SHADOW_OFFSET: Final = 0.006
"""Offset of the coarse body's skin [m], so that its square limbs cast shadows as wide as round ones."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyMesh:
    """A closed triangle mesh in the rest pose (V vertices, T triangles), counter-clockwise seen from outside."""

    position: Float32
    """[m], shape (V, 3)."""
    normal: Float32
    """Unit, shape (V, 3)."""
    joint: Int32
    """The joints that move each vertex, shape (V, 4)."""
    weight: Float32
    """Weight of each of these joints, not negative, rows sum to 1, shape (V, 4)."""
    openness: Float32
    """Share of ambient light that reaches the vertex, 0 to 1, shape (V,)."""
    triangle: Int32
    """Vertex indices, shape (T, 3)."""


def _project(shape: Shape, points: Float64) -> Float64:
    for _ in range(_PROJECTIONS):
        step = np.clip(shape.distance(points), -0.03, 0.03)
        points = points - shape.normal(points) * step[:, None]
    return points


def _refine(cage: Cage, shape: Shape, level: int) -> Cage:
    points, weights, faces = _project(shape, cage.points), cage.weights, cage.faces
    for _ in range(level):
        values, faces = subdivide(np.concatenate([points, weights], axis=1), faces)
        points, weights = _project(shape, values[:, :3]), values[:, 3:]
    return Cage(points, weights, faces)


def strongest_weights(weights: Float64) -> tuple[Int32, Float32]:
    """Return the four strongest joints of each vertex and their weights, which sum to 1.

    The fifth weight is subtracted from all, so that weights fade out smoothly and ties need no preference.
    """
    order = np.argsort(-weights, axis=1, kind="stable")
    joint = order[:, :_INFLUENCES]
    fifth = np.take_along_axis(weights, order[:, _INFLUENCES : _INFLUENCES + 1], axis=1)
    weight = np.take_along_axis(weights, joint, axis=1) - fifth
    weight[weight < 0.01] = 0.0
    weight /= weight.sum(axis=1, keepdims=True)
    joint[weight == 0.0] = 0
    return np.ascontiguousarray(joint, np.int32), np.ascontiguousarray(weight, np.float32)


def _triangles(points: Float64, faces: Int64) -> Int64:
    """Split each quadrilateral into two triangles along its shorter diagonal."""
    across = np.linalg.norm(points[faces[:, 0]] - points[faces[:, 2]], axis=1)
    other = np.linalg.norm(points[faces[:, 1]] - points[faces[:, 3]], axis=1)
    turned = np.where((other < across - 1e-6)[:, None], np.roll(faces, -1, axis=1), faces)
    return np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])


def _openness(shape: Shape, points: Float64, normals: Float64) -> Float64:
    total = np.zeros(len(points))
    for reach in _OCCLUSION_REACH:
        total += np.clip(shape.distance(points + normals * reach) / reach, 0.0, 1.0)
    return total / len(_OCCLUSION_REACH)


@cache
def build_body(level: int, name: str = DEFAULT_BODY) -> BodyMesh:
    """Return the body of a name (`live.base.body.catalogue`) at one of `LEVELS` of detail. ValueError for an unknown
    one. Built once per machine and version, in a fraction of a second."""
    if level not in LEVELS:
        raise ValueError(
            f"level of detail {level}: {COARSE} (coarse), {LIGHT} (light), {FINE} (fine) or {DISTANT} (far)"
        )
    entry = _CACHE.entry_path(_code_digest(), [name.encode(), bytes([level])])
    mesh = _CACHE.load(entry, _unpack)
    if mesh is None:
        mesh = _build(level, name)
        _CACHE.store(entry, {field.name: getattr(mesh, field.name) for field in fields(mesh)})
    return mesh


@cache
def _code_digest() -> bytes:
    """Digest of the code that builds bodies."""
    here = Path(__file__).resolve().parent
    package = here.parents[1]
    return digest_of_code([here, package / "base" / "body", package / "motion" / "skeleton.py"])


def _unpack(arrays: Arrays) -> BodyMesh:
    """Return the mesh of a cache entry; any exception for arrays that are no mesh."""
    mesh = BodyMesh(**arrays)
    vertices, triangles = len(mesh.position), len(mesh.triangle)
    shapes = {
        "position": (vertices, 3), "normal": (vertices, 3), "joint": (vertices, _INFLUENCES),
        "weight": (vertices, _INFLUENCES), "openness": (vertices,), "triangle": (triangles, 3),
    }  # fmt: skip
    for name, shape in shapes.items():
        kind = np.int32 if name in ("joint", "triangle") else np.float32
        if arrays[name].shape != shape or arrays[name].dtype != kind:
            raise ValueError(f"{name}: {shape} numbers of {kind.__name__} expected")
    if mesh.triangle.min() < 0 or mesh.triangle.max() >= vertices:
        raise ValueError("a triangle without its vertex")
    return mesh


def _build(level: int, name: str) -> BodyMesh:
    body, bun = Shape(parts_of(name)), Shape(bun_of(name))
    parts = [
        (body, _refine(build_cage(), body, _SUBDIVISIONS[level])),
        (bun, _refine(build_bun_cage(), bun, _SUBDIVISIONS[level])),
    ]
    points = np.concatenate([cage.points for _, cage in parts])
    weights = np.concatenate([cage.weights for _, cage in parts])
    normals = np.concatenate([shape.normal(cage.points) for shape, cage in parts])
    first = len(parts[0][1].points)
    triangles = np.concatenate(
        [_triangles(cage.points, cage.faces) + start for (_, cage), start in zip(parts, (0, first), strict=True)]
    )
    if level in _TRIANGLES:
        used, triangles = simplify(points, triangles, weights, _TRIANGLES[level])
        points, weights, normals = points[used], weights[used], normals[used]
    openness = _openness(body, points, normals)
    if level == COARSE:
        points = points + normals * _SHADOW_OFFSET
    joint, weight = strongest_weights(weights)
    return BodyMesh(
        np.ascontiguousarray(points, np.float32),
        np.ascontiguousarray(normals, np.float32),
        joint,
        weight,
        np.ascontiguousarray(openness, np.float32),
        np.ascontiguousarray(triangles, np.int32),
    )
