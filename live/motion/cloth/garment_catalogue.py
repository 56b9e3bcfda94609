"""The garments that can move by themselves: skirts, sleeves, ribbons, long hair and ponytails, cut for any body."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.motion.cloth.body_sections import LIMBS, half_widths, limb_index
from live.motion.cloth.pattern import UPRIGHT, Contact, Pattern
from live.motion.skeleton import SKELETON

_REST: Final = SKELETON.rest_positions()
_ARMS: Final = ("left forearm", "right forearm", "left hand", "right hand")


def _pair(limb: str, first: int, last: int, *, middles: bool = False, often: bool = True) -> tuple[Contact, Contact]:
    return (
        Contact(f"left {limb}", first, last, middles, often),
        Contact(f"right {limb}", first, last, middles, often),
    )


def _grid(value: float, rows: int, columns: int) -> tuple[tuple[float, ...], ...]:
    return ((value,) * columns,) * rows


# -- skirts ----------------------------------------------------------------------------------------------------------

_WAIST_HEIGHT: Final = 1.005
"""Height of a skirt's waistband in the rest pose [m]."""
_GATHERED: Final = 0.94
"""Length of cloth that is gathered at the waistband [m]; no body is wider there."""
_HIPS_BELOW: Final = 0.12
"""So far below the waistband [m] the hips are widest."""
_FOLD: Final = 4
"""Columns in a fold."""
_FOLLOWS: Final = 0.6
"""Share of the wearer's falls beyond gravity that skirts follow, and hair: both still lift a little."""


def _ellipse(widths: tuple[float, float, float], clear: float, angle: Float64, fold: Float64 | float = 0.0) -> Float64:
    """Return (x, z) [m] around the body at `angle` (N,), 0 in front; further out by `clear` and `fold` (N,)."""
    side, front, back = widths
    depth = np.where(np.cos(angle) > 0.0, front, back)
    return np.stack([(side + clear + fold) * np.sin(angle), (depth + clear + fold) * np.cos(angle)], axis=1)


def _perimeter(points: Float64) -> float:
    return float(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())


def _skirt_shape(rows: int, columns: int, length: float, widths: Sequence[float], sections: Float32) -> Float64:
    """A skirt as it hangs: over the hips, then in folds that take up the width of the cloth.

    The limbs are a little wider than the body, so that they hold all of it; the waistband lies on the skin.
    """
    pelvis = LIMBS[limb_index("pelvis")]
    section = sections[limb_index("pelvis")]
    bottom, top = pelvis.start[1], pelvis.end[1]
    waist = half_widths(section, (_WAIST_HEIGHT - bottom) / (top - bottom))
    hips = half_widths(section, 0.1)
    angle = 2.0 * np.pi * np.arange(columns) / columns
    wave = np.cos(2.0 * np.pi * np.arange(columns) / _FOLD)
    points = np.empty((rows, columns, 3))
    spacing, height = length / (rows - 1), _WAIST_HEIGHT
    for row in range(rows):
        below = row * spacing
        share = min(below / _HIPS_BELOW, 1.0)
        over = [w + share * max(h - w, 0.0) for w, h in zip(waist, hips, strict=True)]
        clear = (0.009 if row else -0.004) + 0.012 * share + 0.16 * max(below - _HIPS_BELOW, 0.0)
        low, high = 0.0, 0.2
        for _ in range(30):
            fold = 0.5 * (low + high)
            wide = _perimeter(_ellipse((over[0], over[1], over[2]), clear + fold, angle, fold * wave))
            low, high = (fold, high) if wide < columns * widths[row] else (low, fold)
        fold = min(low, 0.3 * below)
        points[row, :, [0, 2]] = _ellipse((over[0], over[1], over[2]), clear + fold, angle, fold * wave).T
        if row:  # it falls by what it does not need to go outwards
            out = float(np.square(points[row, :, [0, 2]] - points[row - 1, :, [0, 2]]).sum(axis=0).mean())
            height -= math.sqrt(max(spacing**2 - out, (0.4 * spacing) ** 2))
        points[row, :, 1] = height
    return points


