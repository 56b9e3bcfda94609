"""The `d` of an SVG path as segments: its grammar and its curves (SVG 2, sections 9.3 and B.2).

Points are complex numbers, y down. Curves are computed in the order of operations of svgpathtools, which read paths
before: drawings keep their places to the last bit. svgpathtools with SciPy takes 0.4 s to import.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

_COMMAND: Final = re.compile(r"([MmZzLlHhVvCcSsQqTtAa])")
_NUMBER: Final = re.compile(r"[-+]?[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]+)?")
_FLAG: Final = re.compile(r"[01]")
_SEPARATOR: Final = re.compile(r"[\s,]*")
_ARGUMENTS: Final = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_ARC_FLAGS: Final = (3, 4)
"""Arguments of an arc that are one character and need no separator."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A line or curve between two points; `point` gives the point of a curve at a share from 0 to 1, None: a line."""

    start: complex
    end: complex
    point: Callable[[float], complex] | None = None


def read_path(d: str) -> list[Segment]:
    """Return the segments of a path; ValueError if it is none."""
    reader = _Reader()
    for command, numbers in _commands(d):
        reader.add(command, numbers)
    return reader.segments


def _commands(d: str) -> Iterator[tuple[str, list[float]]]:
    """Yield each command with as many numbers as it takes; further numbers repeat it (after M: L, after m: l)."""
    before, *parts = _COMMAND.split(d)
    if _NUMBER.search(before):
        raise ValueError("numbers without a command")
    for command, text in zip(parts[::2], parts[1::2], strict=True):
        count = _ARGUMENTS[command.upper()]
        numbers = [float(word) for word in (_arc_words(text) if count == 7 else _NUMBER.findall(text))]
        if not count:
            if numbers:
                raise ValueError(f"numbers after {command}")
            yield command, []
            continue
        if not numbers or len(numbers) % count:
            raise ValueError(f"{command} takes {count} numbers, not {len(numbers)}")
        for at in range(0, len(numbers), count):
            yield command, numbers[at : at + count]
            command = {"M": "L", "m": "l"}.get(command, command)


def _arc_words(text: str) -> Iterator[str]:
    place, field = 0, 0
    while True:
        place = _SEPARATOR.match(text, place).end()  # type: ignore[union-attr]  # also matches nothing
        found = _FLAG.match(text, place) if field % 7 in _ARC_FLAGS else None
        found = found or _NUMBER.match(text, place)
        if found is None:
            return
        yield found.group()
        place, field = found.end(), field + 1


class _Reader:
    """Turns commands into segments."""

    def __init__(self) -> None:
        self.segments: list[Segment] = []
        self._at = 0j
        self._begin: complex | None = None  # of the subpath
        self._before = ""  # the command before
        self._control = 0j  # the last control point of the curve before

    def add(self, command: str, numbers: list[float]) -> None:
        """Add the segment of one command."""
        kind = command.upper()
        if kind == "Z":
            if self._begin is None:
                raise ValueError("closed before it begins")
            if self._at != self._begin:
                self._line(self._begin)
            self._at = self._begin
        elif kind in "HV":
            self._line(self._along_axis(kind, numbers[0], relative=command.islower()))
        elif kind == "A":
            self._arc(numbers, self._at if command.islower() else None)
        else:
            points = [x + y * 1j for x, y in zip(numbers[::2], numbers[1::2], strict=True)]
            if command.islower():
                points = [point + self._at for point in points]
            if kind == "M":
                self._at = self._begin = points[0]
            elif kind == "L":
                self._line(points[0])
            else:
                self._bezier(kind, points)
        self._before = kind

    def _along_axis(self, kind: str, number: float, *, relative: bool) -> complex:
        at = self._at
        if kind == "H":
            end = number + at.imag * 1j
            return end + at.real if relative else end
        end = at.real + number * 1j
        return end + at.imag * 1j if relative else end

    def _line(self, end: complex) -> None:
        self.segments.append(Segment(self._at, end))
        self._at = end

    def _bezier(self, kind: str, points: list[complex]) -> None:
        if kind in "ST":  # the first control point is the last one of the same kind of curve, reflected
            smooth = self._before in {"S": "CS", "T": "QT"}[kind] and self._before
            points = [self._at + self._at - self._control if smooth else self._at, *points]
        if len(points) == 3:
            curve = partial(_cubic, self._at, points[0], points[1], points[2])
        else:
            curve = partial(_quadratic, self._at, points[0], points[1])
        self.segments.append(Segment(self._at, points[-1], curve))
        self._control, self._at = points[-2], points[-1]

    def _arc(self, numbers: list[float], origin: complex | None) -> None:
        radius_x, radius_y, rotation, large, sweep, x, y = numbers
        end = x + y * 1j if origin is None else x + y * 1j + origin
        if radius_x == 0 or radius_y == 0:
            self._line(end)
            return
        if end == self._at:
            raise ValueError("an arc ends where it starts")
        radii = abs(radius_x), abs(radius_y)
        self.segments.append(Segment(self._at, end, _arc(self._at, end, radii, rotation, bool(large), bool(sweep))))
        self._at = end


