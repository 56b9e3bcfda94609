"""Loose clothes: jackets, wide trousers and shoes as shells around the body, moved by the same joints.

A shell is the part of the body's mesh that the garment covers, cut along its hems, lifted off the skin, and closed to
the skin along the hems, so that cloth has thickness. Skirts and what swings are simulated (`live.motion.cloth`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.body.appearance import SHOES
from live.base.body.catalogue import DEFAULT_BODY
from live.render.body.body_mesh import (
    CLOSE,
    COARSE,
    DISTANT,
    FINE,
    BodyMesh,
    build_body,
    cached_mesh,
    empty_mesh,
    merged,
    strongest_weights,
)
from live.render.body.drawn_joints import DRAWN_COUNT
from live.render.body.surface_parts import CLOTH, SECOND_CLOTH, SHIRT, SHOE, SOLE

_Field = Callable[[Float64], Float64]
"""A number for each place (N, 3) of the body in the rest pose [m]."""


@dataclass(frozen=True, slots=True)
class Garment:
    """One shell."""

    covers: _Field
    """Positive where the garment covers the body, about the distance from its hem [m]."""
    lift: _Field
    """How far it stands off the skin [m]."""
    part: int
    """What its surface is (`surface_parts`)."""
    detail: int = 0
    """How often edges of the fine body's triangles are halved around it, for finer outlines; of others once less."""


def _side(place: Float64) -> Float64:
    return np.abs(place[:, 0])


def _jacket_opening(place: Float64) -> Float64:
    """Return half the width of a jacket's front: buttoned at the waist, rounded below, a V above [m]."""
    height = place[:, 1]
    above = np.clip((height - 1.075) / 0.365, 0.0, 1.1)
    return np.asarray(0.006 + 0.050 * above**0.95 + 0.9 * np.clip(1.0 - height, 0.0, 0.3) ** 1.6)


def _jacket_covers(place: Float64) -> Float64:
    side, height = _side(place), place[:, 1]
    opening = np.where(place[:, 2] > 0.0, side - _jacket_opening(place), 1.0)
    neck = np.where(place[:, 2] > 0.0, 1.452, 1.462) - height
    return np.asarray(np.minimum.reduce([height - 0.838, 0.640 - side, opening, neck]))


def _jacket_lift(place: Float64) -> Float64:
    side, height = _side(place), place[:, 1]
    hem = np.clip((1.06 - height) / 0.22, 0.0, 1.0)  # it hangs away from the hips
    sleeve = np.clip((side - 0.21) / 0.08, 0.0, 1.0)
    cuff = np.clip((side - 0.40) / 0.24, 0.0, 1.0)
    top = np.clip((height - 1.385) / 0.025, 0.0, 1.0)  # thin over the shoulder, with a pad at its end
    pad = np.exp(-(((side - 0.186) / 0.030) ** 2))
    return np.asarray(0.0085 + 0.016 * hem**1.4 - 0.0025 * sleeve + 0.007 * cuff + top * (0.0075 * pad - 0.0025))


def _lapel_covers(place: Float64) -> Float64:
    """A notched lapel: from the button up to a tip, then back along the seam of the collar."""
    side, height = _side(place), place[:, 1]
    beside = side - _jacket_opening(place)
    wide = 0.070 * np.clip((height - 1.085) / 0.275, 0.0, 1.2) ** 0.85
    seam = 1.377 - 0.30 * beside
    return np.asarray(np.where(place[:, 2] > 0.0, np.minimum.reduce([beside, wide - beside, seam - height]), -1.0))


def _collar_covers(place: Float64) -> Float64:
    """The collar: around the neck, over the shoulders, down to a point above the notch."""
    side, height = _side(place), place[:, 1]
    front = place[:, 2] > 0.0
    beside = np.where(front, side - _jacket_opening(place), 1.0)
    wide = np.where(front, 0.048 - beside + 0.35 * np.clip(height - 1.385, 0.0, 1.0), 0.098 - side)
    low = np.where(front, height - 1.380 - 0.28 * np.clip(beside - 0.008, 0.0, 1.0), height - 1.398)
    return np.asarray(np.minimum.reduce([beside, wide, low, np.where(front, 1.4535, 1.4635) - height]))


