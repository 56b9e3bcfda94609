"""Cage of the left hand: a palm with a socket for each finger, or one mitten for bodies that are drawn small."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.render.body.cage_builder import Cage, HalfBuilder, JointWeights, Point, mirrored
from live.render.body.fingers import FINGERS, PHALANGES, Finger

# Palm rings along x: x, half-thickness, to the front, to the back, shift up, weights.
_Y: Final = 1.379
_WRIST_END: Final = (0.702, 0.0150, 0.026, -0.042, {"leftHand": 1.0})
_KNUCKLES: Final = (0.750, 0.0130, 0.032, -0.047)
_WEB: Final = 0.786
"""Where the fingers part."""
_ROUND: Final = np.radians([0.0, 60.0, 120.0, 180.0, 240.0, 300.0])


def _name(finger: Finger, phalanx: int) -> str:
    return f"left{finger.name}{PHALANGES[phalanx]}"


def add_hand(half: HalfBuilder, wrist: list[int], *, fingers: bool, tips: bool) -> None:
    """Add the hand to a ring of six corners around the wrist, the first on top, the next in front of it; `tips`: round
    finger tips."""
    x, thick, front, back, bond = _WRIST_END
    thumb = {"leftHand": 0.65, "leftThumbProximal": 0.35}
    near = half.ring(_hexagon(x, thick, front, back), [bond, thumb, thumb, bond, bond, bond])
    half.bridge(wrist, near)
    if fingers:
        socket = _fingers(half, near, tips)
    else:
        socket = _mitten(half, near)
    _limb(half, socket, FINGERS[0], tips and fingers)


def _hexagon(x: float, thick: float, front: float, back: float) -> list[Point]:
    centre, wide = 0.5 * (front + back), 0.5 * (front - back)
    return [(x, _Y + thick * float(np.cos(a)), centre + wide * float(np.sin(a)) * 1.1) for a in _ROUND]


def _mitten(half: HalfBuilder, near: list[int]) -> list[int]:
    middle = FINGERS[2]
    x, thick, front, back = _KNUCKLES
    far = half.ring(_hexagon(x, thick, front, back), {"leftHand": 1.0})
    half.bridge(near, far, (1,))
    previous = far
    rows: tuple[tuple[float, float, float, float, JointWeights], ...] = (
        (_WEB, 0.009, 0.036, -0.046, {_name(middle, 0): 1.0}),
        (middle.places[1][0], 0.008, 0.037, -0.047, {_name(middle, 0): 0.5, _name(middle, 1): 0.5}),
        (0.848, 0.005, 0.024, -0.026, {_name(middle, 1): 0.3, _name(middle, 2): 0.7}),
    )
    for x, thick, front, back, bond in rows:
        ring = half.ring(_hexagon(x, thick, front, back), bond)
        half.bridge(previous, ring)
        previous = ring
    half.cap(previous)
    return [far[1], near[1], near[2], far[2]]


def _fingers(half: HalfBuilder, near: list[int], tips: bool) -> list[int]:
    """Add the palm and four fingers; return the socket of the thumb."""
    thick, front, back = _KNUCKLES[1:]
    edges = [front, *(0.5 * (one.places[0][2] + two.places[0][2]) for one, two in _pairs()), back]
    far_x = [0.750, 0.752, 0.752, 0.750, 0.744]
    bonds: list[JointWeights] = [{"leftHand": 0.85, "leftThumbProximal": 0.15}, *({"leftHand": 1.0} for _ in range(4))]
    bulge = [0.7, 1.0, 1.1, 1.0, 0.7]
    rings = []
    for side in (1.0, -1.0):
        points = [(x, _Y + side * thick * b, z) for x, b, z in zip(far_x, bulge, edges, strict=True)]
        rings.append(half.ring(points, bonds))
    top, low = rings
    half.faces += [
        (near[0], near[1], top[0], top[1], top[2]),
        (near[2], near[3], low[2], low[1], low[0]),
        (near[3], near[4], low[4], low[3], low[2]),
        (near[4], near[5], top[4], low[4]),
        (near[5], near[0], top[2], top[3], top[4]),
    ]
    web_top, web_low = _web(half, 1.0), _web(half, -1.0)
    before = [*top[::-1], *low]
    after = [*web_top[::-1], *web_low]
    half.bridge(before, after)
    for number, finger in enumerate(FINGERS[1:]):
        here = slice(number, number + 2)
        a, b = web_top[here]
        c, d = web_low[here]
        _limb(half, [b, a, c, d], finger, tips)
    return [top[0], near[1], near[2], low[0]]


def _pairs() -> Iterator[tuple[Finger, Finger]]:
    return pairwise(FINGERS[1:])


def _web(half: HalfBuilder, side: float) -> list[int]:
    """Add the corners between the fingers on top (1) or below (-1), the index's side first."""
    four = FINGERS[1:]
    at = [np.array(one.places[0]) + one.direction(0) * 0.020 for one in four]
    across = [_across(one, 0) for one in four]
    places = [at[0] - across[0] * four[0].wide]
    places += [0.5 * (p + q) for p, q in pairwise(at)]
    places.append(at[-1] + across[-1] * four[-1].wide)
    bonds: list[JointWeights] = [{_name(four[0], 0): 1.0}]
    bonds += [{_name(one, 0): 0.5, _name(two, 0): 0.5} for one, two in _pairs()]
    bonds.append({_name(four[-1], 0): 1.0})
    lift = np.array([0.0, side * 0.0085, 0.0])
    return half.ring([_point(place + lift) for place in places], bonds)


