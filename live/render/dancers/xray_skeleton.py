"""Bones of the x-ray style: lines between points attached to joints, in the rest pose."""

import itertools
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float32
from live.motion.skeleton import SKELETON

Point = tuple[float, float, float]
_Line = tuple[list[Point], list[str], float, float]
"""Points [m], the joint of each, radius [m], brightness."""

# between joints: from, to, radius [m]
_LONG_BONES: Final = (
    ("UpperArm", "LowerArm", 0.016), ("LowerArm", "Hand", 0.013),
    ("UpperLeg", "LowerLeg", 0.020), ("LowerLeg", "Foot", 0.017), ("Foot", "Toes", 0.012),
)  # fmt: skip
_SPINE: Final = ("hips", "spine", "chest", "upperChest", "neck", "head")


def _rest(name: str) -> Point:
    x, y, z = SKELETON.rest_positions()[SKELETON.index(name)].tolist()
    return x, y, z


def _spine() -> list[_Line]:
    """Return the vertebrae: short thick pieces with gaps between them."""
    lines: list[_Line] = []
    for low, high in itertools.pairwise(_SPINE):
        a, b = np.array(_rest(low)), np.array(_rest(high))
        for piece in range(3):
            first, last = a + (b - a) * (piece / 3.0 + 0.07), a + (b - a) * ((piece + 1) / 3.0 - 0.07)
            back = np.array([0.0, 0.0, -0.022])
            begin, end = (first + back).tolist(), (last + back).tolist()
            lines.append(([tuple(begin), tuple(end)], [low, low], 0.017, 0.9))
    return lines


def _ribs() -> list[_Line]:
    """Return the ribs: six arcs on each side, from the spine down and forward to the breastbone, and that bone."""
    lines: list[_Line] = []
    for rib, (height, wide, deep) in enumerate(
        ((1.355, 0.085, 0.060), (1.320, 0.105, 0.076), (1.284, 0.116, 0.086), (1.248, 0.120, 0.088),
         (1.210, 0.116, 0.082), (1.172, 0.106, 0.070))
    ):  # fmt: skip
        joint = "upperChest" if rib < 4 else "chest"
        ends = 2.55 if rib < 5 else 2.0
        for side in (-1.0, 1.0):
            arc = [
                (side * wide * float(np.sin(a)), height - 0.030 * float(1 - np.cos(a)), -deep * float(np.cos(a)) * 0.9)
                for a in np.linspace(0.25, ends, 7)
            ]
            lines.append((arc, [joint] * 7, 0.0065, 0.62))
    breast: list[Point] = [(0.0, 1.335, 0.058), (0.0, 1.27, 0.082), (0.0, 1.205, 0.080)]
    return [*lines, (breast, ["upperChest"] * 3, 0.011, 0.7)]


def _skull() -> list[_Line]:
    turn = np.linspace(0.0, 2.0 * np.pi, 17)
    jaw: list[Point] = [
        (0.056, 1.585, 0.020), (0.040, 1.540, 0.050), (0.0, 1.515, 0.076), (-0.040, 1.540, 0.050),
        (-0.056, 1.585, 0.020),
    ]  # fmt: skip
    teeth: list[Point] = [(0.030, 1.552, 0.062), (0.0, 1.548, 0.078), (-0.030, 1.552, 0.062)]
    lines: list[_Line] = [
        ([(0.0, 1.622, -0.030), (0.0, 1.630, 0.012)], ["head"] * 2, 0.064, 0.34),
        ([(0.0, 1.575, 0.030), (0.0, 1.560, 0.034)], ["head"] * 2, 0.038, 0.22),
        (jaw, ["head"] * len(jaw), 0.009, 0.55),
        (teeth, ["head"] * len(teeth), 0.006, 0.5),
    ]
    for x in (-0.028, 0.028):
        eye: list[Point] = [(x + 0.016 * float(np.cos(a)), 1.600 + 0.014 * float(np.sin(a)), 0.080) for a in turn[::2]]
        lines.append((eye, ["head"] * len(eye), 0.005, 0.6))
    return lines


def _limbs(side: str, sign: float) -> list[_Line]:
    lines: list[_Line] = [
        ([_rest(side + a), _rest(side + b)], [side + a, side + b], radius, 1.0) for a, b, radius in _LONG_BONES
    ]
    collar: list[Point] = [(0.012 * sign, 1.385, 0.045), _rest(f"{side}UpperArm")]
    blade: list[Point] = [
        _rest(f"{side}UpperArm"), (0.070 * sign, 1.375, -0.082), (0.088 * sign, 1.265, -0.088),
        _rest(f"{side}UpperArm"),
    ]  # fmt: skip
    hip: list[Point] = [
        (0.0, 0.955, -0.055), (0.095 * sign, 0.985, -0.045), (0.125 * sign, 0.950, 0.015), (0.085 * sign, 0.890, 0.040),
        (0.0, 0.862, 0.050), (0.040 * sign, 0.835, 0.0), (0.0, 0.870, -0.060),
    ]  # fmt: skip
    lines += [
        (collar, ["upperChest", f"{side}UpperArm"], 0.009, 0.75),
        (blade, [f"{side}Shoulder"] * 4, 0.006, 0.5),
        (hip, ["hips"] * len(hip), 0.009, 0.65),
    ]
    wrist = (0.685 * sign, 1.380, -0.010)
    for z in (-0.036, -0.015, 0.006, 0.026):
        finger: list[Point] = [wrist, (0.762 * sign, 1.377, z * 0.85), (0.838 * sign, 1.364, z)]
        lines.append((finger, [f"{side}Hand"] * 3, 0.0058, 0.75))
    thumb: list[Point] = [wrist, (0.735 * sign, 1.370, 0.036), (0.772 * sign, 1.362, 0.058)]
    lines.append((thumb, [f"{side}Hand"] * 3, 0.0058, 0.75))
    ankle = _rest(f"{side}Foot")
    heel: list[Point] = [ankle, (0.090 * sign, 0.020, -0.050)]
    lines.append((heel, [f"{side}Foot"] * 2, 0.012, 0.8))
    for x in (-0.026, -0.009, 0.008, 0.025):
        toe: list[Point] = [(0.090 * sign + 0.4 * x, 0.052, 0.060), (0.090 * sign + x, 0.022, 0.130)]
        lines.append((toe, [f"{side}Foot"] * 2, 0.006, 0.65))
        tip: list[Point] = [(0.090 * sign + x, 0.022, 0.130), (0.090 * sign + x, 0.014, 0.176)]
        lines.append((tip, [f"{side}Toes"] * 2, 0.006, 0.65))
    return lines


@cache
def bone_vertices() -> Float32:
    """Return quads of all bones as six vertices each, shape (6 B, 12): start and its joint, end and its joint, radius
    [m], which end, side, brightness."""
    lines = [*_spine(), *_ribs(), *_skull(), *_limbs("left", 1.0), *_limbs("right", -1.0)]
    rows: list[list[float]] = []
    corners = ((0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, -1.0), (1.0, 1.0), (0.0, 1.0))
    for points, joints, radius, bright in lines:
        hung = [(*point, float(SKELETON.index(joint))) for point, joint in zip(points, joints, strict=True)]
        for begin, end in itertools.pairwise(hung):
            rows += [[*begin, *end, radius, which, side, bright] for which, side in corners]
    return np.array(rows, np.float32)
