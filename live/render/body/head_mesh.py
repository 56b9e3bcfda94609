"""Meshes of heads: skin with lids and lips, eyeballs, ears and teeth, with weights for the joints of the face.

The head is drawn with the body that it belongs to; its neck follows the body's surface and ends inside it.
"""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.body.catalogue import DEFAULT_BODY
from live.render.body.body_mesh import (
    CLOSE,
    FINE,
    LIGHT,
    WITH_HEAD,
    BodyMesh,
    cached_mesh,
    empty_mesh,
    merged,
    occlusion,
    strongest_weights,
)
from live.render.body.body_variants import parts_of, trunk_of
from live.render.body.closed_meshes import (
    ball,
    catmull_rom,
    faced_outward,
    fan,
    grid_triangles,
    quads_to_triangles,
    vertex_normals,
)
from live.render.body.drawn_joints import DRAWN_COUNT, DRAWN_MIRROR, DRAWN_NAMES
from live.render.body.face_shape import FaceShape, deform, faces_of
from live.render.body.head_cage import EYE_CENTRE, EYE_RADIUS, HeadCage, build_head_cage
from live.render.body.implicit_surface import Shape
from live.render.body.mesh_simplify import simplify, subdivide
from live.render.body.surface_parts import EAR, EYE, FACE, PAINTED_FACE, TEETH

_TRIANGLES: Final = {LIGHT: 260}
_EYE_RINGS: Final = {FINE: (6, 14), CLOSE: (4, 10)}
"""Rings and segments of an eyeball."""
_EAR_RING: Final = {FINE: 18, CLOSE: 11, LIGHT: 6}
_SOFTNESS: Final = 0.42
"""How far normals of a face turn to where it looks."""
_SHARPEN: Final = 3
"""Corrections that make the subdivided surface pass through the cage's corners."""
_NECK_OVER: Final = 0.0008
"""How far the head's neck lies over the body's [m], …"""
_NECK_AXIS: Final = np.array([0.0, 0.0, -0.014])
"""… and the line that its lower end tapers to, within the body [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Skin:
    """Surface before it is deformed to a face: what all faces of a level share."""

    cage: HeadCage
    weights: Float64
    openness: Float64


def _row(**weights: float) -> Float64:
    row = np.zeros(DRAWN_COUNT)
    for name, weight in weights.items():
        row[DRAWN_NAMES.index(name)] = weight
    return row


def _step(values: Float64, low: float, high: float) -> Float64:
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


_SPINE_WEIGHTS: Final = (
    (1.40, (1.0, 0.0, 0.0)), (1.425, (0.62, 0.38, 0.0)), (1.450, (0.42, 0.58, 0.0)), (1.478, (0.10, 0.78, 0.12)),
    (1.500, (0.0, 0.42, 0.58)), (1.535, (0.0, 0.0, 1.0)),
)  # fmt: skip
"""Height on the neck [m], and the weights of upper chest, neck and head."""


def _weights(cage: HeadCage) -> Float64:
    """Return the weights of the cage's corners, shape (V, J)."""
    p = cage.points
    x, y, z = np.abs(p[:, 0]), p[:, 1], p[:, 2]
    heights = np.array([height for height, _ in _SPINE_WEIGHTS])
    shares = np.array([share for _, share in _SPINE_WEIGHTS])
    up = y + 0.030 * _step(z, 0.0, 0.07)  # the head reaches lower at the chin than at the nape
    weights = np.zeros((len(p), DRAWN_COUNT))
    for column, name in enumerate(("upperChest", "neck", "head")):
        weights[:, DRAWN_NAMES.index(name)] = np.interp(up, heights, shares[:, column])

    moved = {"jaw": _step(y, 1.552, 1.516) * _step(z, 0.004, 0.044) * _step(y, 1.470, 1.488)}
    lower, upper = moved["jaw"].copy(), np.zeros(len(p))
    if "border" in cage.loops:
        for name, corner in (("border", 0.5), ("lip", 0.5), ("touch", 0.5), ("within", 0.45), ("cavity", 0.4)):
            lower[cage.loops[name]] = (0.0, 0.0, 0.12, corner, 0.92, 1.0, 1.0)
        lower[cage.loops["row 8"][:3]] = (0.0, 0.02, 0.25)
        lower[cage.loops["row 7"][:1]] = 0.52
        lower[cage.loops["row 6"][:3]] = (1.0, 1.0, 0.85)
        for name, share in (("fold", 0.42), ("lid", 0.76), ("margin", 1.0), ("edge", 1.0), ("behind", 1.0)):
            upper[cage.loops[name][4:7]] = share * np.array((1.0, 0.95, 1.0))
            upper[cage.loops[name][[3, 7]]] = 0.12 * share
    moved["jaw"] = lower
    moved["leftLid"] = upper
    smile = np.exp(-(((x - 0.026) / 0.015) ** 2) - ((y - 1.529) / 0.016) ** 2) * _step(z, 0.050, 0.070)
    moved["leftMouth"] = 0.55 * smile
    moved["jaw"] = moved["jaw"] * (1.0 - moved["leftMouth"])
    brow = np.exp(-(((y - 1.611) / 0.0125) ** 2)) * _step(z, 0.030, 0.060) * _step(y, 1.597, 1.607)
    moved["leftBrow"] = brow * (0.5 + 0.5 * _step(x, 0.0, 0.012))
    total = np.zeros(len(p))
    for name in moved:
        moved[name] = np.minimum(moved[name], 1.0 - total)
        total += moved[name]
    weights *= 1.0 - total[:, None]
    for name, amount in moved.items():
        weights[:, DRAWN_NAMES.index(name)] += amount
    # the left half is built; the right one and the middle follow
    left = p[:, 0] >= 0.0
    swapped = weights[:, list(DRAWN_MIRROR)]
    weights[~left] = weights[cage.mirror[~left]][:, list(DRAWN_MIRROR)]
    middle = p[:, 0] == 0.0
    weights[middle] = 0.5 * (weights[middle] + swapped[middle])
    return weights


