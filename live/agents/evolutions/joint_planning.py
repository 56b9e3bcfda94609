"""Joint planning: the ways of groups that move in the same measures are reshaped together (T147, Schulz 2011, 6.2).

Each segment is planned for itself first. Here the ways of all dancers of the segments that begin together are sampled
at even times, together with those of everybody whom an earlier segment moves or holds, who stay as they are. Where two
would come too near, both are shifted apart, across the direction between them at their nearest approach; shifts are
smooth over time. Two wishes are met one after the other:

- no *meeting*: two dancers come nearer than `MEETING_GAP` between their bodies while both are under way. On straight
  ways between formations 1 m apart two dancers of one group do not (CAPT: 1 / √2 of the spacing);
- no *overlap*: bodies never touch.

Dancers of one group keep the distances of their own plan. Those on drawn lines give way less than others; those who
pause or whose segment has straight ways do not. The result depends on the dancers' numbers, not on the order of the
segments.

The thesis names the idea only: paths reshaped to avoid collisions between dancers of different subgroups. Divide and
conquer (T101) shifts one pair at one time after the other; for whole groups that cross, this is done for all
encounters at once, as in position-based dynamics (Müller et al. 2007), with shifts that are smoothed over time.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.evolutions.evolution_kernels import longest_moves, nearest_approach
from live.agents.evolutions.facing import Facing, final_direction, with_turns
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import Evolve, FollowWays, Hold, PathMode, Pause, Trajectory
from live.agents.evolutions.joint_kernels import apply_shifts, shift_encounters
from live.agents.evolutions.planned_segment import PlannedSegment
from live.agents.evolutions.segment_start import PlannedMotion
from live.agents.evolutions.trajectory import GroupState, Locomotion
from live.base.arrays import Bool, Float32, Float64, Int32, Int64

MEETING_GAP: Final = 0.2
"""Two dancers meet if their bodies come nearer than this while both are under way [m]."""
SOFT_MARGIN: Final = 0.05
"""Metres beyond the gap of a meeting that ways are planned with."""
BODY_MARGIN: Final = 0.08
"""Metres between bodies that ways are planned with where there is no room for more; some is lost between times."""
SETTLED: Final = 0.02
"""Metres that a pair may lack without another round, while meetings are avoided."""
BODY_SETTLED: Final = 0.05
"""The same, while overlaps are avoided."""
STEPS: Final = 32
"""Times in the shortest segment."""
MAX_STEPS: Final = 256
MAX_JOINT_DANCERS: Final = 300
"""With more dancers than this, nothing is planned together: steering keeps them apart."""
DRAWN_GIVE: Final = 0.25
"""How much of a shift a dancer on a drawn line takes; all others take 1."""
HELD: Final = 0.01
"""Someone who moves less than this [m] stands."""
LEAN: Final = 0.03
"""Metres that a shift may grow by, from one time to the next, more than before."""
PAIRS_PER_PIECE: Final = 64_000
"""Pairs, times the moments, in one piece of work: half a millisecond, as most moments are skipped."""
BEATS_PER_PIECE: Final = 16
"""Moments that are sampled in one piece of work."""


@dataclass(frozen=True, slots=True)
class _Stage:
    """Rounds of shifts of one kind."""

    meetings: bool
    """Whether dancers avoid meetings, or overlaps only."""
    reach: float
    """Times over which a shift is smoothed."""
    gain: float
    """Factor of shifts: smoothing makes them smaller."""
    rounds: int
    """Maximum number of rounds; it ends when nobody is too near."""
    ease: float
    """How much displacements are stiffened in a round."""


STAGES: Final = (
    _Stage(True, 4.0, 3.0, 40, 0.06),
    _Stage(True, 3.0, 3.0, 40, 0.02),
    _Stage(False, 2.0, 2.0, 60, 0.005),
    _Stage(False, 6.0, 3.0, 20, 0.03),
    _Stage(False, 2.0, 2.0, 60, 0.0),
)
"""From wide, stiff shifts to narrow ones; the last two are for the few cases that the first three leave open."""


@dataclass(slots=True, eq=False)
class _Ways:
    """The ways of D dancers at K even times."""

    beats: Float64
    """Beats of the times, (K,)."""
    dancers: Int64
    """Indices among all dancers, in ascending order, (D,)."""
    party: Int64
    """Index of the segment that moves each dancer; -1: an earlier one, and the way stays as it is, (D,)."""
    way: Float64
    """Places [m], (D, K, 2)."""
    free: Int64
    """Times between which each dancer is under way, (D, 2)."""
    give: Float64
    """How much of a shift each takes, (D,)."""
    bodies: Float64
    """Sum of the radii of each pair [m], (D, D)."""


class JointPlanning:
    """The joint planning of segments that begin together: call `work` until `done`."""

    def __init__(
        self, motions: Sequence[PlannedSegment], *, radius: Float64, fill: Callable[[float, GroupState], GroupState]
    ) -> None:
        """`radius` (A,) [m] of bodies; `fill` writes where all segments of the plan, these included, have the dancers
        at a beat into a state of A dancers, and returns it."""
        self.motions = tuple(motions)
        self.held_until: float | None = None
        """Beat until which ways stay as they are; None: from their beginning on they are reshaped."""
        self.started = False
        self.done = False
        self._hurry = False
        self._radius, self._fill = radius, fill
        self._pieces = self._plan()

    @property
    def ready(self) -> bool:
        """Whether all its segments are planned."""
        return all(motion.done for motion in self.motions)

    def work(self) -> None:
        """Do one piece of planning, about half a millisecond."""
        self.started = True
        if next(self._pieces, self) is self:
            self.done = True

    def finish(self) -> None:
        """Complete the planning."""
        while not self.done:
            self.work()

    def stop(self) -> None:
        """End soon with what has been found."""
        self._hurry = True

    def _moving(self) -> list[PlannedSegment]:
        """Return the segments that have ways."""
        return [motion for motion in self.motions if motion.motion is not None and motion.motion.locomotion.count]

    def _plan(self) -> Pieces[None]:
        ways = yield from self._sample()
        if ways is None:
            return
        rest = ways.way.copy()
        sample = np.ascontiguousarray(rest.transpose(1, 0, 2), np.float32)
        nearest = yield from _nearest(sample, float(ways.bodies.max()) + MEETING_GAP + SOFT_MARGIN)
        soft, hard = _distances_to_keep(ways, nearest, self._drawn(ways))
        if not (nearest < soft).any():
            return
        yield from self._separate(ways, rest, soft, hard)
        yield from self._accept(ways, hard, soft, nearest)

    def _sample(self) -> Pieces[_Ways | None]:
        """Sample the ways of all dancers who take part; None if there is nothing to plan together."""
        moving = self._moving()
        if not moving:
            return None
        spans = [(motion.motion.locomotion.begin, motion.motion.locomotion.end) for motion in moving if motion.motion]
        begin, end = min(span[0] for span in spans), max(span[1] for span in spans)
        shortest = min((last - first for first, last in spans if last > first), default=0.0)
        if shortest <= 0.0:
            return None
        steps = min(MAX_STEPS, int(np.ceil((end - begin) / shortest * STEPS - 1e-9)))
        beats = np.linspace(begin, end, steps + 1)
        count = len(self._radius)
        party, free = np.full(count, -1), np.zeros((count, 2), np.int64)
        give, start = np.zeros(count), np.zeros((count, 2), np.float32)
        own = np.zeros(count, np.bool_)
        scale = steps / (end - begin)
        for index, motion in enumerate(moving):
            assert motion.motion is not None  # checked above
            locomotion, rows = motion.motion.locomotion, np.flatnonzero(motion.controlled)
            who = motion.dancers[rows]
            twice = who[own[who] & (motion.begin > begin)]  # led by two of the segments, one after the other
            start[who] = np.where(own[who][:, None], start[who], locomotion.path_knots[rows, 0])
            first = int(np.ceil((locomotion.begin - begin) * scale - 1e-9))
            if self.held_until is not None:
                first = max(first, int(np.ceil((self.held_until - begin) * scale - 1e-9)))
            last = int(np.floor((locomotion.end - begin) * scale + 1e-9))
            party[who], free[who], give[who] = index, (min(first, last), last), _give_of(motion)
            party[twice], give[twice] = -1, 0.0
            own[who] = True
        state = GroupState(count)
        places, known = np.zeros((steps + 1, count, 2), np.float32), np.ones(count, np.bool_)
        for row, beat in enumerate(beats):
            self._fill(float(beat), state)
            led = state.controlled == 1
            places[row] = np.where(led[:, None], state.position, start)
            known &= led | own
            if row % BEATS_PER_PIECE == BEATS_PER_PIECE - 1:
                yield
        if not own.any():
            return None
        known &= _comes_near(places, own, float(self._radius.max()))
        dancers = np.flatnonzero(known)
        if len(dancers) > MAX_JOINT_DANCERS or len(set(party[dancers].tolist())) < 2 or not give[dancers].any():
            return None
        bodies = self._radius[dancers]
        return _Ways(
            beats, dancers, party[dancers], np.ascontiguousarray(places[:, dancers].transpose(1, 0, 2), np.float64),
            np.ascontiguousarray(free[dancers]), give[dancers], bodies[:, None] + bodies[None, :],
        )  # fmt: skip

    def _drawn(self, ways: _Ways) -> Bool:
        """Whether each dancer follows a drawn line, or a way that was drawn or recorded, (D,)."""
        drawn = [isinstance(motion.intention, Trajectory | FollowWays) for motion in self._moving()]
        return np.array([party >= 0 and drawn[party] for party in ways.party], np.bool_)

    def _separate(self, ways: _Ways, rest: Float64, soft: Float64, hard: Float64) -> Pieces[None]:
        """Shift the ways until nobody is too near, or the rounds are over."""
        count, times = ways.way.shape[:2]
        shift, added, work = np.zeros_like(ways.way), np.zeros((count, times)), np.zeros((3, times))
        pieces = _row_pieces(count, times)
        half_x, half_z = self._half()
        for stage in STAGES:
            keep = soft if stage.meetings else hard
            slope = 2.0 * float(keep.max()) / times
            for _ in range(stage.rounds):
                if self._hurry:
                    return
                stride = np.sqrt((np.diff(ways.way, axis=1) ** 2).sum(axis=2).max(axis=1))
                found = 0
                for first, last in pieces:
                    found += shift_encounters(
                        ways.way, keep, slope, SETTLED if stage.meetings else BODY_SETTLED, stride, ways.give,
                        ways.free, half_x, half_z, first, last, shift, added,
                    )  # fmt: skip
                    yield
                apply_shifts(
                    shift, added, ways.free, rest, stage.reach, stage.gain, stage.ease, LEAN, half_x, half_z, work,
                    ways.way,
                )  # fmt: skip
                if not found:
                    break

    def _half(self) -> tuple[float, float]:
        """Return the half sizes of the stage that the middle of a body keeps within [m]."""
        half, body = self.motions[0].departure.half_stage, float(self._radius.max())
        return max(half[0] - body, 0.0), max(half[1] - body, 0.0)

    def _accept(self, ways: _Ways, hard: Float64, soft: Float64, before: Float32) -> Pieces[None]:
        """Give the new ways to the segments, if fewer dancers overlap on them, or as few overlap and fewer meet."""
        moving = self._moving()
        planned: list[PlannedMotion] = []
        fine = np.linspace(ways.beats[0], ways.beats[-1], 2 * len(ways.beats) - 1)
        sample = np.ascontiguousarray(
            _between(ways.way, np.linspace(0.0, len(ways.beats) - 1.0, len(fine))), np.float32
        )
        sample = np.ascontiguousarray(sample.transpose(1, 0, 2))
        for index, motion in enumerate(moving):
            rows = np.flatnonzero((ways.party == index) & (ways.give > 0.0))
            fresh = _reshaped(motion, ways, rows)
            planned.append(fresh)
            yield
            for row, beat in enumerate(fine):
                if motion.begin <= beat:
                    state = GroupState(fresh.locomotion.count)
                    fresh.locomotion.evaluate(float(beat), state)
                    sample[row, rows] = state.position[np.searchsorted(motion.dancers, ways.dancers[rows])]
                if row % BEATS_PER_PIECE == BEATS_PER_PIECE - 1:
                    yield
        after = yield from _nearest(sample, float(ways.bodies.max()) + MEETING_GAP + SOFT_MARGIN)
        if _badness(after, ways, hard, soft) < _badness(before, ways, hard, soft):
            for motion, fresh in zip(moving, planned, strict=True):
                motion.reshape(fresh)


def _give_of(motion: PlannedSegment) -> float:
    """Return how much of a shift the dancers of a segment take."""
    match motion.intention:
        case Evolve(path_mode=PathMode.STRAIGHT) | Pause():
            return 0.0
        case Evolve() | Hold():
            return 1.0
        case _:
            return DRAWN_GIVE


def _comes_near(places: Float32, own: Bool, body: float) -> Bool:
    """Return which dancers, on `places` (K, A, 2) [m], are among the `own` ones, or somewhere near their ways, (A,)."""
    room = 2.0 * body + 4.0 * MEETING_GAP
    low, high = places[:, own].min(axis=(0, 1)) - room, places[:, own].max(axis=(0, 1)) + room
    return np.asarray(own | ((places >= low) & (places <= high)).all(axis=2).any(axis=0))


def _row_pieces(count: int, times: int) -> list[tuple[int, int]]:
    """Return first and last row (not included) of the pieces in which all pairs of `count` dancers are looked at."""
    done = np.cumsum(np.arange(count - 1, -1, -1)) * times  # with all rows up to this one
    number = max(1, -(-int(done[-1]) // PAIRS_PER_PIECE)) if count else 0
    ends = np.searchsorted(done, done[-1] * np.arange(1, number) / number) + 1 if number else np.zeros(0, np.int64)
    edges = [0, *ends.tolist(), count]
    return [(first, last) for first, last in pairwise(edges) if first < last]


def _nearest(sample: Float32, reach: float) -> Pieces[Float32]:
    """Compute how near each pair comes on `sample` (K, D, 2) [m], exact below `reach` [m], (D, D)."""
    times, count = sample.shape[:2]
    distance, when = np.full((2, count, count), np.inf, np.float32)
    step = np.zeros(count)
    longest_moves(sample, 0, count, step)
    rows = max(1, 2 * PAIRS_PER_PIECE // (count * times))
    for first in range(0, count, rows):
        nearest_approach(sample, step, reach, first, min(first + rows, count), distance, when)
        yield
    return distance


def _distances_to_keep(ways: _Ways, nearest: Float32, drawn: Bool) -> tuple[Float64, Float64]:
    """Return the distance of each pair without a meeting, and without an overlap [m], (D, D); 0: nobody looks.

    Dancers of one group keep what their own plan has. Those who stand nearer both before and after, such as partners,
    stay as near; someone who stands all the time, or two on drawn lines, cannot be met.
    """
    hard = ways.bodies + BODY_MARGIN
    soft = ways.bodies + MEETING_GAP + SOFT_MARGIN
    one, other = ways.party[:, None], ways.party[None, :]
    first, last = (np.hypot(*np.moveaxis(ways.way[:, None, k] - ways.way[None, :, k], -1, 0)) for k in (0, -1))
    ends = np.maximum(first, last)
    stands = np.ptp(ways.way, axis=1).max(axis=1) < HELD
    plain = (drawn[:, None] & drawn[None, :]) | stands[:, None] | stands[None, :]
    soft = np.where((one == other) & (one >= 0), np.clip(nearest, hard, soft), soft)
    soft = np.where(plain, hard, np.minimum(soft, np.maximum(ends, hard)))
    nobody = (ends < hard) | ((ways.give[:, None] + ways.give[None, :]) <= 0.0)
    np.fill_diagonal(nobody, True)
    return np.where(nobody, 0.0, soft), np.where(nobody, 0.0, hard)


def _badness(nearest: Float32, ways: _Ways, hard: Float64, soft: Float64) -> tuple[int, int]:
    """Return how many pairs overlap, and how many are nearer than they should be."""
    looked = hard > 0.0
    return int((looked & (nearest < ways.bodies)).sum()), int((looked & (nearest < soft - 2.0 * SOFT_MARGIN)).sum())


def _between(way: Float64, at: Float64) -> Float64:
    """Return the places at the times `at` (T,) of ways (D, K, 2) [m] on a Catmull-Rom spline, as a locomotion's."""
    last = way.shape[1] - 1
    k = np.clip(at.astype(np.int64), 0, last - 1)
    u = (at - k)[None, :, None]
    padded = np.concatenate([2.0 * way[:, :1] - way[:, 1:2], way, 2.0 * way[:, -1:] - way[:, -2:-1]], axis=1)
    p0, p1, p2, p3 = (padded[:, k + n] for n in range(4))
    cubic = p0 - 2.5 * p1 + 2.0 * p2 - 0.5 * p3 + u * (1.5 * (p1 - p2) + 0.5 * (p3 - p0))
    return np.asarray(p1 + u * (0.5 * (p2 - p0) + u * cubic))


