"""Dry run of a plan without steering: reports distances that are too far, near misses and the timeline (T088)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.collision_check import TOLERANCE
from live.agents.evolutions.evolution_kernels import longest_moves, nearest_approach
from live.agents.evolutions.intention import Repertoire, Segment
from live.agents.evolutions.running_plan import Plan
from live.agents.evolutions.timeline import Link, Span, link_timeline
from live.agents.groups.roster import Roster
from live.base.arrays import Float32, Float64

SAMPLES_PER_MEASURE = 32
"""Samples per measure."""
NOBODY_MOVED: Mapping[int, tuple[npt.NDArray[np.bool_], Float32]] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class TooFar:
    """A dancer (index) who would have to travel farther in a measure (index) than their steps allow."""

    dancer: int
    measure: int
    distance: float
    """Metres."""
    reach: float
    """Metres."""


@dataclass(frozen=True, slots=True)
class TooNear:
    """Two dancers (indices), of one or two groups, who would collide in a measure (index) without steering."""

    first: int
    second: int
    measure: int
    distance: float
    """Metres between their centres."""


@dataclass(frozen=True, slots=True, eq=False)
class DryRunResult:
    """Result of a dry run for A dancers and M measures."""

    places: Float32
    """Places at the measure lines [m], shape (M + 1, A, 2)."""
    headings: Float32
    """Headings at the measure lines [rad], shape (M + 1, A)."""
    under: npt.NDArray[np.bool_]
    """Whether a segment controls the dancer at the end of each measure, shape (M, A)."""
    too_near: tuple[TooNear, ...]
    """Pairs under segments who would collide; steering has to keep them apart."""
    links: tuple[Link, ...]
    """The linked timeline (T089)."""
    ways: Float32
    """Places `SAMPLES_PER_MEASURE` times in each measure [m], shape (S M, A, 2); (0, A, 2) if they were not kept."""

    @property
    def distances(self) -> Float64:
        """Return the distance between the places at both ends of each measure [m], shape (M, A)."""
        steps = np.diff(self.places.astype(np.float64), axis=0)
        return np.asarray(np.hypot(steps[..., 0], steps[..., 1]))

    def too_far(self, reach: npt.ArrayLike) -> tuple[TooFar, ...]:
        """Return the dancers who would be late; `reach` [m]: how far steps travel in a measure, (A,) or one for all."""
        most = np.broadcast_to(np.asarray(reach, np.float64), self.under.shape)
        ways = np.where(self.under, self.distances, 0.0)
        return tuple(
            TooFar(int(dancer), int(measure), float(ways[measure, dancer]), float(most[measure, dancer]))
            for measure, dancer in np.argwhere(ways > most + 1e-9)
        )


def simulate_plan(
    roster: Roster,
    repertoire: Repertoire,
    segments: Sequence[Segment],
    positions: npt.ArrayLike,
    *,
    measures: int,
    headings: npt.ArrayLike = 0.0,
    measure_beats: float = 4.0,
    half: tuple[float, float] = (6.0, 4.0),
    radius: npt.ArrayLike = 0.25,
    seed: int = 0,
    keep_ways: bool = False,
    moved: Mapping[int, tuple[npt.NDArray[np.bool_], Float32]] = NOBODY_MOVED,
    available: npt.NDArray[np.bool_] | None = None,
) -> DryRunResult:
    """Run `measures` measures from `positions` (A, 2) [m]. `available` (A,): who is on the stage; None: everybody.

    Segments that begin together are planned together (T147). Dancers moved by elements are assumed to stay, unless
    `moved` tells who of them, (A,), stands where, (A, 2) [m], at the line of a measure (from 0).
    """
    plan = Plan(roster, repertoire, segments, measure_beats=measure_beats, half=half, radius=radius, seed=seed)
    if available is not None:
        plan.available = available
    place = np.array(positions, np.float32)
    facing = np.array(np.broadcast_to(np.asarray(headings, np.float32), (roster.count,)))
    places, faced = [place.copy()], [facing.copy()]
    held: list[npt.NDArray[np.bool_]] = []
    near: list[TooNear] = []
    ways = [np.zeros((0, roster.count, 2), np.float32)]
    spans: dict[int, Span] = {}
    bodies = np.broadcast_to(np.asarray(radius, np.float64), (roster.count,))
    for measure in range(measures):
        if measure in moved:
            who, elsewhere = moved[measure]
            places[-1] = place = np.where(who[:, None], elsewhere, place)
            plan.release(who)
            if held:  # not a segment has led them there
                held[-1] = held[-1] & ~who
        for motion in plan.begin_measure(measure, place, facing):
            dancers = np.zeros(roster.count, np.bool_)
            dancers[motion.dancers] = True
            spans[plan.segments.index(motion.segment)] = Span(motion.begin, motion.departure.end, dancers)
        plan.finish()
        sample, under = _sampled(plan, measure, measure_beats, place)
        near += _too_near(sample, under, measure, bodies)
        if keep_ways:
            ways.append(sample[:-1])
        there = plan.predicted_state((measure + 1) * measure_beats)
        under = there.controlled == 1
        place, facing = np.where(under[:, None], there.position, place), np.where(under, there.heading, facing)
        places.append(place.copy())
        faced.append(facing.copy())
        held.append(under)
    links = _links(spans, roster.count, measures * measure_beats)
    return DryRunResult(np.array(places), np.array(faced), np.array(held), tuple(near), links, np.concatenate(ways))


def _links(spans: dict[int, Span], dancers: int, length: float) -> tuple[Link, ...]:
    """Return the linked timeline; its sources are indices of the plan's segments."""
    order = sorted(spans)
    links = link_timeline([spans[index] for index in order], dancers, length)
    return tuple(
        Link(link.begin, link.end, link.dancers, order[link.source] if link.source >= 0 else link.source,
             link.before, link.after)
        for link in links
    )  # fmt: skip


def _sampled(plan: Plan, measure: int, measure_beats: float, place: Float32) -> tuple[Float32, npt.NDArray[np.bool_]]:
    """Return the places within a measure, (S + 1, A, 2) [m], and who is under a segment at its end, (A,)."""
    sample = np.empty((SAMPLES_PER_MEASURE + 1, len(place), 2), np.float32)
    under = np.zeros(len(place), np.bool_)
    for row in range(SAMPLES_PER_MEASURE + 1):
        there = plan.state_at((measure + row / SAMPLES_PER_MEASURE) * measure_beats)
        under = there.controlled == 1
        sample[row] = np.where(under[:, None], there.position, place)
    return sample, under


def _too_near(sample: Float32, under: npt.NDArray[np.bool_], measure: int, bodies: Float64) -> list[TooNear]:
    count = sample.shape[1]
    distance, when = np.empty((count, count), np.float32), np.empty((count, count), np.float32)
    least = bodies[:, None] + bodies[None, :] - TOLERANCE
    step = np.zeros(count)
    longest_moves(sample, 0, count, step)
    nearest_approach(sample, step, float(least.max(initial=0.0)), 0, count, distance, when)
    meet = (distance < least) & under[:, None] & under[None, :]
    return [TooNear(int(i), int(j), measure, float(distance[i, j])) for i, j in np.argwhere(np.triu(meet, 1))]
