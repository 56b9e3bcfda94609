"""Hair styles: closed meshes that sit on the head, a cap on the scalp and what stands out or hangs from it.

A cap is a grid over the head's own grid (`head_cage.py`): from the hairline up to the crown, lifted by the hair's
thickness, its border sunk into the head. Hanging hair is skinned: to the head above, to neck and chest below.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.base.body.catalogue import DEFAULT_BODY
from live.render.body.body_mesh import (
    CLOSE,
    COARSE,
    DISTANT,
    FINE,
    LIGHT,
    BodyMesh,
    cached_mesh,
    empty_mesh,
    merged,
    strongest_weights,
)
from live.render.body.body_variants import trunk_of
from live.render.body.closed_meshes import ball, catmull_rom, faced_outward, fan, grid_triangles, vertex_normals
from live.render.body.drawn_joints import DRAWN_COUNT, DRAWN_NAMES
from live.render.body.face_shape import FaceShape, deform, faces_of
from live.render.body.head_cage import grid_points
from live.render.body.implicit_surface import Shape
from live.render.body.surface_parts import HAIR

_Curve = tuple[tuple[float, float], ...]
"""Column of the head's grid from 0 (front) to 10 (back), and a value."""


@dataclass(frozen=True, slots=True)
class _Cap:
    """Hair on the scalp."""

    hairline: _Curve
    """Row of the head's grid at which it begins."""
    thickness: _Curve
    """How far it stands out near the border [m]; …"""
    crown: float
    """… and at the crown."""
    curl: float = 0.0
    """Height of its curls [m]."""
    falls: _Curve = ()
    """For loose hair the height to which it falls [m], by column, from the first one that falls on."""


_HAIRLINE: Final[_Curve] = (
    (0.0, 17.75), (1.5, 17.70), (3.0, 17.35), (4.0, 16.9), (4.8, 16.4), (5.4, 14.6), (5.9, 11.6), (6.25, 11.8),
        (6.5, 14.4),
    (7.0, 15.1), (7.5, 14.2), (7.9, 10.5), (8.4, 7.5), (9.2, 6.0), (10.0, 5.6),
)  # fmt: skip
_HIGH_HAIRLINE: Final[_Curve] = tuple((c, r + 0.25 * max(0.0, 1.0 - abs(c - 3.4) / 1.6)) for c, r in _HAIRLINE)
_ROUND_HAIRLINE: Final[_Curve] = (
    (0.0, 17.65), (1.5, 17.55), (3.0, 17.2), (4.0, 16.7), (4.8, 16.2), (5.5, 15.2), (6.2, 14.6), (7.0, 14.4),
        (7.6, 13.2),
    (8.2, 10.0), (9.2, 7.5), (10.0, 7.0),
)  # fmt: skip
_LOOSE_HAIRLINE: Final[_Curve] = (
    (0.0, 17.75), (1.5, 17.70), (3.0, 17.35), (4.0, 16.9), (4.7, 16.5), (5.0, 16.3), (5.5, 16.0), (6.2, 15.8),
        (7.0, 15.8),
    (7.8, 15.8), (8.6, 15.8), (9.4, 15.8), (10.0, 15.8),
)  # fmt: skip
_SMOOTH: Final = _Cap(_HAIRLINE, ((0.0, 0.0035), (5.0, 0.0035), (10.0, 0.0040)), 0.0075)
_LOOSE: Final = ((0.0, 0.0070), (3.0, 0.0090), (4.5, 0.0120), (6.0, 0.0160), (7.5, 0.0180), (10.0, 0.0170))
CAPS: Final[dict[str, _Cap]] = {
    "bun": _SMOOTH,
    "crop": _Cap(_HIGH_HAIRLINE, ((0.0, 0.0090), (3.5, 0.0065), (6.0, 0.0032), (10.0, 0.0040)), 0.0130, 0.0012),
    "bob": _Cap(_LOOSE_HAIRLINE, _LOOSE, 0.0150, falls=((5.0, 1.513), (6.5, 1.508), (10.0, 1.500))),
    "ponytail": _SMOOTH,
    "long": _Cap(
        _LOOSE_HAIRLINE, _LOOSE, 0.0150, falls=((5.5, 1.475), (6.2, 1.462), (7.0, 1.420), (8.0, 1.365), (10.0, 1.345))
    ),
    "curls": _Cap(
        _ROUND_HAIRLINE, ((0.0, 0.020), (4.0, 0.026), (6.0, 0.034), (8.0, 0.036), (10.0, 0.034)), 0.046, 0.0075
    ),
    "braid": _SMOOTH,
}
"""The cap of each hair style; `bald` has none."""