def _lapel_lift(place: Float64) -> Float64:
    fold = np.exp(-((np.clip(_side(place) - _jacket_opening(place), 0.0, 1.0) / 0.012) ** 2))
    return np.asarray(_jacket_lift(place) + 0.0045 + 0.0035 * fold)


def _collar_lift(place: Float64) -> Float64:
    return np.asarray(_jacket_lift(place) + 0.006 + 0.05 * np.clip(place[:, 1] - 1.435, 0.0, 0.05))


def _pocket_covers(place: Float64) -> Float64:
    """The flaps of the pockets."""
    side, height = _side(place), place[:, 1]
    slant = height - 0.965 - 0.12 * (side - 0.09)
    flap = np.minimum(0.052 - np.abs(side - 0.092), 0.019 - np.abs(slant))
    return np.asarray(np.where(place[:, 2] > 0.0, flap, -1.0))


def _pocket_lift(place: Float64) -> Float64:
    return np.asarray(_jacket_lift(place) + 0.004)


def _shirt_covers(place: Float64) -> Float64:
    """A shirt's collar: a band around the neck, open in front, with two points."""
    side, height = _side(place), place[:, 1]
    front = np.clip((place[:, 2] + 0.010) / 0.030, 0.0, 1.0)
    apart = np.where(place[:, 2] > 0.0, side - 0.004 - 0.55 * np.clip(height - 1.424, 0.0, 1.0), 1.0)
    low = 1.440 - front * (0.012 + 0.016 * np.exp(-(((side - 0.030) / 0.014) ** 2)))
    return np.asarray(np.minimum.reduce([apart, 0.075 - side, height - low, 1.476 - 0.018 * front - height]))


def _shirt_lift(place: Float64) -> Float64:
    return np.asarray(0.0045 + 0.10 * np.clip(1.452 - place[:, 1], 0.0, 0.03))


def _trousers_covers(place: Float64) -> Float64:
    return np.asarray(np.minimum.reduce([0.985 - place[:, 1], place[:, 1] - 0.100, 0.30 - _side(place)]))


def _trousers_lift(place: Float64) -> Float64:
    height = place[:, 1]
    thigh = np.clip((0.95 - height) / 0.12, 0.0, 1.0)
    knee = np.clip((0.80 - height) / 0.35, 0.0, 1.0)
    hem = np.clip((0.46 - height) / 0.36, 0.0, 1.0)
    inner = np.clip((0.09 - _side(place)) / 0.09, 0.0, 1.0)  # thighs are near each other
    return (0.004 + 0.007 * thigh + 0.014 * knee + 0.030 * hem**1.3) * (1.0 - 0.45 * inner)


def _sneaker_covers(place: Float64) -> Float64:
    return 0.088 + 0.08 * np.clip(-place[:, 2], 0.0, 0.05) - place[:, 1]


def _sneaker_lift(place: Float64) -> Float64:
    return np.where(place[:, 1] > 0.06, 0.0085, 0.0055)


def _boot_lift(place: Float64) -> Float64:
    return np.asarray(0.0055 + 0.010 * np.clip((place[:, 1] - 0.18) / 0.15, 0.0, 1.0))


def _boot_covers(place: Float64) -> Float64:
    return 0.330 + 0.15 * np.clip(place[:, 2], -0.1, 0.1) - place[:, 1]


def _slipper_covers(height: float, instep: float) -> _Field:
    """Return what a low shoe covers: to a height [m], less on the instep."""

    def covers(place: Float64) -> Float64:
        front = np.minimum(place[:, 2] + 0.010, 0.118 - place[:, 2])
        opening = np.maximum(np.minimum(4.0 * front, height - 0.022), 0.0)
        return np.asarray(height - place[:, 1] - instep * opening)

    return covers


def _thin(place: Float64) -> Float64:
    return np.full(len(place), 0.003)


