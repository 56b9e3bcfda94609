"""Ways of groups that move in the same measures: overlaps and meetings, planned together and apart (T147)."""

import math
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.intention import Evolve, Places, Repertoire, Segment
from live.agents.evolutions.joint_planning import MEETING_GAP
from live.agents.evolutions.running_plan import Plan
from live.agents.groups.roster import Roster
from live.cli.bench import Row

Float64 = npt.NDArray[np.float64]

DANCERS: Final = 50
WIDTH, DEPTH = 14.0, 10.0
RADIUS: Final = 0.25
BEATS: Final = 4.0
SPACING: Final = 0.95
"""Least distance of two places of a formation [m]."""
EDGE: Final = 0.5
"""Metres that places keep from the border of their group's part of the stage."""
MOMENTS: Final = 256
"""Moments of a measure at which ways are measured; between them dancers move straight."""
MOVING: Final = 0.05
"""Whoever is faster than this [m per beat] is under way."""
TUNED, HELD_BACK = range(40), range(1000, 1040)
"""Seeds of the cases by which the method was tuned, and of those that it never saw."""
REPEATS: Final = 3
KINDS: Final = ("change sides", "pass through", "split and rejoin")


def run(full: bool, shared: Path | None) -> list[Row]:
    """40 random cases of 50 dancers in 2 to 4 groups who change sides, pass through, split and rejoin; with `full` also
    the 40 by which the method was tuned."""
    rows = _rows("held back", HELD_BACK)
    return rows + (_rows("tuned", TUNED) if full else [])


@dataclass(frozen=True, slots=True)
class Figures:
    """What is counted on the ways of a case."""

    overlaps: int
    """Pairs whose bodies touch."""
    meetings: int
    """Times that a pair comes nearer than `MEETING_GAP` between the bodies while both are under way."""
    way: float
    """All ways together [m]."""
    nearest: float
    """The nearest two centres [m]."""
    fastest: float
    """Metres per beat."""


def _rows(name: str, seeds: Sequence[int]) -> list[Row]:
    together, apart, took = list[Figures](), list[Figures](), list[tuple[float, float]]()
    for seed in seeds:
        case = case_of(seed)
        together.append(figures_of(ways_of(case, apart=False)[0]))
        apart.append(figures_of(ways_of(case, apart=True)[0]))
        took.append(statistics.median_low([ways_of(case, apart=False, sampled=False)[1] for _ in range(REPEATS)]))
    share = [one.meetings / max(other.meetings, 1) for one, other in zip(together, apart, strict=True)]
    longer = [one.way / other.way for one, other in zip(together, apart, strict=True)]
    overlaps, meetings = (sum(getattr(one, key) for one in apart) for key in ("overlaps", "meetings"))
    met, way = sum(one.meetings for one in together), sum(one.way for one in together)
    return [
        Row(f"{name}: overlaps", float(sum(one.overlaps for one in together)), "", 0.0, "at most",
            {"planned apart": float(overlaps)}),
        Row(f"{name}: nearest two centres", min(one.nearest for one in together), "m", 2 * RADIUS, "at least"),
        Row(f"{name}: meetings over those of plans made apart", met / meetings, "", 0.5, "at most"),
        Row(f"{name}: the same, worst case", max(share), "", None, "at most"),
        Row(f"{name}: all ways over those of plans made apart", way / sum(one.way for one in apart), "", 1.1,
            "at most"),
        Row(f"{name}: the same, worst case", max(longer), "", None, "at most"),
        Row(f"{name}: fastest dancer", max(one.fastest for one in together), "m/beat", None, "at most",
            {"planned apart": max(one.fastest for one in apart)}),
        Row(f"{name}: planned in, slowest case", 1000.0 * max(took)[0], "ms", 400.0, "at most",
            {"median": 1000.0 * statistics.median_low(took)[0],
             "processor time": 1000.0 * max(cpu for _, cpu in took)}),
    ]  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """Groups that move in the same measures."""

    kind: str
    start: Float64
    """Where the dancers stand first, (DANCERS, 2) [m]."""
    segments: tuple[Segment, ...]
    repertoire: Repertoire
    measures: int