def _skirt(name: str, length: float, rows: int, columns: int, flare: float) -> Pattern:
    """Return a skirt `length` [m] long that spreads by `flare` (the sine of its cone's angle)."""
    below = np.linspace(0.0, length, rows)
    widths = tuple((_GATHERED + 2.0 * np.pi * flare * below) / columns)
    side = np.sin(2.0 * np.pi * np.arange(columns) / columns)
    down = np.clip((below - 0.05) / 0.45, 0.0, 1.0)[:, None]
    share = 0.55 * down * np.abs(side) ** 0.7
    second = np.where(side > 0.0, 1, 2)
    near_hips = int(np.searchsorted(below, 0.26))
    knees = int(np.searchsorted(below, 0.20))
    contacts = [
        Contact("pelvis", 1, near_hips),
        Contact("waist", 1, near_hips, False, False),
        *_pair("thigh", 1, rows, middles=True),
    ]
    contacts.append(Contact("between thighs", 1, rows))
    if length > 0.4:
        contacts += _pair("shin", knees, rows, middles=True)
        contacts.append(Contact("between shins", knees, rows))
    if length > 0.7:
        contacts += _pair("foot", rows - 4, rows, often=False)
    contacts.append(Contact("chest", 2, near_hips, False, False))
    contacts += [Contact(limb, 1, int(np.searchsorted(below, 0.45)), often=limb.endswith("hand")) for limb in _ARMS]
    return Pattern(
        name=name, kind="cloth", rows=rows, columns=columns, closed=True, pinned_rows=1, length=length, widths=widths,
        joints=("hips", "leftUpperLeg", "rightUpperLeg"),
        rest_shape=partial(_skirt_shape, rows, columns, length, widths),
        share=tuple(map(tuple, share.tolist())), second=(tuple(second.tolist()),) * rows, contacts=tuple(contacts),
        follows=_FOLLOWS,
    )  # fmt: skip


# -- hair ------------------------------------------------------------------------------------------------------------

_HAIR_ROWS, _HAIR_COLUMNS, _HAIR_LENGTH = 9, 12, 0.50
_HAIR_ROUND: Final = math.radians(118.0)
"""Long hair begins so far to both sides of the back of the head."""


def _hair_shape(sections: Float32) -> Float64:
    head, section = LIMBS[limb_index("head")], sections[limb_index("head")]
    bottom, top = head.start[1], head.end[1]
    angle = np.pi + np.linspace(-_HAIR_ROUND, _HAIR_ROUND, _HAIR_COLUMNS)
    points = np.empty((_HAIR_ROWS, _HAIR_COLUMNS, 3))
    for row in range(_HAIR_ROWS):
        height = 1.648 - row * _HAIR_LENGTH / (_HAIR_ROWS - 1)
        place = min(max((max(height, 1.575) - bottom) / (top - bottom), 0.0), 1.0)
        clear = (0.002, 0.010)[row] if row < 2 else 0.013 + 0.006 * (row - 1)
        points[row, :, [0, 2]] = _ellipse(half_widths(section, place), clear, angle).T
        points[row, :, 1] = height
    return points


def _long_hair() -> Pattern:
    rows, columns = _HAIR_ROWS, _HAIR_COLUMNS
    contacts = (
        Contact("shoulders", 2, rows), Contact("chest", 4, rows), Contact("waist", 6, rows, False, False),
        Contact("neck", 2, 6), Contact("head", 2, rows), *_pair("upper arm", 3, rows, often=False),
        *_pair("forearm", 4, rows, often=False),
    )  # fmt: skip
    return Pattern(
        name="long hair", kind="hair", rows=rows, columns=columns, closed=False, pinned_rows=2, length=_HAIR_LENGTH,
        widths=tuple(np.interp(np.arange(rows), [0, 2, rows - 1], [0.034, 0.038, 0.034])), joints=("head",),
        rest_shape=_hair_shape, share=_grid(0.0, rows, columns), second=((0,) * columns,) * rows, contacts=contacts,
        sheared=False, strands=True, follows=_FOLLOWS,
    )  # fmt: skip


_TAIL_ROWS, _TAIL_COLUMNS, _TAIL_LENGTH = 10, 6, 0.42
_TAIL_RADII: Final = (0.014, 0.024, 0.031, 0.034, 0.034, 0.032, 0.029, 0.024, 0.017, 0.007)
_TAIL_ROOT: Final = (1.628, 0.012)
"""Height of the root of a ponytail, and its distance from the head [m]."""