_CAP_GRID: Final = {COARSE: (5, 2), DISTANT: (6, 2), LIGHT: (9, 3), CLOSE: (18, 6), FINE: (30, 10)}
"""Columns of half a cap, and its rows."""
_TUBE: Final = {COARSE: (4, 3), DISTANT: (4, 3), LIGHT: (5, 5), CLOSE: (9, 10), FINE: (12, 20)}
"""Segments around hanging hair, and along it."""
_BALL: Final = {COARSE: (3, 5), DISTANT: (3, 5), LIGHT: (4, 7), CLOSE: (7, 12), FINE: (10, 18)}
_LIFT: Final = {COARSE: 0.005, DISTANT: 0.005, LIGHT: 0.0036}
"""How much farther out coarse caps lie, so that their flat faces do not cut into the head [m]."""
_SINK: Final = 0.005
"""How far the border of a cap lies in the head [m]."""
_MIDDLE: Final = (0.0, 1.625, -0.010)


def _mesh(
    points: Float64, triangles: Int64, weights: Float64, light: Float64, shape: FaceShape, place: Float64
) -> BodyMesh:
    triangles = faced_outward(points, triangles)
    points = deform(points, shape)
    joint, weight = strongest_weights(weights)
    return BodyMesh(
        np.ascontiguousarray(points, np.float32), np.ascontiguousarray(vertex_normals(points, triangles), np.float32),
        joint, weight, np.ascontiguousarray(light, np.float32), np.ascontiguousarray(triangles, np.int32),
        np.ascontiguousarray(place, np.float32), np.full(len(points), HAIR, np.int32),
    )  # fmt: skip


def _weights(points: Float64, *, hangs: bool = False) -> Float64:
    """Return weights: all to the head; where hair hangs below it, more and more to neck and chest."""
    weights = np.zeros((len(points), DRAWN_COUNT))
    y = points[:, 1]
    head = np.interp(y, (1.40, 1.50, 1.56), (0.0, 0.45, 1.0)) if hangs else np.ones(len(points))
    neck = np.interp(y, (1.34, 1.42, 1.50), (0.0, 0.45, 1.0)) * (1.0 - head)
    for name, share in (("head", head), ("neck", neck), ("upperChest", 1.0 - head - neck)):
        weights[:, DRAWN_NAMES.index(name)] = share
    return weights


