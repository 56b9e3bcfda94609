"""A dancer's part: for each scene where she begins, how and when she goes, whom she passes, and where she arrives."""

import math
from dataclasses import dataclass
from itertools import groupby
from typing import Final

import numpy as np
import shapely

from live.base.arrays import Float64
from live.document.sheets.scenes import Scene
from live.document.sheets.show_record import Led, ShowRecord
from live.document.sheets.stage_words import side_words

STAYS_M: Final = 0.35
"""Whoever is never farther from the first place than this stays there: steps sway [m]."""
OFF_SHARE: Final = 0.4
"""Share of the largest distance at which she has set off, and from the last place at which she is there ..."""
OFF_M: Final = 0.3
"""... and the largest such distance [m]."""
PASS_M: Final = 1.3
"""Two dancers who come nearer than this pass each other [m] ..."""
APART_M: Final = 0.5
"""... if before and after they are farther apart by this [m]."""
WAY_TOLERANCE: Final = 0.08
"""Largest error of a drawn way [m]."""
LENGTH_TOLERANCE: Final = 0.15
"""The sway of steps that does not count as way [m]."""
PASSED_COSINE: Final = 0.3
"""... and there in directions whose angle has at most this cosine: who comes near and goes back does not pass."""
AROUND: Final = 2
"""Measures before and after a scene in which that may be."""
MAX_PASSES: Final = 6
"""Most passings that a scene tells of, the nearest ones."""


@dataclass(frozen=True, slots=True)
class Passing:
    """Two dancers pass each other."""

    other: int
    """Index of the other dancer."""
    beat: float
    distance: float
    """Metres."""
    side: str
    """As `on your left`."""


@dataclass(frozen=True, slots=True, eq=False)
class PartScene:
    """A dancer's part in one scene."""

    scene: Scene
    there: tuple[bool, bool]
    """Whether she is on the stage at its beginning and at its end."""
    entrance: float | None
    """The danced beat at which she comes in."""
    exit: float | None
    """The danced beat at which she is off."""
    start: tuple[float, float]
    """Where she begins [m]; at the gate if she comes in."""
    end: tuple[float, float]
    heading: tuple[float, float]
    """Her heading at both [rad]."""
    stays: bool
    way: Float64
    """Her drawn way, (P, 2) [m]."""
    beat_places: Float64
    """Where her way is at each beat, (B, 2) [m]; NaN while she is off the stage."""
    length: float
    """Length of the way without the sway of steps [m]."""
    off: float
    """The danced beat at which she sets off ..."""
    arrived: float
    """... and the one from which on she is at the last place."""
    led: tuple[Led, ...]
    """Segments that lead her."""
    free: tuple[str, ...]
    """Kinds of elements that move her."""
    steps: tuple[tuple[str, int], ...]
    """What she dances, and for how many measures."""
    group: int
    partner: int
    """Index of her partner, -1 for none."""
    passings: tuple[Passing, ...]
    more_passings: int
    """Passings that are not told."""


def part_scene(record: ShowRecord, dancer: int, scene: Scene, ways: Float64) -> PartScene:
    """Return the part of a dancer (index) in a scene with these `calm_ways`."""
    rows = record.rows(scene.first, scene.end)
    there, danced = record.present[rows, dancer], record.danced[rows]
    seen = np.flatnonzero(there)
    begin, last = (int(seen[0]), int(seen[-1])) if len(seen) else (0, 0)
    way = ways[begin : last + 1, dancer] if len(seen) else record.place[rows, dancer][:1].astype(np.float64)
    from_start, from_end = (np.hypot(*(way - way[k]).T) for k in (0, -1))
    away = np.flatnonzero(from_start > min(OFF_M, OFF_SHARE * from_start.max()))
    late = np.flatnonzero(from_end > min(OFF_M, OFF_SHARE * from_end.max()))
    middle = scene.first + (scene.end - scene.first) // 2
    passings = _passings(record, dancer, scene, ways) if len(seen) else []
    near = sorted(sorted(passings, key=lambda one: one.distance)[:MAX_PASSES], key=lambda one: (one.beat, one.other))
    heading = record.heading[rows, dancer]
    return PartScene(
        scene,
        (bool(there[0]), bool(there[-1])),
        float(danced[begin]) if len(seen) and begin > 0 else None,
        float(danced[last]) if len(seen) and last < len(there) - 1 else None,
        (float(way[0, 0]), float(way[0, 1])),
        (float(way[-1, 0]), float(way[-1, 1])),
        (float(heading[begin]), float(heading[last])),
        bool(from_start.max() <= STAYS_M),
        simplified(way, WAY_TOLERANCE),
        _beat_places(record, scene, ways[:, dancer], danced),
        _length(simplified(way, LENGTH_TOLERANCE)),
        float(danced[begin + away[0]]) if len(away) else float(danced[begin]),
        float(danced[min(begin + int(late[-1]) + 1, last)]) if len(late) else float(danced[begin]),
        tuple(led for led in scene.led if dancer in led.dancers),
        tuple(dict.fromkeys(free.kind for free in scene.free if dancer in free.dancers)),
        _steps(record, dancer, scene),
        int(record.group[middle, dancer]),
        int(record.partner[middle, dancer]),
        tuple(near),
        len(passings) - len(near),
    )


