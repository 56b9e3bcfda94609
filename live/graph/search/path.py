"""Paths on the stage: a drawn line becomes a place and a heading for the end of each measure (T067, T068, T127, T128).

Places are positions, not distances: whoever ends a measure a little off aims at the next place from where she is, so
that errors cancel instead of adding (T068).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError

Float64 = npt.NDArray[np.float64]

MOST_POINTS: Final = 100_000
FARTHEST: Final = 1000.0
"""A place farther than this [m] from the centre of the stage is a misprint."""
STILL: Final = 1e-3
"""A way shorter than this [m] has no direction."""
Facing = Literal["public", "path"]


@dataclass(frozen=True, slots=True, eq=False)
class Targets:
    """Where a dancer should be at the N + 1 measure lines of a path, the first one included."""

    place: Float64
    """x, z [m], shape (N + 1, 2)."""
    heading: Float64
    """Where she should face [rad], unwrapped: a full turn is 2π away; shape (N + 1,)."""

    @property
    def measures(self) -> int:
        """Number of measures N."""
        return len(self.place) - 1

    @property
    def ways(self) -> Float64:
        """Length of the way of each measure, as the crow flies [m], shape (N,)."""
        return np.asarray(np.hypot(*np.diff(self.place, axis=0).T), np.float64)

    @property
    def turns(self) -> Float64:
        """Rotation wanted in each measure, O(n) - O(n - 1) [rad], shape (N,) (T128)."""
        return np.diff(self.heading)


def read_path(text: str) -> Float64:
    """The points (K, 2) of "x,z,x,z,…" [m]; semicolons and blanks may part the pairs. Else a PersonError."""
    words = [word.strip() for word in text.replace(";", ",").split(",")]
    if len(words) > 2 * MOST_POINTS:
        raise PersonError(f"path: {len(words)} numbers, at most {2 * MOST_POINTS} are read", "give fewer points")
    if len(words) % 2 or len(words) < 4:
        raise PersonError(
            f"path {_shortened(text)!r}: {len(words)} numbers read, an even number of at least 4 expected",
            'give points as x,z pairs in metres, as in "0,0, 4,0, 4,4"',
        )
    values = []
    for place, word in enumerate(words, start=1):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not abs(value) <= FARTHEST:
            raise PersonError(
                f"path: number {place} is {_shortened(word)!r}, a number from {-FARTHEST:g} to {FARTHEST:g} expected",
                "x goes to the right of the audience and z towards it, both in metres from the centre of the stage",
            )
        values.append(value)
    return np.array(values).reshape(-1, 2)


def follow_line(points: npt.ArrayLike, measures: int, *, facing: Facing | tuple[float, float] = "public") -> Targets:
    """The line through `points` (K, 2) [m] in `measures` parts of equal length (T067).

    `facing`: "public" (heading 0), "path" (along the way, the middle of each measure's), or two headings [rad], from
    the first to the second evenly and the shorter way round. Points in one place count once; a line of no length is
    a dance on the spot. ValueError for no points, numbers that are not finite, or fewer than one measure.
    """
    points = np.asarray(points, np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not len(points) or not np.isfinite(points).all():
        raise ValueError(f"points: finite numbers of shape (K, 2) expected, got shape {points.shape}")
    if measures < 1:
        raise ValueError(f"{measures} measures: at least 1 expected")
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    at = np.linspace(0.0, along[-1], measures + 1)
    place = np.stack([np.interp(at, along, points[:, axis]) for axis in (0, 1)], axis=1)
    place[-1] = points[-1]
    if facing == "public":
        heading = np.zeros(measures + 1)
    elif facing == "path":
        heading = along_headings(place)
    else:
        first, last = facing
        turn = math.remainder(last - first, 2.0 * math.pi)
        heading = first + turn * np.arange(measures + 1) / measures
    return Targets(place, heading)


def along_headings(place: Float64) -> Float64:
    """Headings [rad], unwrapped, (N + 1,): at each place along the way that leads there; the first as the second."""
    way = np.diff(place, axis=0)
    moves = np.hypot(*way.T) > STILL
    if not moves.any():
        return np.zeros(len(place))
    direction = np.arctan2(way[:, 0], way[:, 1])
    last = np.maximum.accumulate(np.where(moves, np.arange(len(way)), -1))  # whoever stands faces where she came to
    direction = direction[np.where(last >= 0, last, int(np.argmax(moves)))]
    return np.unwrap(np.concatenate((direction[:1], direction)))


def join_targets(pieces: Sequence[Targets]) -> Targets:
    """Several paths one after another (T067): each begins where its own points do, after the last one's final line.

    The headings of a later path are taken the shorter way round from those of the one before. ValueError if there is
    none.
    """
    if not pieces:
        raise ValueError("no paths to join")
    place, heading = [pieces[0].place], [pieces[0].heading]
    for piece in pieces[1:]:
        off = 2.0 * math.pi * round((heading[-1][-1] - piece.heading[0]) / (2.0 * math.pi))
        place.append(piece.place[1:])
        heading.append(piece.heading[1:] + off)
    return Targets(np.concatenate(place), np.concatenate(heading))


def smooth_headings(heading: npt.ArrayLike) -> Float64:
    """O'(n) = 0.25 O(n - 1) + 0.5 O(n) + 0.25 O(n + 1) of headings (N,) [rad], unwrapped first (T127).

    The first and the last are held beyond the ends: a dancer begins and ends as was asked but for a quarter of the
    neighbour's difference.
    """
    unwrapped = np.unwrap(np.asarray(heading, np.float64))
    held = np.concatenate((unwrapped[:1], unwrapped, unwrapped[-1:]))
    return 0.25 * held[:-2] + 0.5 * held[1:-1] + 0.25 * held[2:]


def smoothed(targets: Targets) -> Targets:
    """The targets with their headings smoothed (T127); the places stay."""
    return Targets(targets.place, smooth_headings(targets.heading))


def _shortened(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "…"