def case_of(seed: int) -> Case:
    """Return a random case: 2 to 4 groups of 50 dancers on 14 x 10 m."""
    chance = np.random.default_rng([147, seed])
    kind = KINDS[seed % len(KINDS)]
    count = int(chance.integers(2, 5))
    parts = _parts(count, bool(chance.integers(2)))
    sizes = _sizes(chance, count)
    bounds = np.concatenate([[0], np.cumsum(sizes)])
    start = np.concatenate([_places(chance, parts[g], sizes[g]) for g in range(count)])
    shift = count // 2 if kind == "pass through" else int(chance.integers(1, count))
    goals = [(g + shift) % count for g in range(count)]
    if kind == "pass through" and count == 3:  # the first goes through the one in the middle, who changes with the last
        goals = [2, 0, 1]
    lengths = chance.integers(2, 4, count)
    segments, formations = [], dict[str, Places]()

    def lead(name: str, first: int, last: int, box: Float64, at: int, measures: int) -> None:
        places = _places(chance, box, last - first)
        formations[name] = Places(name, places, np.zeros(last - first))
        segments.append(Segment(Evolve(name), f"{first + 1}-{last}", at, measures))

    if kind != "split and rejoin":
        for g in range(count):
            lead(f"goal {g}", bounds[g], bounds[g + 1], parts[goals[g]], 0, int(lengths[g]))
        return Case(kind, start, tuple(segments), Repertoire(formations), int(lengths.max()))
    half = int(bounds[0] + sizes[0] // 2)
    sides = _halves(parts[goals[0]])
    lead("one half", 0, half, sides[0], 0, 2)
    lead("other half", half, bounds[1], sides[1], 0, 2)
    for g in range(1, count):
        lead(f"goal {g}", bounds[g], bounds[g + 1], parts[goals[g]], 0, 2)
    lead("again", 0, bounds[1], parts[0], 2, 2)
    for g in range(1, count):
        lead(f"back {g}", bounds[g], bounds[g + 1], parts[g], 2, 2)
    return Case(kind, start, tuple(segments), Repertoire(formations), 4)


def _parts(count: int, turned: bool) -> list[Float64]:
    """Return the parts of the stage, each (2, 2): least and greatest x and z [m]."""
    x, z = WIDTH / 2, DEPTH / 2
    if count == 4:
        boxes = [(-x, -z, 0, 0), (0, -z, x, 0), (0, 0, x, z), (-x, 0, 0, z)]
    elif turned and count == 2:
        boxes = [(-x, -z, x, 0), (-x, 0, x, z)]
    else:
        lines = np.linspace(-x, x, count + 1)
        boxes = [(lines[g], -z, lines[g + 1], z) for g in range(count)]
    return [np.array(box, np.float64).reshape(2, 2) for box in boxes]


def _halves(box: Float64) -> tuple[Float64, Float64]:
    """Return the halves of a part of the stage, divided across its longer side."""
    axis = int(np.argmax(box[1] - box[0]))
    one, other = box.copy(), box.copy()
    one[1, axis] = other[0, axis] = box[:, axis].mean()
    return one, other


def _sizes(chance: np.random.Generator, count: int) -> list[int]:
    sizes = [DANCERS // count] * count
    sizes[-1] += DANCERS - sum(sizes)
    for g in range(1, count):
        moved = int(chance.integers(-2, 3))
        sizes[0] += moved
        sizes[g] -= moved
    return sizes


def _places(chance: np.random.Generator, box: Float64, count: int) -> Float64:
    """Return `count` places in a part of the stage: a grid, or darts at least `SPACING` apart."""
    low, high = box[0] + EDGE, box[1] - EDGE
    if chance.integers(2):
        size = high - low
        columns = max(1, min(count, round(math.sqrt(count * size[0] / size[1]))))
        rows = math.ceil(count / columns)
        x = np.linspace(low[0], high[0], columns) if columns > 1 else np.array([low[0] + size[0] / 2])
        z = np.linspace(low[1], high[1], rows) if rows > 1 else np.array([low[1] + size[1] / 2])
        return np.stack([np.tile(x, rows), np.repeat(z, columns)], axis=1)[:count]
    for _ in range(200):
        places = list[Float64]()
        for _ in range(2000):
            dart = chance.uniform(low, high)
            if all(math.dist(dart, place) >= SPACING for place in places):
                places.append(dart)
            if len(places) == count:
                return np.array(places)
    raise ValueError(f"{count} places do not fit into {box.tolist()}")


def ways_of(case: Case, *, apart: bool, sampled: bool = True) -> tuple[Float64, tuple[float, float]]:
    """Return the places of all at `MOMENTS` moments of each measure, (T, DANCERS, 2) [m], and the time and the
    processor time [s] of planning the slowest measure. `apart`: each segment has a plan that knows of no other."""
    roster, place, slowest = Roster.create(DANCERS), case.start.copy(), (0.0, 0.0)
    plans: list[Plan] = [] if apart else [_plan_of(roster, case, case.segments)]
    ways = list[Float64]()
    for measure in range(case.measures):
        fresh = [_plan_of(roster, case, [one]) for one in case.segments if one.start == measure] if apart else plans
        plans = [*plans, *fresh] if apart else plans
        began = time.perf_counter(), time.process_time()
        for plan in fresh:
            plan.begin_measure(measure, place, np.zeros(DANCERS))
            plan.finish()
        slowest = max(slowest, (time.perf_counter() - began[0], time.process_time() - began[1]))
        rows = range(MOMENTS + 1) if sampled else (MOMENTS,)
        there = np.array([_places_at(plans, (measure + row / MOMENTS) * BEATS, place) for row in rows])
        place = there[-1].copy()
        ways.append(there[:-1])
    return np.concatenate([*ways, place[None]]), slowest


def _plan_of(roster: Roster, case: Case, segments: Sequence[Segment]) -> Plan:
    return Plan(
        roster, case.repertoire, segments, measure_beats=BEATS, half=(WIDTH / 2, DEPTH / 2), radius=RADIUS, seed=0
    )


def _places_at(plans: Sequence[Plan], beat: float, place: Float64) -> Float64:
    now = place.copy()
    for plan in plans:
        state = plan.state_at(beat)
        led = state.controlled == 1
        now[led] = state.position[led]
    return now


def figures_of(ways: Float64) -> Figures:
    """Count overlaps and meetings on ways (T, D, 2) [m], exactly for straight motion between moments."""
    steps = np.diff(ways, axis=0)
    way = np.hypot(steps[..., 0], steps[..., 1])
    moving = way * MOMENTS / BEATS > MOVING
    overlaps = meetings = 0
    least = math.inf
    for first in range(ways.shape[1] - 1):
        apart = ways[:, first + 1 :] - ways[:, first : first + 1]
        begin, move = apart[:-1], np.diff(apart, axis=0)
        at = np.clip(-(begin * move).sum(-1) / np.maximum((move**2).sum(-1), 1e-18), 0.0, 1.0)
        gap = np.hypot(*np.moveaxis(begin + at[..., None] * move, -1, 0))
        least = min(least, float(gap.min()))
        overlaps += int((gap.min(axis=0) < 2 * RADIUS).sum())
        near = (gap < 2 * RADIUS + MEETING_GAP) & moving[:, first + 1 :] & moving[:, first : first + 1]
        meetings += int(near[0].sum() + (near[1:] & ~near[:-1]).sum())
    return Figures(overlaps, meetings, float(way.sum()), least, float(way.max() * MOMENTS / BEATS))