def _openness(cage: HeadCage) -> Float64:
    """Return the share of ambient light at the cage's corners: less in hollows, below chin and brow, in the mouth."""
    p = cage.points
    x, y, z = np.abs(p[:, 0]), p[:, 1], p[:, 2]
    light = np.full(len(p), 0.97)
    light *= 1.0 - 0.34 * np.exp(-(((y - 1.482) / 0.013) ** 2)) * _step(z, 0.02, 0.05) * _step(-z, -0.086, -0.072)
    light *= 1.0 - 0.20 * np.exp(-(((x - 0.016) / 0.008) ** 2) - ((y - 1.594) / 0.010) ** 2) * _step(z, 0.05, 0.07)
    light *= 1.0 - 0.12 * np.exp(-(((x - 0.008) / 0.010) ** 2) - ((y - 1.549) / 0.004) ** 2) * _step(z, 0.075, 0.085)
    light *= 1.0 - 0.12 * np.exp(-((y - 1.5125) ** 2) / 0.006**2) * _step(z, 0.07, 0.08)
    loops = {"fold": 0.80, "edge": 0.50, "behind": 0.22, "touch": 0.50, "within": 0.14, "cavity": 0.05}
    for name, share in loops.items():
        if name in cage.loops:
            light[cage.loops[name]] *= share
            light[cage.mirror[cage.loops[name]]] = light[cage.loops[name]]
    return light


@cache
def _skin(holes: bool, eye_open: float, eye_tilt: float) -> _Skin:
    cage = build_head_cage(holes=holes, eye_open=eye_open, eye_tilt=eye_tilt)
    return _Skin(cage, _weights(cage), _openness(cage))


def _fit_neck(points: Float64, place: Float64, body: str, cage: HeadCage) -> Float64:
    """Put the neck's rows on the surface of the body, the lowest one into it."""
    shape = Shape(trunk_of(body))
    out = points.copy()
    share = _step(place[:, 1], 1.485, 1.460)
    near = share > 0.0
    p = points[near]
    for _ in range(4):
        p = p - shape.normal(p) * np.clip(shape.distance(p), -0.02, 0.02)[:, None]
    p += shape.normal(p) * _NECK_OVER
    out[near] += (p - out[near]) * share[near, None]
    for side in (cage.loops, {name: cage.mirror[loop] for name, loop in cage.loops.items()}):
        above = out[side["row 1"]]
        out[side["row 0"]] = (
            _NECK_AXIS + (above - _NECK_AXIS) * np.array([0.80, 1.0, 0.78]) - np.array([0.0, 0.024, 0.0])
        )
    return out


def _sharpened(points: Float64, place: Float64, faces: Int64) -> Float64:
    """Return a cage whose subdivision passes (nearly) through `points`, but for the neck's."""
    cage, share = points.copy(), 0.8 * _step(place[:, 1], 1.470, 1.485)[:, None]
    for _ in range(_SHARPEN):
        cage += share * (points - subdivide(cage, faces)[0][: len(points)])
    return cage


