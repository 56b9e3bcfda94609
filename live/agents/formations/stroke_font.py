"""Single-stroke font on which dancers can stand: A to Z, 0 to 9, blank, hyphen (T090).

Letters are 6 units high, y points down (to the public). M x y begins a stroke, L x y draws a straight line, A cx cy rx
ry a b an elliptical arc from angle a to b in degrees (0 to the right, 90 down), Z closes. A stroke may end on another
stroke but none cross, so dancers of two strokes never share a place.
"""

import math
from functools import cache
from typing import Final

import numpy as np

from live.base.arrays import Float64

LETTER_GAP: Final = 2.0
"""Distance between two letters [units]."""
BLANK_WIDTH: Final = 2.0
"""Width of a blank [units]."""
ARC_STEP_DEG: Final = 6.0

STROKES: Final = {
    "A": "M 0 6 L 2.2 0 L 4.4 6 M 0.88 3.6 L 3.52 3.6",
    "B": "M 0 2.8 L 0 0 L 2.4 0 A 2.4 1.4 1.4 1.4 -90 90 Z M 0 2.8 L 0 6 L 2.4 6 A 2.4 4.4 1.6 1.6 90 -90",
    "C": "A 2.2 3 2.2 3 -45 -315",
    "D": "M 0 0 L 1.6 0 A 1.6 3 2.6 3 -90 90 L 0 6 Z",
    "E": "M 3.6 0 L 0 0 L 0 6 L 3.6 6 M 0 3 L 3 3",
    "F": "M 3.6 0 L 0 0 L 0 6 M 0 3 L 3 3",
    "G": "A 2.2 3 2.2 3 -45 -350 L 4.37 3.2 L 2.6 3.2",
    "H": "M 0 0 L 0 6 M 4 0 L 4 6 M 0 3 L 4 3",
    "I": "M 0 0 L 0 6",
    "J": "M 3 0 L 3 4.3 A 1.5 4.3 1.5 1.7 0 180",
    "K": "M 0 0 L 0 6 M 3.8 0 L 0 3.8 M 1.3 2.5 L 4 6",
    "L": "M 0 0 L 0 6 L 3.4 6",
    "M": "M 0 6 L 0 0 L 2.4 3.8 L 4.8 0 L 4.8 6",
    "N": "M 0 6 L 0 0 L 4 6 L 4 0",
    "O": "A 2.4 3 2.4 3 90 450 Z",
    "P": "M 0 6 L 0 0 L 2.2 0 A 2.2 1.7 1.7 1.7 -90 90 L 0 3.4",
    "Q": "A 2.4 3 2.4 3 90 450 Z M 3.943 5.298 L 5.1 6.6 M 3.943 5.298 L 3 4.2",
    "R": "M 0 6 L 0 0 L 2.2 0 A 2.2 1.7 1.7 1.7 -90 90 L 0 3.4 M 1.9 3.4 L 4 6",
    "S": "A 1.9 1.45 1.8 1.45 -25 -270 A 1.9 4.45 1.9 1.55 -90 155",
    "T": "M 0 0 L 4.2 0 M 2.1 0 L 2.1 6",
    "U": "M 0 0 L 0 4 A 2 4 2 2 180 0 L 4 0",
    "V": "M 0 0 L 2.1 6 L 4.2 0",
    "W": "M 0 0 L 1.4 6 L 2.8 1.6 L 4.2 6 L 5.6 0",
    "X": "M 0 0 L 4 6 M 4 0 L 2 3 M 0 6 L 2 3",
    "Y": "M 0 0 L 2.1 3 L 4.2 0 M 2.1 3 L 2.1 6",
    "Z": "M 0 0 L 4 0 L 0 6 L 4 6",
    "0": "A 1.9 3 1.9 3 90 450 Z",
    "1": "M 0 1.4 L 1.6 0 L 1.6 6",
    "2": "A 1.9 1.85 1.9 1.85 -165 35 L 0 6 L 3.8 6",
    "3": "A 1.8 1.45 1.7 1.45 -155 90 A 1.8 4.45 1.9 1.55 -90 155",
    "4": "M 3 6 L 3 0 L 0 4.2 L 3 4.2 M 3 4.2 L 4.2 4.2",
    "5": "M 3.6 0 L 0.5 0 L 0.2 2.9 A 1.8 4.05 2 1.95 -137 150",
    "6": "A 1.9 4.1 1.9 1.9 180 540 Z M 0 4.1 A 2.6 4.1 2.6 4.1 180 285",
    "7": "M 0 0 L 3.8 0 L 1.3 6",
    "8": "A 1.9 4.45 1.9 1.55 -90 270 Z M 1.9 2.9 A 1.9 1.45 1.6 1.45 90 450",
    "9": "A 1.9 1.9 1.9 1.9 0 360 Z M 3.8 1.9 A 1.2 1.9 2.6 4.1 0 105",
    "-": "M 0 3.2 L 2.6 3.2",
}
"""All available letters except the blank."""

Stroke = tuple[Float64, bool]
"""Points (P, 2) and whether the stroke is closed."""


def text_strokes(text: str) -> list[Stroke]:
    """Return the strokes of a text, letter by letter from left to right, x to the right, y down, from (0, 0) [units].

    KeyError with the letter if the font does not have it.
    """
    strokes: list[Stroke] = []
    at = 0.0
    for letter in text.upper():
        if letter == " ":
            at += BLANK_WIDTH + LETTER_GAP
            continue
        drawn = letter_strokes(letter)
        strokes += [(points + np.array([at, 0.0]), closed) for points, closed in drawn]
        at += max(float(points[:, 0].max()) for points, _ in drawn) + LETTER_GAP
    return strokes


@cache
def letter_strokes(letter: str) -> tuple[Stroke, ...]:
    """Return the strokes of one letter, its left edge at x = 0; KeyError if the font does not have it."""
    words = STROKES[letter].split()
    strokes: list[Stroke] = []
    points: list[tuple[float, float]] = []
    closed = False
    lengths = {"M": 2, "L": 2, "A": 6, "Z": 0}
    at = 0
    while at < len(words):
        command = words[at]
        numbers = [float(word) for word in words[at + 1 : at + 1 + lengths[command]]]
        at += 1 + len(numbers)
        if command == "M" and points:
            strokes.append(_stroke(points, closed))
            points, closed = [], False
        if command in "ML":
            points.append((numbers[0], numbers[1]))
        elif command == "A":
            points += _arc(*numbers)
        else:
            closed = True
    strokes.append(_stroke(points, closed))
    return tuple(strokes)


def _stroke(points: list[tuple[float, float]], closed: bool) -> Stroke:
    array = np.array(points)
    array.setflags(write=False)
    return array, closed


def _arc(cx: float, cy: float, rx: float, ry: float, begin: float, end: float) -> list[tuple[float, float]]:
    steps = max(2, round(abs(end - begin) / ARC_STEP_DEG))
    angles = [math.radians(begin + (end - begin) * n / steps) for n in range(steps + 1)]
    return [(cx + rx * math.cos(a), cy + ry * math.sin(a)) for a in angles]
