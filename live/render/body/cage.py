"""Coarse cage of the dancer's body: polygons that follow the skeleton, with skin weights at the corners.

Edge loops of six corners across every limb let joints bend softly, and every subdivision of the cage is closed.
The left half (x >= 0) is built and mirrored; corners at x = 0 are shared by both halves.
"""

from typing import Final

import numpy as np

from live.render.body.cage_builder import Cage, HalfBuilder, JointWeights, Point, mirrored
from live.render.body.hand_cage import add_hand
from live.render.body.implicit_surface import Loft

# Torso and neck from the hip crease up: y [m], half-width, front, back, weights at the middle and at the side.
_TRUNK: Final[tuple[tuple[float, float, float, float, JointWeights], ...]] = (
    (0.940, 0.140, 0.085, -0.100, {"hips": 0.92, "leftUpperLeg": 0.08}),
    (1.000, 0.118, 0.084, -0.078, {"hips": 0.60, "spine": 0.40}),
    (1.060, 0.104, 0.082, -0.065, {"hips": 0.18, "spine": 0.70, "chest": 0.12}),
    (1.125, 0.107, 0.085, -0.068, {"spine": 0.45, "chest": 0.51, "upperChest": 0.04}),
    (1.190, 0.116, 0.094, -0.076, {"spine": 0.12, "chest": 0.66, "upperChest": 0.22}),
    (1.250, 0.123, 0.102, -0.084, {"chest": 0.42, "upperChest": 0.58}),
    (1.310, 0.128, 0.088, -0.090, {"chest": 0.08, "upperChest": 0.84, "leftShoulder": 0.08}),
    (1.362, 0.126, 0.060, -0.086, {"upperChest": 0.68, "leftShoulder": 0.32}),
    (1.415, 0.105, 0.030, -0.072, {"upperChest": 0.55, "leftShoulder": 0.45}),
    (1.450, 0.046, 0.034, -0.064, {"upperChest": 0.42, "neck": 0.58}),
)
_ARMPIT_ROW: Final = 7
"""The arm grows from the side of the two bands above this row."""
_BREATHING: Final = {1.190: 0.45, 1.250: 0.80, 1.310: 0.80, 1.362: 0.45}
"""Share of the front of these rows that breath moves."""

# Head rows: the four corners (front middle, front, back, back middle).
_HEAD: Final[tuple[tuple[tuple[Point, Point, Point, Point], JointWeights], ...]] = (
    (
        ((0.0, 1.492, 0.074), (0.040, 1.508, 0.040), (0.044, 1.530, -0.050), (0.0, 1.530, -0.072)),
        {"neck": 0.45, "head": 0.55},
    ),
    (((0.0, 1.535, 0.090), (0.052, 1.550, 0.055), (0.064, 1.575, -0.058), (0.0, 1.570, -0.088)), {"head": 1.0}),
    (((0.0, 1.585, 0.100), (0.058, 1.600, 0.060), (0.070, 1.620, -0.052), (0.0, 1.620, -0.092)), {"head": 1.0}),
    (((0.0, 1.655, 0.080), (0.048, 1.662, 0.055), (0.052, 1.670, -0.052), (0.0, 1.672, -0.075)), {"head": 1.0}),
)

# Where a body without a head ends: rows as above.
_NECK_END: Final[tuple[tuple[tuple[Point, Point, Point, Point], JointWeights], ...]] = (
    (((0.0, 1.478, 0.030), (0.034, 1.478, 0.018), (0.034, 1.478, -0.044), (0.0, 1.478, -0.056)), {"neck": 1.0}),
)

# Arm rings along x: x, half-height, half-depth, weights; centre line at the height of the shoulder joint.
_ARM_LINE: Final = (1.380, -0.010)
_ARM: Final[tuple[tuple[float, float, float, JointWeights], ...]] = (
    (0.215, 0.046, 0.044, {"leftShoulder": 0.14, "leftArmRoll": 0.86}),
    (0.335, 0.037, 0.038, {"leftArmRoll": 0.35, "leftUpperArm": 0.65}),
    (0.388, 0.033, 0.034, {"leftUpperArm": 0.84, "leftLowerArm": 0.16}),
    (0.430, 0.031, 0.033, {"leftUpperArm": 0.50, "leftLowerArm": 0.50}),
    (0.475, 0.034, 0.037, {"leftUpperArm": 0.15, "leftLowerArm": 0.85}),
    (0.600, 0.026, 0.029, {"leftLowerArm": 0.40, "leftForearmRoll": 0.60}),
    (0.660, 0.019, 0.025, {"leftForearmRoll": 0.85, "leftHand": 0.15}),
)