@cache
def _thinned(level: int) -> tuple[Int64, Int64]:
    """Return the cage's corners that a simplified level keeps, and its triangles; the same for all faces."""
    skin = _skin(False, 1.0, 0.0)
    faces = skin.cage.faces
    hidden = skin.cage.points[:, 1] < 1.413  # the end within the body stays as it is
    return simplify(skin.cage.points, quads_to_triangles(faces), skin.weights, _TRIANGLES[level], hidden)


def _face_mesh(level: int, body: str, face: FaceShape) -> BodyMesh:
    holes = level not in _TRIANGLES
    skin = _skin(holes, 1.0 + 0.13 * face.eyes, 0.085 * face.eye_tilt)
    cage = skin.cage
    place = _skin(holes, 1.0, 0.0).cage.points
    points = _fit_neck(deform(cage.points, face), place, body, cage)
    data = np.concatenate([_sharpened(points, place, cage.faces), place, skin.weights, skin.openness[:, None]], axis=1)
    fine, faces = subdivide(data, cage.faces)
    normals = vertex_normals(fine[:, :3], quads_to_triangles(faces))
    if level == FINE:
        points, triangles = fine[:, :3], quads_to_triangles(faces)
        place, weights, openness = fine[:, 3:6], fine[:, 6:-1], fine[:, -1]
    else:
        normals = normals[: len(points)]
        used, triangles = np.arange(len(points)), quads_to_triangles(cage.faces)
        if not holes:
            used, triangles = _thinned(level)
        points, place, normals = points[used], place[used], normals[used]
        weights, openness = skin.weights[used], skin.openness[used]
    neck = _step(place[:, 1], 1.482, 1.455)
    openness = openness + neck * (occlusion(Shape(parts_of(body)), points, normals) - openness)
    normals = normals + neck[:, None] * (
        Shape(trunk_of(body)).normal(points) - normals
    )  # as the body's, where they meet
    # light goes through skin: hollows of a face are softer than their shape
    soft = _SOFTNESS * _step(place[:, 2], 0.050, 0.080) * _step(place[:, 1], 1.480, 1.500)
    normals = normals + soft[:, None] * np.array([0.0, 0.35, 1.0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return _mesh(points, normals, weights, openness, triangles, place, FACE if holes else PAINTED_FACE)


def _mesh(
    points: Float64, normals: Float64, weights: Float64, openness: Float64, triangles: Int64, place: Float64, part: int
) -> BodyMesh:
    joint, weight = strongest_weights(weights)
    return BodyMesh(
        np.ascontiguousarray(points, np.float32), np.ascontiguousarray(normals, np.float32), joint, weight,
        np.ascontiguousarray(openness, np.float32), np.ascontiguousarray(triangles, np.int32),
        np.ascontiguousarray(place, np.float32), np.full(len(points), part, np.int32),
    )  # fmt: skip


def _eyeball(level: int, sign: float) -> BodyMesh:
    unit, triangles = ball(*_EYE_RINGS[level])
    if sign < 0.0:
        unit, triangles = unit * np.array([-1.0, 1.0, 1.0]), triangles[:, ::-1]
    centre = np.array(EYE_CENTRE) * np.array([sign, 1.0, 1.0])
    points = centre + EYE_RADIUS * unit
    weights = np.tile(_row(**{"leftEye" if sign > 0.0 else "rightEye": 1.0}), (len(unit), 1))
    light = 0.62 + 0.3 * np.clip(1.0 - np.abs(unit[:, 0]), 0.0, 1.0) - 0.10 * np.clip(unit[:, 1], 0.0, 1.0)
    return _mesh(points, unit, weights, light, triangles, points, EYE)


# Outline of the ear from its upper root backwards around to the lobe: up, back [m], from its centre.
_EAR_OUTLINE: Final = (
    (0.010, -0.0125), (0.022, -0.0085), (0.030, 0.0010), (0.0305, 0.0100), (0.0235, 0.0170), (0.010, 0.0175),
    (-0.004, 0.0140), (-0.016, 0.0085), (-0.025, 0.0030), (-0.030, -0.0030), (-0.0265, -0.0085), (-0.012, -0.0100),
)  # fmt: skip
_EAR_CENTRE: Final = (0.0690, 1.5785, -0.0140)
# scale of the outline, how far it stands out [m], openness: root, back, helix, groove, antihelix, concha
_EAR_RINGS: Final = (
    (0.70, -0.012, 0.8), (0.90, 0.0015, 0.75), (1.0, 0.0078, 0.92), (0.95, 0.0105, 1.0), (0.83, 0.0090, 0.80),
    (0.76, 0.0062, 0.62), (0.64, 0.0080, 0.88), (0.50, 0.0040, 0.60), (0.30, 0.0015, 0.42),
)  # fmt: skip
_FEW_RINGS: Final = {CLOSE: (0, 1, 2, 3, 5, 6, 8), LIGHT: (0, 3, 8)}


def _ear(level: int, sign: float, face: FaceShape) -> BodyMesh:
    count = _EAR_RING[level]
    outline = np.array([*_EAR_OUTLINE[-2:], *_EAR_OUTLINE, *_EAR_OUTLINE[:3]])
    ring = catmull_rom(outline, 2.0 + np.linspace(0.0, len(_EAR_OUTLINE), count, endpoint=False))
    rings = [_EAR_RINGS[k] for k in _FEW_RINGS.get(level, range(len(_EAR_RINGS)))]
    points, light = [], []
    for scale, out, shade in rings:
        up, back = scale * ring[:, 0], scale * ring[:, 1] - (1.0 - scale) * 0.003
        stands = out + 0.26 * np.clip(back + 0.008, 0.0, None) * (out > 0.001)  # turned away from the head behind
        stands = stands * (1.0 - 0.45 * _step(-up, 0.012, 0.028) * (out > 0.001))  # the lobe lies closer
        points.append(
            np.column_stack([_EAR_CENTRE[0] + stands, _EAR_CENTRE[1] + up - 0.12 * back, _EAR_CENTRE[2] - back])
        )
        light += [shade] * count
    points.append(points[-1].mean(axis=0, keepdims=True) - np.array([[0.001, 0.0, 0.0]]))
    light.append(0.35)
    place = np.concatenate(points)
    last = len(place) - 1
    triangles = grid_triangles(len(rings), count, around=True).tolist()
    base = (len(rings) - 1) * count
    triangles += fan(base, count, last, turned=False).tolist()
    triangles += [[0, k + 1, k] for k in range(1, count - 1)]
    turned = faced_outward(place, np.array(triangles, np.int64))
    if sign < 0.0:
        place, turned = place * np.array([-1.0, 1.0, 1.0]), turned[:, ::-1]
    points_ = deform(place, face)
    normals = vertex_normals(points_, turned)
    return _mesh(points_, normals, np.tile(_row(head=1.0), (len(place), 1)), np.array(light), turned, place, EAR)


def _teeth() -> BodyMesh:
    """The upper teeth: an arch behind the upper lip."""
    turn = np.linspace(-1.25, 1.25, 9)
    rows = []
    for y, grow in ((1.5345, 0.96), (1.5248, 1.0), (1.5252, 0.84), (1.5345, 0.80)):
        rows.append(
            np.column_stack([0.0200 * grow * np.sin(turn), np.full(9, y), 0.0490 + 0.0305 * grow * np.cos(turn)])
        )
    points = np.concatenate(rows)
    triangles = []
    for r in range(4):
        a, b = 9 * r, 9 * ((r + 1) % 4)
        for k in range(8):
            triangles += [[a + k, b + k, b + k + 1], [a + k, b + k + 1, a + k + 1]]
    for end, flip in ((0, False), (8, True)):
        fan = [[end, 18 + end, 9 + end], [end, 27 + end, 18 + end]]
        triangles += [one[::-1] for one in fan] if flip else fan
    turned = faced_outward(points, np.array(triangles, np.int64))
    light = np.full(len(points), 0.36)
    normals = vertex_normals(points, turned)
    return _mesh(points, normals, np.tile(_row(head=1.0), (len(points), 1)), light, turned, points, TEETH)


@cache
def build_head(level: int, body: str = DEFAULT_BODY, face: int = 0) -> BodyMesh:
    """Return a head with one of the faces of a body (`face_shape.FACES`) at a level of detail; without triangles at the
    levels at which bodies have heads of their own."""
    if level in WITH_HEAD:
        return empty_mesh()
    return cached_mesh(f"head {body} {level} {face}", lambda: _build(level, body, face))


def _build(level: int, body: str, face: int) -> BodyMesh:
    shape = faces_of(body)[face]
    parts = [_face_mesh(level, body, shape), *(_ear(level, sign, shape) for sign in (1.0, -1.0))]
    if level in _EYE_RINGS:
        parts += [*(_eyeball(level, sign) for sign in (1.0, -1.0)), _teeth()]
    return merged(parts)
