"""Scores of beat trackers: F-measure, continuity (Hainsworth; Davies), time to lock, errors; live or as claimed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Times = npt.NDArray[np.float64]

TOLERANCE = 0.07
"""A beat is hit within so many seconds."""

FIRST = 5.0
"""Beats before are not scored: every tracker has to hear some first [s]."""

LATE = 0.05
LOCK_SPAN = 4.0
CONTINUITY = 0.175


@dataclass(frozen=True, slots=True, eq=False)
class Named:
    """Beats as a tracker named them: when they are [s], when it said so [s], and which of the measure (1 first)."""

    time: Times
    emitted: Times
    beat: npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Beats as they are: `time` [s], `beat` of the measure (1 first), spans that do not count, changes of tempo."""

    time: Times
    beat: npt.NDArray[np.int64]
    ignore: Sequence[Sequence[float]]
    changes: Sequence[float]
    downbeats: bool
    duration: float


@dataclass(frozen=True, slots=True)
class Score:
    """Of one piece; NaN where there is nothing to score."""

    f: float
    f_live: float
    amlt: float
    cmlt: float
    downbeat_live: float
    lock: float
    relock: tuple[float, ...]
    freewheel: float
    late: float
    errors: tuple[float, ...]


def f_measure(truth: Times, found: Times) -> float:
    """Harmonic mean of hits / found and hits / truth; each beat may be hit once."""
    if not truth.size or not found.size:
        return 0.0
    hits = i = j = 0
    while i < truth.size and j < found.size:
        if abs(truth[i] - found[j]) <= TOLERANCE:
            hits, i, j = hits + 1, i + 1, j + 1
        elif truth[i] < found[j]:
            i += 1
        else:
            j += 1
    return 2.0 * hits / (truth.size + found.size)


def continuity(truth: Times, found: Times) -> tuple[float, float]:
    """(CMLt, AMLt): shares of beats that follow the truth, at its own level, and at any usual one."""
    if truth.size < 2 or found.size < 2:
        return 0.0, 0.0
    double = np.interp(np.arange(0.0, truth.size - 0.5, 0.5), np.arange(truth.size), truth)
    levels = (truth, double[1::2], double, truth[::2], truth[1::2])
    shares = [_followed(level, found) if level.size > 1 else 0.0 for level in levels]
    return shares[0], max(shares)


def _followed(truth: Times, found: Times) -> float:
    used = np.zeros(truth.size, bool)
    gaps, steps = np.diff(truth), np.diff(found)
    good = 0
    for m in range(found.size):
        nearest = int(np.argmin(np.abs(found[m] - truth)))
        if used[nearest]:
            continue
        ahead = m == 0 or nearest == 0
        gap = gaps[min(nearest, gaps.size - 1)] if ahead else gaps[nearest - 1]
        step = steps[min(m, steps.size - 1)] if ahead else steps[m - 1]
        if abs(found[m] - truth[nearest]) < CONTINUITY * gap and abs(1.0 - step / gap) < CONTINUITY:
            used[nearest] = True
            good += 1
    return good / max(truth.size, found.size)


def matches(truth: Times, found: Times) -> list[tuple[int, int]]:
    """Pairs (i, j) within the tolerance, the nearest first, each beat once."""
    if not truth.size or not found.size:
        return []
    distance = np.abs(truth[:, None] - found[None])
    pairs = np.argwhere(distance <= TOLERANCE)
    pairs = pairs[np.argsort(distance[pairs[:, 0], pairs[:, 1]], kind="stable")]
    taken_i: set[int] = set()
    taken_j: set[int] = set()
    out = []
    for i, j in pairs.tolist():
        if i not in taken_i and j not in taken_j:
            taken_i.add(i)
            taken_j.add(j)
            out.append((i, j))
    return out


def lock(truth: Times, found: Times, start: float, end: float) -> float:
    """Seconds from `start` to the first beat from which all is right for 4 s, nothing too much; NaN if never."""
    hit, right = np.zeros(truth.size, bool), np.zeros(found.size, bool)
    for i, j in matches(truth, found):
        hit[i] = right[j] = True
    for time in truth[(truth >= start) & (truth <= end - LOCK_SPAN)]:
        there = (truth >= time - 1e-9) & (truth < time + LOCK_SPAN)
        here = (found >= time - TOLERANCE) & (found < time + LOCK_SPAN - TOLERANCE)
        if there.sum() >= 3 and hit[there].all() and right[here].all():
            return float(time - start)
    return math.nan


def score(named: Named, truth: Truth, first: float = FIRST) -> Score:
    """All scores of one piece; `first`: beats before this time [s] are left out."""
    order = np.argsort(named.time, kind="stable")
    time, emitted, beat = named.time[order], named.emitted[order], named.beat[order]
    live = np.sort(np.maximum(time, emitted))

    def kept(times: Times) -> Times:
        return times[_outside(times, truth.ignore) & (times >= first) & (times <= truth.duration)]

    reference, claimed = kept(truth.time), kept(time)
    cmlt, amlt = continuity(reference, claimed)
    downbeat = math.nan
    if truth.downbeats and (beat > 0).any():
        ones = np.sort(np.maximum(time, emitted)[beat == 1])
        downbeat = f_measure(kept(truth.time[truth.beat == 1]), kept(ones))
    inside, found = truth.time[_outside(truth.time, truth.ignore)], time[_outside(time, truth.ignore)]
    points = [span[1] for span in truth.ignore] + list(truth.changes)
    pairs = matches(reference, claimed)
    return Score(
        f=f_measure(reference, claimed),
        f_live=f_measure(reference, kept(live)),
        amlt=amlt,
        cmlt=cmlt,
        downbeat_live=downbeat,
        lock=lock(inside, found, 0.0, truth.duration),
        relock=tuple(lock(inside, found, point, truth.duration) for point in points),
        freewheel=_freewheel(time, truth),
        late=float(np.mean(emitted > time + LATE)) if time.size else 0.0,
        errors=tuple(float(claimed[j] - reference[i]) for i, j in pairs),
    )


def _outside(times: Times, spans: Sequence[Sequence[float]]) -> npt.NDArray[np.bool_]:
    keep = np.ones(times.size, bool)
    for begin, end in spans:
        keep &= ~((times >= begin) & (times < end))
    return keep


def _freewheel(found: Times, truth: Truth) -> float:
    """Share of the beats in silences (where the truth has any) that are met; NaN where there are none."""
    shares = []
    for begin, end in truth.ignore:
        grid = truth.time[(truth.time >= begin) & (truth.time < end)]
        if grid.size > 3:
            near = found[(found >= begin - 0.1) & (found < end + 0.1)]
            shares.append(len(matches(grid, near)) / grid.size)
    return float(np.mean(shares)) if shares else math.nan


def read_truth(stem: Any, duration: float) -> Truth:
    """The truth beside an excerpt: NAME.beats and NAME.json."""
    import json
    from pathlib import Path

    beats = np.loadtxt(f"{stem}.beats", ndmin=2)
    meta = json.loads(Path(f"{stem}.json").read_text(encoding="utf-8"))
    return Truth(
        time=beats[:, 0],
        beat=beats[:, 1].astype(np.int64),
        ignore=meta.get("ignore", []),
        changes=meta.get("changes", []),
        downbeats=not meta.get("no_downbeat", False) and meta.get("has_downbeat", True),
        duration=duration,
    )
