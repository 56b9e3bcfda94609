"""Roster: the dancers of a show, their attributes, and named groups (T104).

Relations between groups: the same motion mirrored about a line, or delayed by some beats (T092, T104, T147).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64

Mask = npt.NDArray[np.bool_]

PLACE_WORDS = ("left", "right", "front", "back", "centre", "center")
"""Words for a dancer's current position, as the audience sees it, unless a group has this name."""
ALL_WORDS = ("all", "everyone")
"""Words for every dancer, unless a group has this name."""


@dataclass(frozen=True, slots=True)
class Roster:
    """The dancers of a show, numbered from 1 for people, their attributes, and named groups.

    A group is an expression (see `selection`), so it can be divided repeatedly, and a group by place is evaluated at
    every use (T104, Schulz 2011, 4.3.3).
    """

    attributes: tuple[frozenset[str], ...]
    """Attribute words of each dancer, in the order of their numbers; length A."""
    groups: Mapping[str, str] = field(default_factory=dict)
    """Name of a group → expression that selects its dancers."""
    known: frozenset[str] = frozenset()
    """Valid words that no dancer has at present; they select none."""

    @staticmethod
    def create(count: int, attributes: Mapping[int, Sequence[str]] | None = None, **groups: str) -> "Roster":
        """Return a roster of `count` dancers; `attributes` maps a dancer's number (from 1) to words, `groups` names
        expressions.
        """
        words = attributes or {}
        return Roster(tuple(frozenset(words.get(number, ())) for number in range(1, count + 1)), groups)

    @property
    def count(self) -> int:
        """Number of dancers A."""
        return len(self.attributes)

    def words(self) -> tuple[str, ...]:
        """Return all attributes in use, sorted."""
        return tuple(sorted({word for words in self.attributes for word in words}))

    def with_attribute(self, word: str) -> Mask:
        """Whether each dancer has this attribute, shape (A,)."""
        return np.array([word in words for words in self.attributes], np.bool_)


@dataclass(frozen=True, slots=True)
class Line:
    """A line on the floor through (x, z) [m]; `heading` [rad] is its direction, 0 towards the audience.

    The centre line of the stage, which mirrors left and right, is ``Line()``.
    """

    x: float = 0.0
    z: float = 0.0
    heading: float = 0.0

    @staticmethod
    def through(first: tuple[float, float], second: tuple[float, float]) -> "Line":
        """Return the line through two distinct points [m]."""
        dx, dz = second[0] - first[0], second[1] - first[1]
        if math.hypot(dx, dz) < 1e-9:
            raise ValueError("a line needs two different points")
        return Line(first[0], first[1], math.atan2(dx, dz))


def mirror_places(places: npt.ArrayLike, line: Line) -> Float64:
    """Return places (..., 2) [m] reflected in `line`."""
    points = np.asarray(places, np.float64)
    along = np.array([math.sin(line.heading), math.cos(line.heading)])
    offset = points - np.array([line.x, line.z])
    return np.asarray(2.0 * (offset @ along)[..., None] * along - offset + np.array([line.x, line.z]))


def mirror_headings(headings: npt.ArrayLike, line: Line) -> Float64:
    """Return headings (...) [rad] reflected in `line`."""
    return np.asarray(2.0 * line.heading - np.asarray(headings, np.float64))