_TROUSERS: Final = Garment(_trousers_covers, _trousers_lift, SECOND_CLOTH)
GARMENTS: Final[dict[str, tuple[Garment, ...]]] = {
    "jacket": (
        Garment(_jacket_covers, _jacket_lift, CLOTH),
        Garment(_lapel_covers, _lapel_lift, SECOND_CLOTH, detail=2),
        Garment(_collar_covers, _collar_lift, SECOND_CLOTH, detail=2),
        Garment(_pocket_covers, _pocket_lift, CLOTH, detail=2),
        Garment(_shirt_covers, _shirt_lift, SHIRT, detail=2),
        _TROUSERS,
    ),
    "trousers": (_TROUSERS,),
    "ballet": (Garment(_slipper_covers(0.072, 0.75), _thin, SHOE),),
    "pumps": (Garment(_slipper_covers(0.066, 0.85), _thin, SHOE),),
    "sneakers": (
        Garment(_sneaker_covers, _sneaker_lift, SHOE),
        Garment(lambda place: 0.026 - place[:, 1], lambda place: np.full(len(place), 0.0105), SOLE),
    ),
    "boots": (
        Garment(_boot_covers, _boot_lift, SHOE),
        Garment(lambda place: 0.016 - place[:, 1], lambda place: np.full(len(place), 0.0095), SHOE),
    ),
}
"""By the names of costumes and shoes that have shells."""
MAX_LIFT: Final = 0.06
"""No shell stands farther off the skin than this [m]."""


_NEAR_M: Final = 0.09
"""Triangles are refined that are nearer to what is covered than this [m]."""


@cache
def build_garment(level: int, body: str = DEFAULT_BODY, name: str = "jacket") -> BodyMesh:
    """Return the shells of a costume or of shoes for a body at a level of detail; without triangles if there are none:
    far away clothes are only painted."""
    if name not in GARMENTS or level in (COARSE, DISTANT):
        return empty_mesh()
    return cached_mesh(
        f"garment {name} {body} {level}",
        lambda: merged(
            [_shell(build_body(_base(level, name), body), garment, level == FINE) for garment in GARMENTS[name]]
        ),
    )


def _base(level: int, name: str) -> int:
    """Return the level of the body around which a garment is made: shoes have no toes."""
    return CLOSE if level == FINE and name in SHOES else level


def _dense(mesh: BodyMesh) -> Float64:
    """Return place, position, normal, openness and all weights of a mesh's vertices, shape (V, 10 + DRAWN_COUNT)."""
    weights = np.zeros((len(mesh.position), DRAWN_COUNT))
    for column in range(mesh.joint.shape[1]):
        np.add.at(weights, (np.arange(len(weights)), mesh.joint[:, column]), mesh.weight[:, column])
    return np.concatenate([mesh.place, mesh.position, mesh.normal, mesh.openness[:, None], weights], axis=1)


def _shell(mesh: BodyMesh, garment: Garment, fine: bool) -> BodyMesh:
    rows, triangles = _dense(mesh), mesh.triangle.astype(np.int64)
    for _ in range(garment.detail if fine else garment.detail - 1):
        rows, triangles = _refined(rows, triangles, garment.covers)
    rows, triangles, hem = cut_mesh(rows, triangles, garment.covers)
    place, position, normal = rows[:, :3], rows[:, 3:6], rows[:, 6:9]
    lift = np.clip(garment.lift(place), 0.0, MAX_LIFT)
    outside = position + normal * lift[:, None]
    outside[:, 1] = np.maximum(outside[:, 1], np.minimum(position[:, 1], 0.001))
    normals = _normals(outside, triangles, normal, len(rows))
    if garment.detail:  # halved triangles are as flat as the body's; its normals are smooth
        normals += 2.0 * normal
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    # the hem: a strip from the outside down to the skin
    corners = np.unique(hem)
    inner = np.searchsorted(corners, hem) + len(rows)
    strip = np.concatenate(
        [np.column_stack([hem[:, 1], hem[:, 0], inner[:, 0]]), np.column_stack([hem[:, 1], inner[:, 0], inner[:, 1]])]
    )
    points = np.concatenate([outside, position[corners] + normal[corners] * 0.001])
    every = np.concatenate([np.arange(len(rows)), corners])
    faces = np.concatenate([triangles, strip])
    joint, weight = strongest_weights(rows[every, 10:])
    openness = rows[every, 9]
    openness[len(rows) :] *= 0.5
    return BodyMesh(
        np.ascontiguousarray(points, np.float32),
        np.ascontiguousarray(normals[every], np.float32),
        joint, weight,
        np.ascontiguousarray(openness, np.float32),
        np.ascontiguousarray(faces, np.int32),
        np.ascontiguousarray(place[every], np.float32),
        np.full(len(every), garment.part, np.int32),
    )  # fmt: skip