def _point(place: Float64) -> Point:
    return float(place[0]), float(place[1]), float(place[2])


def _across(finger: Finger, phalanx: int) -> Float64:
    """Return the unit direction across a finger, away from the thumb."""
    across = np.cross(finger.direction(phalanx), [0.0, 1.0, 0.0])
    return np.asarray(-across / np.linalg.norm(across))


_NAIL: Final = np.radians([-54.0, -18.0, 18.0, 54.0])
"""Directions of the corners across a nail, from the top of the finger."""


def build_nail_cage(finger: Finger) -> Cage:
    """Return a finger's nail and the opposite one: a curved plate on the tip."""
    half = HalfBuilder()
    along, across = finger.direction(2), _across(finger, 2)
    up = np.cross(along, across)
    previous: list[int] = []
    for back, size in ((0.0125, 0.955), (0.0065, 0.955), (0.0020, 0.78)):
        centre = np.array(finger.places[3]) - along * back
        upper, lower = (
            [
                centre + (across * np.sin(a) * finger.wide + up * np.cos(a) * finger.thick) * (size - deep)
                for a in _NAIL[::order]
            ]
            for deep, order in ((0.0, -1), (0.25, 1))
        )
        ring = half.ring([_point(place) for place in (*upper, *lower)], {_name(finger, 2): 1.0})
        if previous:
            half.bridge(previous, ring)
        else:
            half.cap(ring[::-1])
        previous = ring
    half.cap(previous)
    return mirrored(half)


def _limb(half: HalfBuilder, socket: list[int], finger: Finger, tips: bool) -> None:
    """Add a finger to its socket: four corners, two on the side away from the thumb first, the upper one before."""
    previous = socket
    rows: tuple[tuple[int, float, float, JointWeights], ...] = (
        (1, 0.0, 1.0, {_name(finger, 0): 0.5, _name(finger, 1): 0.5}),
        (2, 0.0, 0.94, {_name(finger, 1): 0.5, _name(finger, 2): 0.5}),
        (3, 0.008, 0.90, {_name(finger, 2): 1.0}),
        (3, 0.000, 0.55, {_name(finger, 2): 1.0}),
    )
    blunt: tuple[int, float, float, JointWeights] = (3, 0.003, 0.75, {_name(finger, 2): 1.0})
    for joint, before, size, bond in rows if tips else (*rows[:2], blunt):
        phalanx = min(joint, 2)
        centre = np.array(finger.places[joint]) - finger.direction(2) * before
        across, along = _across(finger, phalanx), finger.direction(phalanx)
        up = np.cross(along, across)
        wide, thick = across * finger.wide * size, up * finger.thick * size
        ring = half.ring([_point(centre + p) for p in (wide + thick, thick - wide, -wide - thick, wide - thick)], bond)
        half.bridge(previous, ring)
        previous = ring
    half.cap(previous)