def _tail_shape(sections: Float32) -> Float64:
    back = half_widths(sections[limb_index("head")], 0.9)[2]
    spacing = _TAIL_LENGTH / (_TAIL_ROWS - 1)
    centre = np.array([0.0, _TAIL_ROOT[0], -back - _TAIL_ROOT[1]])
    points = np.empty((_TAIL_ROWS, _TAIL_COLUMNS, 3))
    around = 2.0 * np.pi * np.arange(_TAIL_COLUMNS) / _TAIL_COLUMNS
    for row in range(_TAIL_ROWS):
        fall = math.radians(min(-25.0 + 38.0 * row, 82.0))  # backwards and a little up, then down
        way = np.array([0.0, -math.sin(fall), -math.cos(fall)])
        across = np.cross(way, (1.0, 0.0, 0.0))
        ring = np.cos(around)[:, None] * np.array([1.0, 0.0, 0.0]) + np.sin(around)[:, None] * across
        points[row] = centre + _TAIL_RADII[row] * ring
        centre = centre + spacing * way
    return points


def _ponytail() -> Pattern:
    rows, columns = _TAIL_ROWS, _TAIL_COLUMNS
    contacts = (
        Contact("shoulders", 2, rows), Contact("chest", 4, rows), Contact("neck", 2, rows), Contact("head", 2, rows),
        *_pair("upper arm", 2, rows, often=False), *_pair("forearm", 2, rows, often=False),
        *_pair("hand", 2, rows, often=False),
    )  # fmt: skip
    return Pattern(
        name="ponytail", kind="hair", rows=rows, columns=columns, closed=True, pinned_rows=2, length=_TAIL_LENGTH,
        widths=tuple(2.0 * math.sin(math.pi / columns) * radius for radius in _TAIL_RADII), joints=("head",),
        rest_shape=_tail_shape, share=_grid(0.0, rows, columns), second=((0,) * columns,) * rows, contacts=contacts,
        tubular=True, follows=_FOLLOWS,
    )  # fmt: skip


# -- arms ------------------------------------------------------------------------------------------------------------

_SLEEVE_ROWS, _SLEEVE_COLUMNS, _SLEEVE_LENGTH = 8, 12, 0.34
_SLEEVE_RADII: Final = (0.056, 0.150)
"""Radius of a wide sleeve at the elbow, and at its hem [m]."""


_SLEEVE_BELOW: Final = (0.02, 0.10)
"""The seam is so far below the elbow [m] outside, and inside, where the arm bends: no cloth is caught there."""


def _sleeve_shape(side: int, sections: Float32) -> Float64:
    around = 2.0 * np.pi * np.arange(_SLEEVE_COLUMNS) / _SLEEVE_COLUMNS
    seam = 0.430 + _SLEEVE_BELOW[0] + (_SLEEVE_BELOW[1] - _SLEEVE_BELOW[0]) * (0.5 + 0.5 * side * np.sin(around))
    thick = max(half_widths(sections[limb_index("left forearm")], 0.05)) + 0.014
    points = np.empty((_SLEEVE_ROWS, _SLEEVE_COLUMNS, 3))
    for row in range(_SLEEVE_ROWS):
        share = row / (_SLEEVE_ROWS - 1)
        radius = max(thick, _SLEEVE_RADII[0]) + share * (_SLEEVE_RADII[1] - _SLEEVE_RADII[0]) * 0.6
        points[row, :, 0] = side * (seam + share * 0.94 * _SLEEVE_LENGTH)
        points[row, :, 1] = 1.38 + radius * np.cos(around)
        points[row, :, 2] = -0.01 + side * radius * np.sin(around)
    return points