def _refined(rows: Float64, triangles: Int64, covers: _Field) -> tuple[Float64, Int64]:
    """Return rows and the triangles near what is covered, each split into four."""
    near = (covers(rows[:, :3])[triangles] > -_NEAR_M).any(axis=1)
    triangles = triangles[near]
    edges = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    pairs, middle = np.unique(edges, axis=0, return_inverse=True)
    ends = rows[pairs]
    halves = ends.mean(axis=1)
    # on the curve between the ends, by their tangent planes (Boubekeur and Alexa, Phong Tessellation, 2008)
    above = ((halves[:, None, 3:6] - ends[:, :, 3:6]) * ends[:, :, 6:9]).sum(axis=2, keepdims=True)
    halves[:, 3:6] -= 0.5 * (above * ends[:, :, 6:9]).mean(axis=1)
    halves[:, 6:9] /= np.maximum(np.linalg.norm(halves[:, 6:9], axis=1, keepdims=True), 1e-9)
    a, b, c = triangles.T
    ab, bc, ca = (middle.reshape(-1, 3) + len(rows)).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([rows, halves]), np.concatenate([np.column_stack(part) for part in parts])


def _normals(points: Float64, triangles: Int64, fallback: Float64, count: int) -> Float64:
    """Return unit normals of the first `count` points, from the triangles around them."""
    total = np.zeros((len(points), 3))
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    across = np.cross(b - a, c - a)
    for corner in range(3):
        np.add.at(total, triangles[:, corner], across)
    length = np.linalg.norm(total[:count], axis=1, keepdims=True)
    return np.where(length > 1e-12, total[:count] / np.maximum(length, 1e-12), fallback)


def cut_mesh(rows: Float64, triangles: Int64, covers: _Field) -> tuple[Float64, Int64, Int64]:
    """Cut a mesh along the line where `covers` is zero and keep where it is positive.

    rows (V, N): data of the vertices, the place first; triangles (T, 3). Returns rows and triangles of what is kept,
    and the edges of the cut (E, 2) in the direction of the triangles beside them.
    """
    value = covers(rows[:, :3])
    inside = value > 0.0
    kept = [triangles[inside[triangles].all(axis=1)]]
    new_rows: list[Float64] = []
    crossing: dict[tuple[int, int], int] = {}
    hem: list[tuple[int, int]] = []

    def between(a: int, b: int) -> int:
        """Return the vertex where the edge from a to b is cut."""
        key = (min(a, b), max(a, b))
        if key not in crossing:
            share = value[key[0]] / (value[key[0]] - value[key[1]])
            crossing[key] = len(rows) + len(new_rows)
            new_rows.append(rows[key[0]] * (1.0 - share) + rows[key[1]] * share)
        return crossing[key]

    for corners in triangles[inside[triangles].any(axis=1) & ~inside[triangles].all(axis=1)].tolist():
        turn = next(at for at in range(3) if inside[corners[at]] and not inside[corners[at - 1]])
        a, b, c = corners[turn], corners[(turn + 1) % 3], corners[(turn + 2) % 3]  # a stays, c does not
        if inside[b]:
            first, second = between(b, c), between(a, c)
            kept.append(np.array([[a, b, first], [a, first, second]]))
        else:
            first, second = between(a, b), between(a, c)
            kept.append(np.array([[a, first, second]]))
        hem.append((first, second))
    every = np.concatenate([rows, np.array(new_rows).reshape(-1, rows.shape[1])])
    faces = np.concatenate(kept)
    used, renumbered = np.unique(faces, return_inverse=True)
    edges = np.searchsorted(used, np.array(hem, np.int64).reshape(-1, 2))
    return every[used], renumbered.reshape(-1, 3), edges