def _reshaped(motion: PlannedSegment, ways: _Ways, rows: npt.NDArray[np.intp]) -> PlannedMotion:
    """Return the plan of a segment with the new ways of the dancers of `rows`; those of others stay."""
    former = motion.motion
    assert former is not None  # only planned segments are sampled
    if not len(rows):
        return former
    old, begin, end = former.locomotion, former.locomotion.begin, former.locomotion.end
    steps = round((end - begin) / (ways.beats[1] - ways.beats[0]))
    knots = max(2, steps + 1, old.path_knots.shape[1] if old.ramp == 0.0 else 2)
    beats = np.linspace(begin, end, knots)
    places = np.ascontiguousarray(old.sample(beats)[0].transpose(1, 0, 2))
    at = np.clip((beats - ways.beats[0]) / (ways.beats[-1] - ways.beats[0]) * (len(ways.beats) - 1), 0, None)
    own: Int32 = np.searchsorted(motion.dancers, ways.dancers[rows]).astype(np.int32)
    fresh = _between(ways.way[rows], np.minimum(at, len(ways.beats) - 1.0))
    places[own, 1:-1] = fresh[:, 1:-1]
    times = np.repeat(np.array([[begin, end]]), old.count, axis=0)
    moved: Locomotion = replace(old, path_knots=np.ascontiguousarray(places, np.float32), times=times, ramp=0.0)
    planned = replace(former, locomotion=moved, bent=True)
    if isinstance(motion.intention, Evolve | Hold):
        facing = motion.intention.orientation if isinstance(motion.intention, Evolve) else None
        after, exact = old.turns[:, -1, 1], True
    elif isinstance(motion.intention, Trajectory | FollowWays):
        facing, exact = motion.intention.orientation, False
        after = final_direction(moved.path_knots, motion.departure.heading)
    else:
        return planned
    if facing is None or facing.facing not in (Facing.TANGENT, Facing.MEASURES):
        return planned
    return with_turns(planned, facing, motion.departure, after, exact_end=exact)
