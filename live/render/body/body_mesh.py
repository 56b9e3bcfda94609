"""Skinned triangle mesh of the dancer's body in several levels of detail.

A coarse cage is subdivided and projected onto the implicit surface of the body. The skin weights are subdivided with
it, so they are as smooth as the skin and never leak from one limb to another.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32, Int64
from live.base.body.catalogue import DEFAULT_BODY
from live.base.disk.array_cache import ArrayCache, Arrays, digest_of_code
from live.motion.skeleton import JOINT_COUNT
from live.render.body.body_variants import parts_of, toes_of, trunk_of
from live.render.body.cage import build_cage, build_toe_cage
from live.render.body.cage_builder import Cage
from live.render.body.drawn_joints import ANCHORS
from live.render.body.fingers import FINGERS
from live.render.body.hand_cage import build_nail_cage
from live.render.body.implicit_surface import Shape
from live.render.body.mesh_simplify import simplify, subdivide
from live.render.body.skin_weights import settled_weights
from live.render.body.surface_parts import BODY, NAIL

COARSE: Final = 0
"""Level for shadows and reflections."""
LIGHT: Final = 1
"""Level for software rendering and many dancers."""
FINE: Final = 2
"""Level for a graphics card and few dancers."""
DISTANT: Final = 3
"""Level for dancers far from the camera; at 12 m it looks like `LIGHT`."""
CLOSE: Final = 4
"""Level for software rendering, of the few dancers next to the camera."""
LEVELS: Final = (COARSE, LIGHT, FINE, DISTANT, CLOSE)
WITH_HEAD: Final = (COARSE, DISTANT)
"""Levels at which a body has a head of its own; at the others heads are meshes of their own."""

_SUBDIVISIONS: Final = (0, 1, 2, 1, 1)
_HAND_SUBDIVISIONS: Final = (0, 0, 1, 0, 1)
"""By level, of the body and of its hands, whose cage is finer."""
_FINGERS: Final = (LIGHT, FINE, CLOSE)
"""Levels whose hands have fingers; the others have mittens."""
_DETAILED: Final = (FINE, CLOSE)
"""Levels whose fingers have round tips and nails, and whose limbs show bones and muscles."""
_TOES: Final = (FINE,)
"""Levels whose feet have toes."""
_TRIANGLES: Final = {COARSE: 440, LIGHT: 1240, DISTANT: 600}
"""Triangle counts of simplified levels."""
_HANDS_FROM: Final = 0.70
"""Hands begin here, to the side [m]."""
_FINGERS_FROM: Final = 0.76
"""No vertex of a finger is left out: they begin here."""
_INFLUENCES: Final = 4
_PROJECTIONS: Final = 4
_NORMAL_STEP: Final = 2e-3
"""Width over which the surface is averaged for normals [m]."""
_ON_SURFACE: Final = 1e-4
"""Nearer to the surface than this [m] a vertex is on it."""
_LEAST_OPENNESS: Final = 0.4
"""Limbs move: armpits and what lies between the legs are seen in other poses."""
_OCCLUSION_REACH: Final = (0.06, 0.10, 0.16)
_CACHE: Final = ArrayCache("body", max_entries=512)
_NOTHING: Final = 1e-9
"""Coordinates below this [m] are 0, so that the middle is the middle on every machine."""
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
    place: Float32
    """Where the vertex lies on the usual body [m], by which the surface is painted, shape (V, 3)."""
    part: Int32
    """What the surface is (`surface_parts`), shape (V,); the same for all corners of a triangle."""


def _project(shape: Shape, points: Float64) -> Float64:
    points, moving = points.copy(), np.arange(len(points))
    for _ in range(_PROJECTIONS):
        step = np.clip(shape.distance(points[moving]), -0.03, 0.03)
        far = np.abs(step) > _ON_SURFACE
        moving, step = moving[far], step[far]
        points[moving] -= shape.normal(points[moving]) * step[:, None]
    return points


def _refine(cage: Cage, shape: Shape, level: int, hands: int = 9) -> Cage:
    """Subdivide so many times, hands no more than `hands` times."""
    points, weights, faces = _project(shape, cage.points), cage.weights, cage.faces
    for number in range(level):
        left_out = number >= hands
        chosen = np.abs(points[faces[:, 0]][:, 0]) < _HANDS_FROM if left_out else None
        values, faces = subdivide(np.concatenate([points, weights], axis=1), faces, chosen)
        used = np.unique(faces[faces >= 0])
        values, faces = values[used], np.where(faces < 0, -1, np.searchsorted(used, faces))
        points, weights = _project(shape, values[:, :3]), values[:, 3:]
    return Cage(points, settled_weights(points, weights), faces)


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


def skeleton_weights(mesh: BodyMesh) -> tuple[Int32, Float32]:
    """Return joints and weights (V, 4) of the skeleton: muscles and fingers go with the joint that they hang on."""
    skeletal = np.concatenate([np.arange(JOINT_COUNT), ANCHORS])
    dense = np.zeros((len(mesh.position), JOINT_COUNT))
    np.add.at(dense, (np.arange(len(dense))[:, None], skeletal[mesh.joint]), mesh.weight)
    return strongest_weights(dense)


def _triangles(points: Float64, faces: Int64) -> Int64:
    """Split each quadrilateral into two triangles along its shorter diagonal, larger faces into a fan."""
    corners = (faces >= 0).sum(axis=1)
    four = faces[corners == 4][:, :4]
    across = np.linalg.norm(points[four[:, 0]] - points[four[:, 2]], axis=1)
    other = np.linalg.norm(points[four[:, 1]] - points[four[:, 3]], axis=1)
    turned = np.where((other < across - 1e-6)[:, None], np.roll(four, -1, axis=1), four)
    parts = [turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]]
    for count in range(5, faces.shape[1] + 1):
        rows = faces[corners == count]
        first = rows.argmax(axis=1)  # the newest corner: on an edge that a neighbour has split
        fan = np.take_along_axis(rows, (first[:, None] + np.arange(count)) % count, axis=1)
        parts += [fan[:, [0, at, at + 1]] for at in range(1, count - 1)]
    return np.concatenate(parts)


def occlusion(shape: Shape, points: Float64, normals: Float64) -> Float64:
    """Return the share of ambient light that reaches points (N, 3) on a surface, 0 to 1."""
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
            f"level of detail {level}: {COARSE} coarse, {LIGHT} light, {FINE} fine, {DISTANT} far, {CLOSE} close"
        )
    return cached_mesh(f"body {name} {level}", lambda: _build(level, name))


def cached_mesh(key: str, build: Callable[[], BodyMesh]) -> BodyMesh:
    """Return the mesh of the disk cache that was built under this key by the present code, else build and store it."""
    entry = _CACHE.entry_path(code_digest(), [key.encode()])
    mesh = _CACHE.load(entry, _unpack)
    if mesh is None:
        mesh = build()
        _CACHE.store(entry, {field.name: getattr(mesh, field.name) for field in fields(mesh)})
    return mesh


@cache
def code_digest() -> bytes:
    """Return the digest of the code that builds bodies."""
    here = Path(__file__).resolve().parent
    package = here.parents[1]
    motion = package / "motion"
    return digest_of_code([here, package / "base" / "body", motion / "skeleton.py", motion / "curve.py"])


def _unpack(arrays: Arrays) -> BodyMesh:
    """Return the mesh of a cache entry; any exception for arrays that are no mesh."""
    mesh = BodyMesh(**arrays)
    vertices, triangles = len(mesh.position), len(mesh.triangle)
    shapes = {
        "position": (vertices, 3), "normal": (vertices, 3), "joint": (vertices, _INFLUENCES),
        "weight": (vertices, _INFLUENCES), "openness": (vertices,), "triangle": (triangles, 3),
        "place": (vertices, 3), "part": (vertices,),
    }  # fmt: skip
    for name, shape in shapes.items():
        kind = np.int32 if name in ("joint", "triangle", "part") else np.float32
        if arrays[name].shape != shape or arrays[name].dtype != kind:
            raise ValueError(f"{name}: {shape} numbers of {kind.__name__} expected")
    if mesh.triangle.min() < 0 or mesh.triangle.max() >= vertices:
        raise ValueError("a triangle without its vertex")
    return mesh


def _build(level: int, name: str) -> BodyMesh:
    head = level in WITH_HEAD
    body = Shape((parts_of if head else trunk_of)(name, toes=level in _TOES, details=level in _DETAILED))
    cage = build_cage(fingers=level in _FINGERS, tips=level in _DETAILED, head=head)
    parts = [(body, _refine(cage, body, _SUBDIVISIONS[level], _HAND_SUBDIVISIONS[level]))]
    if level in _TOES:
        toes = [(Shape((toe,)), build_toe_cage(toe)) for toe in toes_of(name)]
        parts += [(shape, _refine(cage, shape, 1)) for shape, cage in toes]
    painted = [np.full(len(cage.points), BODY, np.int32) for _, cage in parts]
    if level in _DETAILED:
        nails = [(body, build_nail_cage(finger)) for finger in FINGERS]
        parts += nails
        painted += [np.full(len(cage.points), NAIL, np.int32) for _, cage in nails]
    part = np.concatenate(painted)
    points = np.concatenate([cage.points for _, cage in parts])
    weights = np.concatenate([cage.weights for _, cage in parts])
    step = _NORMAL_STEP if level == FINE else 2.5 * _NORMAL_STEP  # large triangles show no folds
    normals = np.concatenate([shape.normal(cage.points, step) for shape, cage in parts])
    first = np.cumsum([0, *(len(cage.points) for _, cage in parts[:-1])]).tolist()
    triangles = np.concatenate(
        [_triangles(cage.points, cage.faces) + start for (_, cage), start in zip(parts, first, strict=True)]
    )
    if level in _TRIANGLES:
        kept = (np.abs(points[:, 0]) > _FINGERS_FROM) & (level in _FINGERS)
        used, triangles = simplify(points, triangles, weights, _TRIANGLES[level], kept)
        points, weights, normals, part = points[used], weights[used], normals[used], part[used]
    openness = np.maximum(occlusion(Shape(parts_of(name)), points, normals), _LEAST_OPENNESS)
    place = points
    if level == COARSE:
        points = points + normals * _SHADOW_OFFSET
    points = np.where(np.abs(points) < _NOTHING, 0.0, points)
    joint, weight = strongest_weights(weights)
    return BodyMesh(
        np.ascontiguousarray(points, np.float32),
        np.ascontiguousarray(normals, np.float32),
        joint,
        weight,
        np.ascontiguousarray(openness, np.float32),
        np.ascontiguousarray(triangles, np.int32),
        np.ascontiguousarray(place, np.float32),
        np.ascontiguousarray(part, np.int32),
    )


def empty_mesh() -> BodyMesh:
    """Return a mesh of nothing."""
    three, four, one = ((0, 3), (0, 4), (0,))
    return BodyMesh(
        np.zeros(three, np.float32), np.zeros(three, np.float32), np.zeros(four, np.int32), np.zeros(four, np.float32),
        np.zeros(one, np.float32), np.zeros(three, np.int32), np.zeros(three, np.float32), np.zeros(one, np.int32),
    )  # fmt: skip


def merged(meshes: list[BodyMesh]) -> BodyMesh:
    """Return meshes as one; none of their vertices are shared."""
    first = np.cumsum([0, *(len(mesh.position) for mesh in meshes)])[:-1]
    arrays = {field.name: [getattr(mesh, field.name) for mesh in meshes] for field in fields(BodyMesh)}
    arrays["triangle"] = [
        (triangle + start).astype(np.int32) for triangle, start in zip(arrays["triangle"], first, strict=True)
    ]
    return BodyMesh(**{name: np.ascontiguousarray(np.concatenate(each)) for name, each in arrays.items()})