def _sleeve(side: str) -> Pattern:
    rows, columns = _SLEEVE_ROWS, _SLEEVE_COLUMNS
    widths = tuple(np.linspace(*_SLEEVE_RADII, rows) * 2.0 * np.sin(np.pi / columns))
    other = "right" if side == "left" else "left"
    contacts = (
        Contact(f"{side} forearm", 1, rows, True), Contact(f"{side} hand", 3, rows, True),
        Contact(f"{side} upper arm", 1, rows), Contact("chest", 1, rows), Contact("waist", 1, rows),
        *_pair("thigh", 1, rows), Contact("pelvis", 1, rows, False, False),
        Contact("shoulders", 1, rows, False, False), Contact("head", 3, rows, False, False),
        Contact(f"{other} forearm", 2, rows, False, False), Contact(f"{other} hand", 2, rows, False, False),
    )  # fmt: skip
    return Pattern(
        name=f"{side} sleeve", kind="cloth", rows=rows, columns=columns, closed=True, pinned_rows=1,
        length=_SLEEVE_LENGTH, widths=widths, joints=(f"{side}LowerArm",),
        rest_shape=partial(_sleeve_shape, 1 if side == "left" else -1),
        share=_grid(0.0, rows, columns), second=((0,) * columns,) * rows, contacts=contacts,
        around=(f"{side} forearm", 5),
    )  # fmt: skip


_RIBBON_ROWS, _RIBBON_LENGTH, _RIBBON_WIDTH = 28, 1.9, 0.06


def _ribbon_shape(side: int, sections: Float32) -> Float64:
    points = np.empty((_RIBBON_ROWS, 2, 3))
    points[:, :, 0] = side * 0.785
    points[:, :, 1] = (1.362 - np.arange(_RIBBON_ROWS) * _RIBBON_LENGTH / (_RIBBON_ROWS - 1))[:, None]
    points[:, :, 2] = -0.008 + np.array([-0.5, 0.5]) * _RIBBON_WIDTH
    return points


def _ribbon(side: str) -> Pattern:
    rows = _RIBBON_ROWS
    limbs = ("pelvis", "waist", "chest", "shoulders", "head", "left thigh", "right thigh", "left shin", "right shin",
             "left foot", "right foot", f"{side} forearm", f"{side} hand")  # fmt: skip
    return Pattern(
        name=f"{side} ribbon", kind="ribbon", rows=rows, columns=2, closed=False, pinned_rows=1, length=_RIBBON_LENGTH,
        widths=(_RIBBON_WIDTH,) * rows, joints=(f"{side}Hand", UPRIGHT),
        rest_shape=partial(_ribbon_shape, 1 if side == "left" else -1),
        share=((0.0, 0.0), *_grid(1.0, rows - 1, 2)), second=((0, 0), *((1, 1),) * (rows - 1)),
        contacts=tuple(Contact(limb, 3, rows, False, False) for limb in limbs),
    )  # fmt: skip


PATTERNS: Final[dict[str, Pattern]] = {
    pattern.name: pattern
    for pattern in (
        _skirt("short skirt", 0.36, 7, 20, 0.62),
        _skirt("skirt", 0.56, 9, 20, 0.52),
        _skirt("long skirt", 0.84, 12, 20, 0.42),
        _sleeve("left"),
        _sleeve("right"),
        _ribbon("left"),
        _ribbon("right"),
        _long_hair(),
        _ponytail(),
    )
}
"""All patterns by name."""
PATTERN_NAMES: Final = tuple(PATTERNS)
SKIRT_LENGTHS: Final = ((0.3, "short skirt"), (0.65, "skirt"), (1.0, "long skirt"))
"""The skirt for each length, 0 from the hips to 1 at the floor: the first one whose number is not below it."""
_SLEEVES: Final = ("left sleeve", "right sleeve")
_RIBBONS: Final = ("left ribbon", "right ribbon")
MOVING_HAIR: Final = {"long": ("long hair",), "ponytail": ("ponytail",)}
"""The garment that hangs from each hair style that moves by itself."""
_OF_EXTRA: Final = {"sleeves": _SLEEVES, "ribbons": _RIBBONS, "sleeves and ribbons": (*_SLEEVES, *_RIBBONS)}


def garments_of(costume: str, hair: str, extra: str, *, skirt: float = 0.5) -> tuple[str, ...]:
    """Return the patterns of what moves by itself on a dancer with this costume, hair style and extra, by the names of
    `live.base.body.appearance`. `skirt`: length of a skirt or dress, 0 to 1."""
    worn = [next(name for most, name in SKIRT_LENGTHS if skirt <= most)] if costume in ("skirt", "dress") else []
    return (*worn, *MOVING_HAIR.get(hair, ()), *_OF_EXTRA.get(extra, ()))