def _quadratic(start: complex, control: complex, end: complex, t: float) -> complex:
    rest = 1 - t
    return rest * rest * start + 2 * rest * t * control + t * t * end


def _cubic(start: complex, first: complex, second: complex, end: complex, t: float) -> complex:
    return start + t * (
        3 * (first - start) + t * (3 * (start + second) - 6 * first + t * (-start + 3 * (first - second) + end))
    )


def _arc(
    start: complex, end: complex, radii: tuple[float, float], rotation: float, large: bool, sweep: bool
) -> Callable[[float], complex]:
    """Return the points of an elliptical arc, from its end points to its centre (SVG 2, B.2.4); `rotation` [degrees].

    Radii that are too small to reach are enlarged.
    """
    phi = np.radians(rotation)
    turn = np.exp(1j * phi)
    half = (1 / turn) * (start - end) / 2  # the start, from the middle of start and end, along the axes
    (rx, ry), (x, y) = radii, (half.real, half.imag)
    reach = (x * x / (rx * rx)) + (y * y / (ry * ry))
    if reach > 1:
        rx, ry = rx * np.sqrt(reach), ry * np.sqrt(reach)
    rx2, ry2, x2, y2 = rx * rx, ry * ry, x * x, y * y
    across = rx2 * y2 + ry2 * x2
    share = (rx2 * ry2 - across) / across
    root = 0 if np.isclose(share, 0) else np.sqrt(share)
    middle = (-root if large == sweep else root) * (rx * y / ry - 1j * ry * x / rx)
    centre = np.exp(1j * phi) * middle + (start + end) / 2
    first = complex(_within_one((x - middle.real) / rx), _within_one((y - middle.imag) / ry))
    last = complex(_within_one((-x - middle.real) / rx), _within_one((-y - middle.imag) / ry))
    begin, angle = _arc_angles(first, last)
    if not sweep and angle >= 0:
        angle -= 360
    elif large and angle <= 0:
        angle += 360

    def point(t: float) -> complex:
        at = (begin + t * angle) * np.pi / 180
        along = rx * turn.real * np.cos(at) - ry * turn.imag * np.sin(at) + centre.real
        down = rx * turn.imag * np.cos(at) + ry * turn.real * np.sin(at) + centre.imag
        return complex(along, down)

    return point


def _within_one(value: float) -> float:
    return float(np.clip(value, -1, 1))


def _arc_angles(first: complex, last: complex) -> tuple[float, float]:
    """Return the angle of `first` on the unit circle, and the shorter one from there to `last` [degrees]."""
    begin = float(np.degrees(np.arccos(first.real)))
    if first.imag < 0:
        begin = -begin
    elif first.imag == 0:
        begin = 0 if first.real > 0 else 180
    side = first.real * last.imag - first.imag * last.real
    cosine = first.real * last.real + first.imag * last.imag
    if side == 0:
        return begin, 0 if cosine > 0 else 180
    angle = float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return begin, angle if side > 0 else -angle
