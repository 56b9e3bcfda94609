"""Body types: women, men and a child, by age and build, as variants of the dancer's body on the same skeleton.

A type multiplies the half-widths of the usual body's parts at positions along them, and may add parts. Bones and
muscles under the skin go with the limb that they lie on. The joints do not move, so contacts of feet and hands hold for
all types.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.render.body import body_parts as usual
from live.render.body.body_parts import BODY, Part
from live.render.body.hand_parts import HAND
from live.render.body.implicit_surface import Ellipsoid, Loft, Shape

_Curve = tuple[tuple[float, float, float, float], ...]
"""Rows (position along the part from 0 to 1, factors of its half-widths across, in front and behind)."""


@dataclass(frozen=True, slots=True)
class BodyType:
    """Parameters of a body type; a curve of one row is constant along the part."""

    torso: _Curve = ((0.0, 1.0, 1.0, 1.0),)
    leg: _Curve = ((0.0, 1.0, 1.0, 1.0),)
    arm: _Curve = ((0.0, 1.0, 1.0, 1.0),)
    neck: float = 1.0
    head: float = 1.0
    hand: float = 1.0
    foot: float = 1.0
    shoulder: float = 1.0
    chest: tuple[float, float, float] = (1.0, 1.0, 1.0)
    chest_drop: float = 0.0
    """How far the breasts hang [m]."""
    seat: float = 1.0
    muscle: float = 1.0
    """How far muscles and bones stand out: 0 under soft skin, 2 an athlete's."""
    extra_parts: tuple[Ellipsoid, ...] = ()
    """Parts added to the torso."""


_BELLY: Final = Ellipsoid((0.0, 1.020, 0.060), (0.120, 0.110, 0.085), 0.070)