def simplified(way: Float64, tolerance: float) -> Float64:
    """Return a way (P, 2) [m] with fewer points (Douglas and Peucker 1973), nowhere farther from it than
    `tolerance` [m]."""
    if len(way) < 3:
        return way
    line = shapely.simplify(shapely.LineString(way), tolerance, preserve_topology=False)
    return np.asarray(shapely.get_coordinates(line), np.float64)


def _length(way: Float64) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum()) if len(way) > 1 else 0.0


def _beat_places(record: ShowRecord, scene: Scene, way: Float64, danced: Float64) -> Float64:
    first, over = scene.beats(record)
    beats = np.arange(first, over + 0.5)
    return np.asarray(way[np.abs(danced[:, None] - beats[None, :]).argmin(axis=0)])


def _steps(record: ShowRecord, dancer: int, scene: Scene) -> tuple[tuple[str, int], ...]:
    steps = record.step[scene.first : scene.end, dancer].tolist()
    words = [record.steps[step] if step >= 0 else "answers the leader" for step in steps]
    return tuple((name, len(list(run))) for name, run in groupby(words))


def _passings(record: ShowRecord, dancer: int, scene: Scene, ways: Float64) -> list[Passing]:
    """Return whom a dancer passes: the distance has its least value within the scene, and grows on both sides, there or
    in the two measures before or after."""
    rows = record.rows(scene.first, scene.end)
    partners = set(record.partner[:, dancer].tolist())
    toward = ways - ways[:, [dancer]]
    apart = _distances(toward, dancer)
    nearest, least = apart.argmin(axis=0), apart.min(axis=0)
    earlier = _toward_at(record, dancer, range(max(scene.first - AROUND, 0), scene.first))
    later = _toward_at(record, dancer, range(scene.end + 1, min(scene.end + AROUND, record.measures) + 1))
    found = []
    for other in np.flatnonzero(least < PASS_M).tolist():
        row = int(nearest[other])
        if row == len(apart) - 1 or other in partners:  # the next scene tells of it
            continue
        before = _farthest(np.concatenate([earlier[:, other], toward[: row + 1, other]]))
        after = _farthest(np.concatenate([toward[row:, other], later[:, other]]))
        far = math.hypot(*before), math.hypot(*after)
        if min(far) - least[other] < APART_M or float(before @ after) > PASSED_COSINE * far[0] * far[1]:
            continue
        side = side_words(_mean_heading(record, dancer, rows.start + row), *toward[row, other])
        found.append(Passing(other, float(record.danced[rows.start + row]), float(least[other]), side))
    return found


def _distances(toward: Float64, dancer: int) -> Float64:
    """Return the lengths of (T, A, 2) [m], (T, A); inf for those off the stage and for herself."""
    apart = np.hypot(*np.moveaxis(toward, 2, 0))
    apart[np.isnan(apart)] = np.inf
    apart[:, dancer] = np.inf
    return np.asarray(apart)


def _toward_at(record: ShowRecord, dancer: int, lines: range) -> Float64:
    """Return all places relative to a dancer at these measure lines, (L, A, 2) [m]; NaN for those off the stage."""
    rows = record.lines[list(lines)]
    places = np.where(record.present[rows][:, :, None], record.place[rows], np.nan).astype(np.float64)
    return np.asarray(places - places[:, [dancer]])


def _farthest(toward: Float64) -> Float64:
    """Return the longest of (T, 2) [m], at least one of which is not NaN."""
    return np.asarray(toward[np.nanargmax(np.hypot(*toward.T))])


def _mean_heading(record: ShowRecord, dancer: int, row: int) -> float:
    """Return the heading [rad] over a beat before and after a sample; where she spins, that of her way."""
    beat = record.danced[row]
    first, end = np.searchsorted(record.danced, [beat - 1.0, beat + 1.0])
    angles = record.heading[first:end, dancer].astype(np.float64)
    across, along = float(np.sin(angles).mean()), float(np.cos(angles).mean())
    if math.hypot(across, along) < 0.5:
        across, along = (record.place[end - 1, dancer] - record.place[first, dancer]).astype(float).tolist()
    return math.atan2(across, along)