_SHOULDER: Final = (0.168, 0.046, 0.044, {"upperChest": 0.15, "leftShoulder": 0.30, "leftArmRoll": 0.55})
"""A ring that subdivision makes of itself."""

# Leg rings down y: y, half-width, front, back, weights; centre line under the hip joint.
_LEG_X: Final = 0.090
_LEG: Final[tuple[tuple[float, float, float, float, JointWeights], ...]] = (
    (0.760, 0.070, 0.080, -0.082, {"hips": 0.08, "leftThighRoll": 0.92}),
    (0.630, 0.058, 0.070, -0.066, {"leftThighRoll": 0.35, "leftUpperLeg": 0.65}),
    (0.533, 0.049, 0.056, -0.053, {"leftUpperLeg": 0.86, "leftLowerLeg": 0.14}),
    (0.475, 0.046, 0.052, -0.049, {"leftUpperLeg": 0.50, "leftLowerLeg": 0.50}),
    (0.420, 0.046, 0.045, -0.056, {"leftUpperLeg": 0.14, "leftLowerLeg": 0.86}),
    (0.345, 0.047, 0.040, -0.064, {"leftLowerLeg": 1.0}),
    (0.200, 0.031, 0.033, -0.040, {"leftLowerLeg": 1.0}),
    (0.100, 0.027, 0.031, -0.036, {"leftLowerLeg": 0.45, "leftFoot": 0.55}),
)
_SOLE: Final = (0.004, 0.034, 0.048, -0.058)
"""The heel on the floor: y, half-width, front, back [m]."""
# Foot rings forward z: z, low y, high y, inner x, outer x, weights.
_FOOT: Final[tuple[tuple[float, float, float, float, float, JointWeights], ...]] = (
    (0.124, 0.002, 0.038, 0.052, 0.128, {"leftFoot": 0.50, "leftToes": 0.50}),
    (0.158, 0.003, 0.028, 0.056, 0.122, {"leftToes": 1.0}),
    (0.182, 0.004, 0.018, 0.066, 0.106, {"leftToes": 1.0}),
)
_COLUMNS: Final = np.radians([0.0, 34.0, 70.0, 110.0, 146.0, 180.0])
"""Directions of the corners of the trunk's rows, from the front to the back."""
_AROUND: Final = np.radians([-30.0, 30.0, 90.0, 150.0, 210.0, 270.0])
"""Directions of the corners of rings."""


def _row(y: float, width: float, front: float, back: float) -> list[Point]:
    centre, deep = 0.5 * (front + back), 0.5 * (front - back)
    points = [(width * float(np.sin(a)), y, centre + deep * float(np.cos(a))) for a in _COLUMNS]
    return [(0.0, *points[0][1:]), *points[1:-1], (0.0, *points[-1][1:])]


def _six(corners: tuple[Point, ...]) -> list[Point]:
    """Add a corner in the middle of the front and of the back."""
    a, b, c, d = corners
    front, back = (tuple(0.5 * (p + q) for p, q in zip(one, two, strict=True)) for one, two in ((a, b), (c, d)))
    return [a, (front[0], front[1], front[2] + 0.01), b, c, (back[0], back[1], back[2] - 0.01), d]


def _trunk(half: HalfBuilder, *, head: bool) -> list[list[int]]:
    crease: list[Point] = [
        (0.0, 0.812, 0.034), (0.078, 0.838, 0.072), (0.152, 0.868, 0.045),
        (0.150, 0.850, -0.060), (0.085, 0.802, -0.100), (0.0, 0.808, -0.050),
    ]  # fmt: skip
    middle, side = {"hips": 1.0}, {"hips": 0.50, "leftThighRoll": 0.50}
    seat = {"hips": 0.42, "leftThighRoll": 0.58}
    rows = [half.ring(crease, [middle, side, side, seat, seat, middle])]
    for y, width, front, back, bond in _TRUNK:
        inner = {name: weight for name, weight in bond.items() if not name.startswith("left")}
        breath = _BREATHING.get(y, 0.0)
        bonds = [
            _breathing(one, breath * part) for one, part in zip((inner, inner, bond), (1.0, 1.0, 0.6), strict=True)
        ]
        rows.append(half.ring(_row(y, width, front, back), [*bonds, bond, inner, inner]))
    for corners_, bond in _HEAD if head else _NECK_END:
        rows.append(half.ring(_six(corners_), bond))
    for index in range(len(rows) - 1):
        socket = (2,) if index in (_ARMPIT_ROW, _ARMPIT_ROW + 1) else ()
        half.bridge(rows[index], rows[index + 1], socket, open_=True)
    half.cap(rows[-1])
    return rows