def _cap(level: int, cap: _Cap, shape: FaceShape, body: str) -> BodyMesh:
    columns, rows = _CAP_GRID[level]
    lines = np.array(cap.hairline)
    # denser where the hairline bends, around the ear
    at = np.interp(np.linspace(0.0, len(lines) - 1.0, columns), np.arange(len(lines)), lines[:, 0])
    low = np.interp(at, lines[:, 0], lines[:, 1])
    rise = np.linspace(0.0, 1.0, rows + 1)
    grid_row = _rows_between(low, np.broadcast_to(rise[:, None], (rows + 1, columns)))
    falling = np.zeros(columns, np.bool_)
    if cap.falls:
        falls = np.array(cap.falls)
        falling = at >= falls[0, 0]
        share = 0.5  # of the rows hang
        on_scalp = np.clip((rise - share) / (1.0 - share), 0.0, 1.0)
        grid_row[:, falling] = _rows_between(
            low[falling], np.broadcast_to(on_scalp[:, None], (rows + 1, falling.sum()))
        )
    grid_column = np.broadcast_to(at, grid_row.shape)
    on_head = grid_points(grid_row.ravel(), grid_column.ravel())
    outward = on_head - np.array(_MIDDLE)
    outward[:, 1] *= np.clip((on_head[:, 1] - 1.58) / 0.06, 0.15, 1.0)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    edge = np.interp(grid_column.ravel(), *np.array(cap.thickness).T)
    up = np.repeat(rise, columns)
    thick = edge + (cap.crown - edge) * np.sin(0.5 * np.pi * up) ** 1.5
    thick = thick * np.where(np.tile(falling, rows + 1), 1.0, np.minimum(0.45 + 1.6 * up, 1.0))
    if cap.curl and level in (FINE, CLOSE, LIGHT):
        thick += cap.curl * _bumps(on_head)
    outer = on_head + outward * (thick + _LIFT.get(level, 0.0) * np.minimum(3.0 * up, 1.0))[:, None]
    if cap.falls:
        hang = np.clip(1.0 - rise / share, 0.0, 1.0)[:, None]  # 1 at the ends, 0 on the scalp
        ends = np.interp(at, falls[:, 0], falls[:, 1])
        grid = outer.reshape(rows + 1, columns, 3)
        grid[:, falling] = _fallen(grid[:, falling], hang, ends[falling], body)
        outer = grid.reshape(-1, 3)
    inward = np.where(falling[:, None], np.array([0.0, 0.004, 0.0]) - 0.010 * outward[:columns], 0.0)
    sunk = outer[:columns] - outward[:columns] * np.where(falling, 0.0, thick[:columns] + _SINK)[:, None] + inward
    half = np.concatenate([sunk, outer]).reshape(rows + 2, columns, 3)
    half[:, 0, 0] = half[:, -1, 0] = 0.0
    other = half[:, -2:0:-1] * np.array([-1.0, 1.0, 1.0])
    around = np.concatenate([half, other], axis=1)
    count = around.shape[1]
    points = around.reshape(-1, 3)
    top = points[-count:].mean(axis=0) + np.array([0.0, 0.0035, 0.0])
    points = np.concatenate([points, top[None], np.array([_MIDDLE])])
    last = (rows + 1) * count
    triangles = np.concatenate(
        [
            grid_triangles(rows + 2, count, around=True),
            fan(last, count, len(points) - 2, turned=False),
            fan(0, count, len(points) - 1, turned=True),
        ]
    )
    light = np.full(len(points), 0.95)
    light[: 2 * count] = 0.72
    light[-1] = 0.25
    # along the strands: from the border up
    steps = np.linalg.norm(np.diff(around, axis=0, prepend=around[:1]), axis=2)
    steps[1] = 0.0
    along = np.cumsum(steps, axis=0)
    across = np.cumsum(np.linalg.norm(np.diff(half[-1 - rows // 2], axis=0, prepend=half[-1 - rows // 2, :1]), axis=1))
    across = np.concatenate([across, -across[-2:0:-1]])
    place = np.zeros((len(points), 3))
    place[:-2, 0] = np.tile(across, rows + 2)
    place[:-2, 1] = along.ravel()
    place[-2:, 1] = along.max() + 0.02
    place[:, 2] = 1.0 if cap.curl > 0.005 else 0.0
    return _mesh(points, triangles, _weights(points, hangs=bool(cap.falls)), light, shape, place)


def _rows_between(low: Float64, share: Float64) -> Float64:
    """Return rows of the head's grid from `low` (C,) to the crown at shares of the way over the skull (R, C)."""
    column = np.full(21, 6.5)
    steps = np.linalg.norm(np.diff(grid_points(np.arange(21.0), column), axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    begin = np.interp(low, np.arange(21.0), way)
    return np.asarray(np.interp(begin + share * (way[-1] - begin), way, np.arange(21.0)))


def _bumps(points: Float64) -> Float64:
    """Return smooth unevenness from -1 to 1 at points (N, 3)."""
    a, b, c = (points * np.array([260.0, 240.0, 270.0])).T
    first = np.sin(a + 0.8 * np.sin(b)) * np.sin(b + 0.7 * np.sin(c)) * np.sin(c + 0.9 * np.sin(a) + 0.5)
    second = np.sin(1.9 * a + 1.0) * np.sin(2.1 * b) * np.sin(1.8 * c + 2.0)
    return np.asarray(0.9 * first + 0.45 * second)


def _fallen(points: Float64, hang: Float64, ends: Float64, body: str) -> Float64:
    """Let rows of points (R, C, 3) hang: from where they leave the scalp down to heights `ends` (C,), over the body."""
    leave = points[np.argmin(np.abs(hang[:, 0]) + (hang[:, 0] > 0.0))]
    drop = leave[:, 1] - ends
    out = points.copy()
    out[..., 1] = np.where(hang > 0.0, leave[:, 1] - drop * hang, points[..., 1])
    around = leave * np.array([1.0, 0.0, 1.0]) - np.array([0.0, 0.0, -0.012])
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    swell = 0.010 * np.sin(np.pi * hang**0.8) * (hang > 0.0)
    out += around * swell[..., None] * np.array([0.6, 0.0, 1.0])
    below = np.clip((1.565 - out[..., 1]) / 0.10, 0.0, 1.0)[..., None]
    out += (out * np.array([0.84, 1.0, 0.90]) - out) * below
    flat = out.reshape(-1, 3)
    shape = Shape(trunk_of(body))
    for _ in range(4):
        near = np.maximum(0.012 - shape.distance(flat), 0.0) * (flat[:, 1] < 1.55)
        flat = flat + shape.normal(flat) * near[:, None]
    return flat.reshape(points.shape)


def _knot(
    level: int, centre: tuple[float, float, float], radii: tuple[float, float, float], shape: FaceShape
) -> BodyMesh:
    """Hair wound up in a knot: an ellipsoid with a spiral on it."""
    unit, triangles = ball(*_BALL[level])
    turn = np.arctan2(unit[:, 1], unit[:, 0])
    ripple = 1.0 + (
        0.05 * np.sin(2.0 * turn + 14.0 * unit[:, 2]) * (1.0 - unit[:, 2] ** 2) if level in (FINE, CLOSE) else 0.0
    )
    tilt = 0.7
    local = unit * np.array(radii) * np.reshape(ripple, (-1, 1))
    c, s = np.cos(tilt), np.sin(tilt)
    points = np.column_stack([local[:, 0], c * local[:, 1] + s * local[:, 2], -c * local[:, 2] + s * local[:, 1]])
    points += np.array(centre)
    place = np.column_stack([0.03 * unit[:, 2] + 0.006 * turn, 0.05 + 0.03 * turn, np.zeros(len(unit))])
    return _mesh(points, triangles, _weights(points), np.full(len(points), 0.92), shape, place)


def _tube(
    level: int,
    line: Callable[[Float64], Float64],
    radius: Callable[[Float64], Float64],
    flat: float,
    shape: FaceShape,
    body: str,
) -> BodyMesh:
    """Hanging hair around a line: `line(t)` (N, 3), `radius(t)` (N,) for shares 0 to 1, `flat`: depth by width."""
    segments, pieces = _TUBE[level]
    share = np.linspace(0.0, 1.0, pieces + 1)
    middle = _off_body(line(share), radius(share) * flat, body)
    turn = 2.0 * np.pi * np.arange(segments) / segments
    along = np.gradient(middle, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.array([1.0, 0.0, 0.0])
    deep = np.cross(along, side)
    ring = (
        side * (np.cos(turn)[None, :, None] * radius(share)[:, None, None])
        + deep[:, None, :] * (np.sin(turn)[None, :, None] * radius(share)[:, None, None] * flat)
        + middle[:, None, :]
    )
    points = np.concatenate([ring.reshape(-1, 3), middle[:1], middle[-1:] + 0.4 * (middle[-1:] - middle[-2:-1])])
    triangles = np.concatenate(
        [
            grid_triangles(pieces + 1, segments, around=True),
            fan(pieces * segments, segments, len(points) - 1, turned=False),
            fan(0, segments, len(points) - 2, turned=True),
        ]
    )
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    place = np.zeros((len(points), 3))
    place[:-2, 0] = np.tile(0.024 * np.abs(turn - np.pi), pieces + 1)
    place[:-2, 1] = 0.05 + np.repeat(length, segments)
    place[-2:, 1] = 0.05, 0.05 + length[-1]
    return _mesh(points, triangles, _weights(points, hangs=True), np.full(len(points), 0.85), shape, place)


def _off_body(points: Float64, room: Float64, body: str) -> Float64:
    """Move points that are nearer to the trunk than `room` (N,) [m] out of it."""
    shape = Shape(trunk_of(body))
    for _ in range(3):
        near = np.maximum(room + 0.003 - shape.distance(points), 0.0)
        points = points + shape.normal(points) * near[:, None] * np.array([0.0, 0.0, 1.0])
    return points


def _tail(level: int, shape: FaceShape, body: str) -> BodyMesh:
    curve = np.array([(0.0, 1.664, -0.088), (0.0, 1.668, -0.118), (0.0, 1.640, -0.145), (0.0, 1.585, -0.150),
        (0.0, 1.520, -0.142),
                      (0.0, 1.450, -0.135)])  # fmt: skip
    return _tube(
        level,
        lambda t: _along(curve, t),
        lambda t: np.interp(t, (0.0, 0.12, 0.45, 0.85, 1.0), (0.013, 0.012, 0.024, 0.017, 0.004)),
        0.75, shape, body,
    )  # fmt: skip


def _plait(level: int, shape: FaceShape, body: str) -> BodyMesh:
    curve = np.array([(0.0, 1.585, -0.086), (0.0, 1.560, -0.100), (0.0, 1.500, -0.090), (0.0, 1.420, -0.100),
        (0.0, 1.330, -0.115),
                      (0.0, 1.250, -0.115)])  # fmt: skip
    return _tube(
        level,
        lambda t: _along(curve, t),
        lambda t: (
            np.interp(t, (0.0, 0.1, 0.8, 0.9, 1.0), (0.020, 0.021, 0.013, 0.010, 0.003))
            * (1.0 + (0.17 * np.sin(60.0 * t) if level in (FINE, CLOSE) else 0.0))
        ),
        0.7, shape, body,
    )  # fmt: skip


def _along(curve: Float64, share: Float64) -> Float64:
    """Return points on a smooth curve through `curve` (Catmull and Rom 1974)."""
    return catmull_rom(curve, share * (len(curve) - 1))


@cache
def build_hair(level: int, body: str = DEFAULT_BODY, style: str = "bun", *, hanging: bool = True) -> BodyMesh:
    """Return a hair style (`live.base.body.appearance.HAIRS`) for a body at a level of detail, without triangles for
    `bald`; without `hanging`: only what lies on the head, where the rest is a garment that moves by itself."""
    if style not in CAPS:
        return empty_mesh()
    cap = CAPS[style] if hanging or style != "long" else _SMOOTH
    return cached_mesh(f"hair {style} {body} {level} {hanging}", lambda: _built(level, body, style, cap, hanging))


def _built(level: int, body: str, style: str, cap: _Cap, hanging: bool) -> BodyMesh:
    faces = faces_of(body)
    shape = FaceShape(skull=max(face.skull for face in faces), forehead=max(face.forehead for face in faces))
    flat = level == COARSE and not cap.falls and cap.crown < 0.02  # its shadow is the skull's
    parts = [] if flat else [_cap(level, cap, shape, body)]
    if style == "bun":
        parts.append(_knot(level, (0.0, 1.674, -0.096), (0.040, 0.040, 0.030), shape))
    elif style == "ponytail" and hanging:
        parts.append(_tail(level, shape, body))
    elif style == "braid" and hanging:
        parts.append(_plait(level, shape, body))
    return merged(parts) if parts else empty_mesh()
