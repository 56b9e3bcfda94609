"""Body types: variants of the dancer's body with other widths and muscles on the same skeleton.

A type multiplies the half-widths of the usual body's parts at positions along them, and may add parts. The joints do
not move, so contacts of feet and hands hold for all types.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np

from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.render.body import implicit_surface as usual
from live.render.body.implicit_surface import BODY, Ellipsoid, Loft

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
    seat: float = 1.0
    extra_parts: tuple[Ellipsoid, ...] = ()
    """Parts added to the torso."""


TYPES: Final[dict[str, BodyType]] = {
    DEFAULT_BODY: BodyType(),
    "slim": BodyType(
        torso=((0.0, 0.97, 0.95, 0.95), (0.35, 0.90, 0.90, 0.90), (0.6, 0.90, 0.90, 0.90), (1.0, 0.90, 0.92, 0.88)),
        leg=((0.0, 0.90, 0.90, 0.90), (0.35, 0.83, 0.84, 0.84), (0.65, 0.87, 0.90, 0.84), (1.0, 0.92, 0.95, 0.95)),
        arm=((0.0, 0.88, 0.88, 0.88), (0.5, 0.82, 0.82, 0.82), (1.0, 0.92, 0.92, 0.92)),
        neck=0.92, head=0.97, hand=0.96, foot=0.96, shoulder=0.90, chest=(0.88, 0.90, 0.80), seat=0.88,
    ),
    "strong": BodyType(
        torso=(
            (0.0, 1.10, 1.15, 1.10), (0.14, 1.17, 1.12, 1.15), (0.3, 1.18, 1.08, 1.12), (0.45, 1.16, 1.05, 1.08),
            (0.6, 1.16, 1.05, 1.06), (0.8, 1.03, 1.04, 0.98), (1.0, 1.0, 1.0, 0.95),
        ),
        leg=((0.0, 1.02, 1.05, 1.02), (0.3, 1.13, 1.13, 1.10), (0.5, 1.10, 1.10, 1.08), (0.65, 1.16, 1.10, 1.16),
             (1.0, 1.08, 1.08, 1.08)),
        arm=((0.0, 1.20, 1.20, 1.20), (0.25, 1.34, 1.36, 1.34), (0.5, 1.18, 1.18, 1.18), (0.64, 1.28, 1.28, 1.25),
             (1.0, 1.15, 1.12, 1.12)),
        neck=1.20, head=1.02, hand=1.10, foot=1.06, shoulder=1.24, chest=(1.28, 1.0, 0.82), seat=0.92,
        extra_parts=(
            Ellipsoid((0.092, 1.205, -0.045), (0.058, 0.095, 0.048), 0.045),  # the broad back
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
        neck=1.16, head=1.05, hand=1.05, foot=1.04, shoulder=1.10, chest=(1.16, 1.12, 1.16), seat=1.18,
        extra_parts=(Ellipsoid((0.0, 1.020, 0.060), (0.120, 0.110, 0.085), 0.070),),  # the belly
    ),
    "child": BodyType(
        torso=(
            (0.0, 0.86, 0.90, 0.88), (0.2, 0.82, 0.86, 0.84), (0.45, 0.90, 0.92, 0.90), (0.62, 1.00, 1.04, 0.96),
            (0.85, 0.86, 0.96, 0.84), (1.0, 0.88, 0.92, 0.86),
        ),
        leg=((0.0, 0.88, 0.90, 0.88), (0.35, 0.84, 0.84, 0.84), (0.5, 0.98, 0.98, 0.98), (0.65, 0.86, 0.92, 0.78),
             (1.0, 1.0, 1.0, 1.0)),
        arm=((0.0, 0.86, 0.86, 0.86), (0.5, 0.92, 0.90, 0.90), (1.0, 0.98, 0.98, 0.98)),
        neck=0.86, head=1.18, hand=0.90, foot=0.90, shoulder=0.84, chest=(0.75, 0.80, 0.55), seat=0.80,
    ),
}  # fmt: skip
"""The type for each name of `live.base.body.catalogue`."""


def _scaled_loft(loft: Loft, curve: _Curve) -> Loft:
    factors = np.array(curve)
    rows = tuple(
        (
            t,
            across * float(np.interp(t, factors[:, 0], factors[:, 1])),
            front * float(np.interp(t, factors[:, 0], factors[:, 2])),
            back * float(np.interp(t, factors[:, 0], factors[:, 3])),
            shift,
        )
        for t, across, front, back, shift in loft.rows
    )
    return replace(loft, rows=rows)


def _evenly_scaled_loft(loft: Loft, factor: float) -> Loft:
    return _scaled_loft(loft, ((0.0, factor, factor, factor),))


def _scaled(part: Ellipsoid, *factors: float) -> Ellipsoid:
    three = factors if len(factors) == 3 else factors * 3
    return replace(part, radii=(part.radii[0] * three[0], part.radii[1] * three[1], part.radii[2] * three[2]))


def _scaled_about(part: Ellipsoid, centre: tuple[float, float, float], factor: float) -> Ellipsoid:
    """Scale a part about `centre`."""
    x, y, z = (c + (p - c) * factor for p, c in zip(part.centre, centre, strict=True))
    return replace(_scaled(part, factor), centre=(x, y, z))


_HEAD_ROOT: Final = (0.0, 1.530, 0.0)
"""Centre for scaling the head: where the neck enters it."""


@cache
def parts_of(name: str) -> tuple[Loft | Ellipsoid, ...]:
    """Return the parts of the left half of a body, in blending order; ValueError for an unknown name."""
    if name not in TYPES:
        raise ValueError(f"body {name!r}: there are {', '.join(BODIES)}")
    kind = TYPES[name]
    if name == DEFAULT_BODY:
        return BODY
    parts: list[Loft | Ellipsoid] = []
    for part in BODY:
        match part:
            case usual.TORSO:
                parts += [_scaled_loft(part, kind.torso), *kind.extra_parts]
            case usual.LEG:
                parts.append(_scaled_loft(part, kind.leg))
            case usual.ARM:
                parts.append(_scaled_loft(part, kind.arm))
            case _:
                parts.append(_scaled_small_part(part, kind))
    return tuple(parts)


def _scaled_small_part(part: Loft | Ellipsoid, kind: BodyType) -> Loft | Ellipsoid:
    if isinstance(part, Loft):
        if part is usual.NECK:
            return _evenly_scaled_loft(part, kind.neck)
        if part in (usual.FOOT, usual.TOES):
            return _evenly_scaled_loft(part, kind.foot)
        return _evenly_scaled_loft(
            part, kind.hand if part in (usual.PALM, usual.FINGERS, usual.THUMB) else kind.shoulder
        )
    if part is usual.CHEST:
        return _scaled(part, *kind.chest)
    if part is usual.SEAT:
        return _scaled(part, kind.seat)
    if part is usual.DELTOID:
        return _scaled(part, kind.shoulder)
    if part is usual.HEEL:
        return part
    return _scaled_about(part, _HEAD_ROOT, kind.head) if part.centre[1] > _HEAD_ROOT[1] - 0.03 else part


def bun_of(name: str) -> tuple[Loft | Ellipsoid, ...]:
    """Return the hair bun of the body of that name."""
    factor = TYPES[name].head
    return tuple(_scaled_about(part, _HEAD_ROOT, factor) if isinstance(part, Ellipsoid) else part for part in usual.BUN)