TYPES: Final[dict[str, BodyType]] = {
    DEFAULT_BODY: BodyType(),
    "woman": BodyType(
        torso=(
            (0.0, 1.02, 1.06, 1.06), (0.25, 1.06, 1.06, 1.06), (0.5, 1.14, 1.14, 1.08), (0.62, 1.19, 1.20, 1.10),
            (0.75, 1.11, 1.14, 1.06), (0.9, 1.05, 1.06, 1.05), (1.0, 1.05, 1.04, 1.04),
        ),
        leg=((0.0, 1.06, 1.05, 1.05), (0.3, 1.10, 1.06, 1.08), (0.5, 1.08, 1.05, 1.06), (1.0, 1.04, 1.02, 1.02)),
        arm=((0.0, 1.08, 1.08, 1.08), (0.3, 1.14, 1.12, 1.12), (1.0, 1.04, 1.03, 1.03)),
        neck=1.02, shoulder=1.0, chest=(1.10, 1.10, 1.18), chest_drop=0.006, seat=1.05, muscle=0.4,
    ),
    "man": BodyType(
        torso=(
            (0.0, 1.08, 1.12, 1.10), (0.14, 1.14, 1.08, 1.10), (0.3, 1.15, 1.06, 1.08), (0.48, 1.21, 1.10, 1.06),
            (0.62, 1.26, 1.16, 1.10), (0.75, 1.08, 1.10, 1.00), (0.9, 0.92, 1.00, 0.93), (1.0, 0.90, 1.0, 0.92),
        ),
        leg=((0.0, 0.89, 1.00, 0.92), (0.3, 0.96, 1.04, 0.98), (0.5, 1.06, 1.06, 1.05), (0.65, 1.06, 1.05, 1.06),
             (1.0, 1.08, 1.06, 1.06)),
        arm=((0.0, 1.12, 1.12, 1.12), (0.25, 1.16, 1.18, 1.16), (0.5, 1.12, 1.12, 1.12), (0.64, 1.18, 1.18, 1.16),
             (1.0, 1.12, 1.10, 1.10)),
        neck=1.15, head=1.02, hand=1.08, foot=1.06, shoulder=1.20, chest=(1.32, 0.88, 0.92), chest_drop=-0.034,
        seat=0.86, muscle=1.2,
    ),
    "slim": BodyType(
        torso=((0.0, 0.97, 0.95, 0.95), (0.35, 0.90, 0.92, 0.91), (0.6, 0.93, 0.95, 0.93), (1.0, 0.90, 0.92, 0.88)),
        leg=((0.0, 0.90, 0.90, 0.90), (0.35, 0.83, 0.84, 0.84), (0.65, 0.87, 0.90, 0.84), (1.0, 0.92, 0.95, 0.95)),
        arm=((0.0, 0.88, 0.88, 0.88), (0.5, 0.82, 0.82, 0.82), (1.0, 0.92, 0.92, 0.92)),
        neck=0.92, head=0.97, hand=0.96, foot=0.96, shoulder=0.90, chest=(0.88, 0.90, 0.80), seat=0.88,
    ),
    "strong": BodyType(
        torso=(
            (0.0, 1.10, 1.15, 1.10), (0.14, 1.18, 1.12, 1.15), (0.3, 1.20, 1.10, 1.12), (0.48, 1.22, 1.10, 1.08),
            (0.62, 1.28, 1.17, 1.10), (0.8, 1.02, 1.06, 0.98), (0.9, 0.95, 1.00, 0.95), (1.0, 0.95, 1.0, 0.95),
        ),
        leg=((0.0, 0.95, 1.04, 0.98), (0.3, 1.14, 1.14, 1.10), (0.5, 1.10, 1.10, 1.08), (0.65, 1.16, 1.10, 1.16),
             (1.0, 1.08, 1.08, 1.08)),
        arm=((0.0, 1.22, 1.20, 1.20), (0.25, 1.34, 1.36, 1.34), (0.5, 1.18, 1.18, 1.18), (0.64, 1.30, 1.28, 1.25),
             (1.0, 1.15, 1.12, 1.12)),
        neck=1.22, head=1.02, hand=1.10, foot=1.06, shoulder=1.28, chest=(1.40, 0.95, 1.06), chest_drop=-0.034,
        seat=0.92, muscle=1.9,
        extra_parts=(
            Ellipsoid((0.092, 1.215, -0.045), (0.058, 0.105, 0.048), 0.045),  # the broad back
            Ellipsoid((0.040, 1.090, 0.052), (0.040, 0.085, 0.030), 0.035),  # the belly's muscles
        ),
    ),
    "round": BodyType(
        torso=(
            (0.0, 1.06, 1.10, 1.10), (0.2, 1.12, 1.10, 1.12), (0.4, 1.26, 1.24, 1.16), (0.6, 1.42, 1.42, 1.20),
            (0.8, 1.28, 1.30, 1.12), (1.0, 1.14, 1.12, 1.08),
        ),
        leg=((0.0, 1.16, 1.14, 1.14), (0.25, 1.22, 1.18, 1.20), (0.5, 1.20, 1.16, 1.18), (0.65, 1.20, 1.14, 1.16),
             (1.0, 1.10, 1.08, 1.08)),
        arm=((0.0, 1.22, 1.20, 1.20), (0.3, 1.32, 1.30, 1.30), (0.6, 1.22, 1.20, 1.20), (1.0, 1.12, 1.10, 1.10)),
        neck=1.16, head=1.05, hand=1.05, foot=1.04, shoulder=1.10, chest=(1.18, 1.16, 1.25), chest_drop=0.012,
        seat=1.18, muscle=0.0, extra_parts=(_BELLY,),
    ),
    "child": BodyType(
        torso=(
            (0.0, 0.86, 0.90, 0.88), (0.2, 0.82, 0.86, 0.84), (0.45, 0.94, 0.95, 0.92), (0.62, 1.11, 1.09, 1.01),
            (0.85, 0.86, 0.96, 0.84), (1.0, 0.88, 0.92, 0.86),
        ),
        leg=((0.0, 0.88, 0.90, 0.88), (0.35, 0.84, 0.84, 0.84), (0.5, 0.98, 0.98, 0.98), (0.65, 0.86, 0.92, 0.78),
             (1.0, 1.0, 1.0, 1.0)),
        arm=((0.0, 0.86, 0.86, 0.86), (0.5, 0.92, 0.90, 0.90), (1.0, 0.98, 0.98, 0.98)),
        neck=0.86, head=1.18, hand=0.90, foot=0.90, shoulder=0.84, chest=(0.75, 0.80, 0.55), seat=0.80, muscle=0.3,
    ),
    "older woman": BodyType(
        torso=(
            (0.0, 1.02, 1.00, 1.16), (0.16, 1.04, 0.98, 1.18), (0.36, 1.08, 1.02, 1.12), (0.5, 1.20, 1.20, 1.10),
            (0.62, 1.30, 1.32, 1.12), (0.78, 1.16, 1.22, 1.04), (0.9, 1.06, 1.10, 0.98), (1.0, 1.05, 1.04, 0.98),
        ),
        leg=((0.0, 1.04, 1.02, 1.00), (0.3, 1.02, 1.00, 1.00), (0.5, 1.10, 1.06, 1.06), (0.65, 0.98, 1.02, 0.96),
             (1.0, 1.08, 1.04, 1.04)),
        arm=((0.0, 1.00, 1.00, 1.00), (0.25, 1.10, 1.04, 1.06), (0.5, 1.06, 1.04, 1.04), (1.0, 1.03, 1.02, 1.02)),
        neck=1.00, head=1.0, hand=1.02, foot=1.02, shoulder=0.96, chest=(1.08, 1.16, 1.06), chest_drop=0.034,
        seat=0.98, muscle=0.3,
        extra_parts=(Ellipsoid((0.0, 0.990, 0.056), (0.100, 0.080, 0.056), 0.060),),
    ),
    "older man": BodyType(
        torso=(
            (0.0, 1.04, 1.04, 1.18), (0.16, 1.07, 1.00, 1.20), (0.36, 1.10, 1.04, 1.12), (0.5, 1.22, 1.20, 1.08),
            (0.62, 1.34, 1.30, 1.10), (0.78, 1.12, 1.22, 0.98), (0.9, 0.93, 1.08, 0.90), (1.0, 0.92, 1.02, 0.90),
        ),
        leg=((0.0, 0.88, 0.98, 0.92), (0.3, 0.93, 0.96, 0.93), (0.5, 1.04, 1.04, 1.02), (0.65, 0.96, 1.02, 0.94),
             (1.0, 1.08, 1.06, 1.06)),
        arm=((0.0, 1.02, 1.02, 1.02), (0.25, 1.03, 1.04, 1.02), (0.5, 1.08, 1.08, 1.06), (0.64, 1.08, 1.08, 1.06),
             (1.0, 1.10, 1.08, 1.08)),
        neck=1.08, head=1.02, hand=1.07, foot=1.05, shoulder=1.08, chest=(1.24, 0.92, 0.88), chest_drop=-0.020,
        seat=0.82, muscle=0.7,
        extra_parts=(Ellipsoid((0.0, 1.030, 0.058), (0.098, 0.100, 0.062), 0.060),),
    ),
}  # fmt: skip
"""The type for each name of `live.base.body.catalogue`."""