def _breathing(bond: JointWeights, share: float) -> JointWeights:
    moved = {name: weight * (1.0 - share) for name, weight in bond.items() if name in ("chest", "upperChest")}
    return {**bond, **moved, "breath": sum(bond[name] for name in moved) * share} if share else bond


def _arm(half: HalfBuilder, low: list[int], middle: list[int], high: list[int], *, round_: bool) -> list[int]:
    """Add the arm as far as the wrist, with a ring for round shoulders if need be; return its last ring, from the top
    to the front."""
    y, z = _ARM_LINE
    previous = [high[3], high[2], middle[2], low[2], low[3], middle[3]]
    for x, tall, deep, bond in (_SHOULDER, *_ARM) if round_ else _ARM:
        turned = _AROUND + np.radians(30.0) * min(max((x - 0.43) / 0.22, 0.0), 1.0)  # a corner on top of the hand
        ring = half.ring(
            [(x, y + tall * float(np.cos(a)) * 1.1, z + deep * float(np.sin(a)) * 1.1) for a in turned], bond
        )
        half.bridge(previous, ring)
        previous = ring
    return previous


def _leg(half: HalfBuilder, crease: list[int]) -> None:
    previous = [crease[0], *crease[:0:-1]]
    for y, width, front, back, bond in _LEG:
        ring = half.ring(_leg_ring(y, width, front, back), bond)
        half.bridge(previous, ring)
        previous = ring
    heel = half.ring(_leg_ring(*_SOLE), {"leftFoot": 1.0})
    half.bridge(previous, heel, (4, 5))
    half.cap(heel)
    across = [heel[4], previous[4], previous[5], previous[0], heel[0], heel[5]]
    for z, low, high, inner, outer, bond in _FOOT:
        middle = 0.5 * (inner + outer)
        corners = [
            (outer, low, z), (outer, high * 0.85, z), (middle, high, z),
            (inner, high * 0.95, z), (inner, low, z), (middle, low, z + 0.004),
        ]  # fmt: skip
        ring = half.ring(corners, bond)
        half.bridge(across, ring)
        across = ring
    half.cap(across)


def _leg_ring(y: float, width: float, front: float, back: float) -> list[Point]:
    """Six corners around a leg: inside, behind, outside, in front."""
    centre, deep = 0.5 * (front + back), 0.5 * (front - back)
    angles = np.radians([30.0, -30.0, -90.0, -150.0, 150.0, 90.0])
    return [(_LEG_X - width * float(np.cos(a)), y, centre + deep * float(np.sin(a))) for a in angles]


def build_cage(*, fingers: bool = True, tips: bool = True, head: bool = True) -> Cage:
    """Return the cage of the body in the rest pose; without `fingers` they are one mitten, without `tips` they end
    bluntly; without a `head` its neck ends inside one."""
    half = HalfBuilder()
    rows = _trunk(half, head=head)
    _leg(half, rows[0])
    low, middle, high = rows[_ARMPIT_ROW : _ARMPIT_ROW + 3]
    wrist = _arm(half, low, middle, high, round_=not fingers)
    add_hand(half, wrist, fingers=fingers, tips=tips)
    return mirrored(half)


def build_toe_cage(toe: Loft) -> Cage:
    """Return the cage of a toe and of its opposite: a box along its bone."""
    half = HalfBuilder()
    start, end = np.array(toe.start), np.array(toe.end)
    previous: list[int] = []
    for t in (-0.05, 0.5, 1.1):
        x, y, z = (start + (end - start) * t).tolist()
        wide = 1.1 * float(np.interp(t, [row[0] for row in toe.rows], [row[1] for row in toe.rows]))
        tall = 0.011
        corners = [(x + wide, y - tall, z), (x + wide, y + tall, z), (x - wide, y + tall, z), (x - wide, y - tall, z)]
        ring = half.ring(corners, {"leftToes": 1.0})
        if previous:
            half.bridge(previous, ring)
        else:
            half.cap(ring[::-1])
        previous = ring
    half.cap(previous)
    return mirrored(half)