def _at(curve: _Curve, t: float) -> tuple[float, float, float]:
    """Return a curve's factors across, in front and behind at a position."""
    rows = np.array(curve)
    across, front, back = (float(np.interp(t, rows[:, 0], rows[:, column])) for column in (1, 2, 3))
    return across, front, back


def _scaled_loft(loft: Loft, curve: _Curve) -> Loft:
    rows = []
    for t, across, front, back, shift in loft.rows:
        wide, before, behind = _at(curve, t)
        rows.append((t, across * wide, front * before, back * behind, shift))
    return replace(loft, rows=tuple(rows))


def _evenly_scaled_loft(loft: Loft, factor: float) -> Loft:
    return _scaled_loft(loft, ((0.0, factor, factor, factor),))


def _scaled(part: Ellipsoid, *factors: float) -> Ellipsoid:
    three = factors if len(factors) == 3 else factors * 3
    return replace(part, radii=(part.radii[0] * three[0], part.radii[1] * three[1], part.radii[2] * three[2]))


def _scaled_about(part: Ellipsoid, centre: tuple[float, float, float], factor: float) -> Ellipsoid:
    """Scale a part about `centre`."""
    x, y, z = (c + (p - c) * factor for p, c in zip(part.centre, centre, strict=True))
    return replace(_scaled(part, factor), centre=(x, y, z))


def _carried(part: Part, limb: Loft, curve: _Curve, muscle: float) -> Part:
    """Return what lies on a limb where the scaled limb has it, standing out as far as muscles do."""
    start, end = np.array(limb.start), np.array(limb.end)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array(limb.across)

    def moved(place: tuple[float, float, float]) -> tuple[float, float, float]:
        offset = np.array(place) - start
        way = float(offset @ along)
        wide, front, back = _at(curve, way / float(np.linalg.norm(end - start)))
        beside = offset - along * way
        z = beside[2] * (front if beside[2] > 0.0 else back)
        rest = beside * (1.0, 1.0, 0.0) * np.where(np.abs(across) > 0.5, wide, 1.0)
        x, y, deep = start + along * way + rest + (0.0, 0.0, z)
        return float(x), float(y), float(deep)

    size = 1.0 + 0.14 * (muscle - 1.0)
    if isinstance(part, Ellipsoid):
        return replace(_scaled(part, 1.0 if part.hollow else size), centre=moved(part.centre))
    rows = []
    for t, wide, front, back, shift in part.rows:
        place = np.array(part.start) + (np.array(part.end) - np.array(part.start)) * t + (0.0, 0.0, shift)
        on_line = np.array(moved(part.start)) + (np.array(moved(part.end)) - np.array(moved(part.start))) * t
        there = moved((float(place[0]), float(place[1]), float(place[2])))
        rows.append((t, wide, front, back, float(there[2] - on_line[2])))
    return replace(part, start=moved(part.start), end=moved(part.end), rows=tuple(rows))


def _front(parts: list[Part], y: float) -> float:
    """Return how far the middle of the body reaches to the front at a height [m]."""
    line = np.stack([np.zeros(201), np.full(201, y), np.linspace(0.0, 0.3, 201)], axis=1)
    return float(line[np.flatnonzero(Shape(tuple(parts)).distance(line) < 0.0).max(), 2])


_HEAD_ROOT: Final = (0.0, 1.530, 0.0)
"""Centre for scaling the head: where the neck enters it."""


_LIMB_DETAILS: Final = (*usual.ARM_DETAILS, *usual.LEG_DETAILS)


@cache
def parts_of(name: str, *, toes: bool = True, details: bool = True) -> tuple[Part, ...]:
    """Return the parts of the left half of a body, in blending order; ValueError for an unknown name.

    Without its toes (`toes_of`) or, if there are none, with what encloses them; without `details`, arms and legs are
    smooth, because large triangles would catch bones and muscles by chance.
    """
    if name not in TYPES:
        raise ValueError(f"body {name!r}: there are {', '.join(BODIES)}")
    kind = TYPES[name]
    enclosing = () if toes else (_evenly_scaled_loft(usual.TOES_TOGETHER, kind.foot),)
    shown = BODY if details else tuple(part for part in BODY if part not in _LIMB_DETAILS)
    if name == DEFAULT_BODY:
        return *shown, *enclosing
    parts: list[Part] = []
    for part in shown:
        if part is usual.TORSO:
            parts += [_scaled_loft(usual.TORSO, kind.torso), *kind.extra_parts]
        elif part is usual.LEG:
            parts.append(_scaled_loft(usual.LEG, kind.leg))
        elif part is usual.ARM:
            parts.append(_scaled_loft(usual.ARM, kind.arm))
        elif part is usual.NAVEL:
            parts.append(replace(part, centre=(0.0, part.centre[1], _front(parts, part.centre[1]) + 0.005)))
        elif part in (*usual.TORSO_DETAILS, usual.COLLAR):
            parts.append(_carried(part, usual.TORSO, kind.torso, kind.muscle))
        elif part in usual.ARM_DETAILS:
            parts.append(_carried(part, usual.ARM, kind.arm, kind.muscle))
        elif part in usual.LEG_DETAILS:
            parts.append(_carried(part, usual.LEG, kind.leg, kind.muscle))
        else:
            parts.append(_scaled_small_part(part, kind))
    return *parts, *enclosing


def _scaled_small_part(part: Part, kind: BodyType) -> Part:
    if part in HAND:
        return _evenly_scaled_loft(part, kind.hand) if isinstance(part, Loft) else part
    if isinstance(part, Loft):
        if part is usual.NECK:
            return _evenly_scaled_loft(part, kind.neck)
        return _evenly_scaled_loft(part, kind.foot if part in (usual.FOOT, usual.TOES) else kind.shoulder)
    if part is usual.CHEST:
        x, y, z = part.centre
        deep = _at(kind.torso, 0.3)[1]
        return replace(_scaled(part, *kind.chest), centre=(x, y - kind.chest_drop, z * deep))
    if part is usual.SEAT:
        return _scaled(part, kind.seat)
    if part is usual.DELTOID:
        return _scaled(part, kind.shoulder)
    return _scaled_about(part, _HEAD_ROOT, kind.head) if part.centre[1] > _HEAD_ROOT[1] - 0.03 else part


def toes_of(name: str) -> tuple[Loft, ...]:
    """Return the toes of the left foot of the body of that name, each a closed surface of its own in the foot."""
    return tuple(_evenly_scaled_loft(toe, TYPES[name].foot) for toe in usual.TOE_PARTS)


def trunk_of(name: str, *, toes: bool = False, details: bool = True) -> tuple[Part, ...]:
    """Return the parts of a body without its head: its neck ends in a head of its own mesh."""
    return tuple(
        part
        for part in parts_of(name, toes=toes, details=details)
        if not isinstance(part, Ellipsoid) or part.centre[1] < _HEAD_ROOT[1] - 0.03
    )
