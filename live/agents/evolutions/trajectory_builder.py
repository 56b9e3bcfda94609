"""Planner from an intention to a locomotion: slots, paths, times and headings of each dancer (T085, T096-T103)."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions import paths
from live.agents.evolutions.collision_check import RepairResult, repair_in_pieces
from live.agents.evolutions.facing import Facing, Orientation, final_direction, linear_turns, turn_beats, with_turns
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import (
    Evolve,
    FollowMode,
    FollowWays,
    FormationLike,
    Hold,
    Intention,
    PathMode,
    Repertoire,
    Segment,
    Trajectory,
)  # fmt: skip
from live.agents.evolutions.segment_start import MotionDraft, PlannedMotion, SegmentStart
from live.agents.evolutions.slot_layout import assign_places
from live.agents.evolutions.start_delays import Arrival, delays, limit_delays, start_and_arrival
from live.agents.evolutions.trajectory import Locomotion
from live.agents.groups.roster import mirror_headings, mirror_places
from live.base.arrays import Float32, Float64

MAX_CHECKED_DANCERS = 300
"""Larger groups are not checked for clearance; steering keeps them apart."""
APPROACH_MEASURES = 1.0
"""Dancers who are elsewhere come to their ways within so many measures, at most half of the time."""


def plan_segment(
    segment: Segment, intention: Intention, repertoire: Repertoire, departure: SegmentStart, draft: MotionDraft
) -> Pieces[PlannedMotion]:
    """Plan a segment whose intention prescribes places (all but `Procedural`), in pieces; `draft` is set first."""
    if isinstance(intention, Hold):
        formation = repertoire.formation(intention.formation, len(departure.dancer_indices))
        soon = replace(departure, end=min(departure.end, departure.begin + departure.measure_beats))
        return (yield from _evolve(segment, Evolve(intention.formation, intention.matching), formation, soon, draft))
    if isinstance(intention, Evolve):
        formation = repertoire.formation(intention.formation, len(departure.dancer_indices))
        return (yield from _evolve(segment, intention, formation, departure, draft))
    if isinstance(intention, Trajectory):
        return (yield from _trajectory(segment, intention, repertoire.path(intention.path), departure, draft))
    if isinstance(intention, FollowWays):
        return (yield from _follow_ways(segment, intention, repertoire, departure, draft))
    return _pause(departure)


def _pause(departure: SegmentStart) -> PlannedMotion:
    count = len(departure.dancer_indices)
    stays = start_and_arrival(departure.begin, departure.end, np.zeros(count))
    turns = linear_turns(stays, departure.heading, departure.heading)
    ways = paths.straight_paths(departure.position, departure.position)
    return PlannedMotion(Locomotion(ways, stays, turns), np.full(count, -1, np.int32))


def _evolve(
    segment: Segment, evolve: Evolve, formation: FormationLike, departure: SegmentStart, draft: MotionDraft
) -> Pieces[PlannedMotion]:
    slots = np.asarray(formation.slots, np.float64).reshape(-1, 2)
    facing = np.asarray(formation.heading, np.float64).reshape(-1)
    if segment.mirror is not None:
        slots, facing = mirror_places(slots, segment.mirror), mirror_headings(facing, segment.mirror)
    slot, places = yield from assign_places(evolve.matching, slots, formation.marks, departure, draft)
    goal = places[slot]
    after = np.concatenate([facing, np.zeros(len(places) - len(facing))])[slot]
    slot = np.where(slot < len(slots), slot, -1).astype(np.int32)
    ways = paths.straight_paths(departure.position, goal)
    timing = _timing(segment, ways, evolve.soft, evolve.orientation, departure, exact_end=True)
    rough = with_turns(timing.journey(), evolve.orientation, departure, after, exact_end=True)
    draft.motion = replace(rough, slot=slot)
    yield
    moved = yield from _repaired(segment, timing, evolve.path_mode, departure)
    journey = with_turns(moved, evolve.orientation, departure, after, exact_end=True)
    return replace(journey, slot=slot)


def _trajectory(
    segment: Segment,
    trajectory: Trajectory,
    polyline: npt.NDArray[np.floating],
    departure: SegmentStart,
    draft: MotionDraft,
) -> Pieces[PlannedMotion]:
    line = np.asarray(polyline, np.float64)
    if segment.mirror is not None:
        line = mirror_places(line, segment.mirror)
    together = trajectory.follow is FollowMode.FILE  # in single file all have to move at the same time
    if together:
        ways = paths.single_file(line, departure.position, gap=trajectory.gap)
        segment = replace(segment, ripple=replace(segment.ripple, beats=0.0))
    else:
        ways = paths.parallel_paths(line, departure.position)
    facing = trajectory.orientation
    after = departure.heading
    if facing.facing in (Facing.TANGENT, Facing.MEASURES):
        after = final_direction(ways, departure.heading)
    timing = _timing(segment, ways, trajectory.soft, facing, departure, exact_end=False)
    draft.motion = with_turns(timing.journey(), facing, departure, after, exact_end=False)
    yield
    moved = yield from _repaired(segment, timing, PathMode.STRAIGHT, departure)
    return with_turns(moved, facing, departure, after, exact_end=False)


def _follow_ways(
    segment: Segment, follow: FollowWays, repertoire: Repertoire, departure: SegmentStart, draft: MotionDraft
) -> Pieces[PlannedMotion]:
    ways, slot = yield from _paths_to_ways(segment, follow, repertoire.ways_of(follow.ways), departure, draft)
    segment = replace(segment, ripple=replace(segment.ripple, arrive=Arrival.APART))  # in canon nobody hurries
    facing, after = follow.orientation, departure.heading
    if facing.facing in (Facing.TANGENT, Facing.MEASURES):
        after = final_direction(ways, departure.heading)
    timing = _timing(segment, ways, 0.0, facing, departure, exact_end=False)
    rough = with_turns(timing.journey(), facing, departure, after, exact_end=False)
    draft.motion = replace(rough, slot=slot)
    yield
    moved = yield from _repaired(segment, timing, PathMode.DIVIDED, departure)
    return replace(with_turns(moved, facing, departure, after, exact_end=False), slot=slot)


@dataclass(frozen=True, slots=True, eq=False)
class _Timing:
    """Paths with their times before collision repair, without turns."""

    locomotion: Locomotion
    waits: Float64
    begin: float
    end: float

    def journey(self) -> PlannedMotion:
        """Return the paths as a journey that has not been checked for collisions."""
        return PlannedMotion(self.locomotion, np.full(self.locomotion.count, -1, np.int32), checked=False)


def _timing(
    segment: Segment, ways: Float32, soft: float, facing: Orientation, departure: SegmentStart, *, exact_end: bool
) -> _Timing:
    """Return when each dancer is under way. `exact_end`: leave time for the last turn."""
    begin, end = departure.begin, departure.end
    turn = turn_beats(facing, departure)
    begin, end = begin + turn, end - (turn if exact_end else 0.0)
    waits = limit_delays(
        delays(segment.ripple, departure.position, departure.dancer_indices, seed=departure.seed), end - begin
    )
    own = start_and_arrival(begin, end, waits, segment.ripple.arrive)
    still = linear_turns(own, departure.heading, departure.heading)
    return _Timing(Locomotion(ways, own, still, soft), waits, begin, end)


def _repaired(segment: Segment, timing: _Timing, path_mode: PathMode, departure: SegmentStart) -> Pieces[PlannedMotion]:
    """Return the path with its times, repaired as far as `path_mode` asks; no turns yet."""
    locomotion, waits = timing.locomotion, timing.waits
    if locomotion.count > MAX_CHECKED_DANCERS:
        return timing.journey()
    result: RepairResult = yield from repair_in_pieces(
        locomotion,
        departure.radius,
        waits,
        begin=timing.begin,
        end=timing.end,
        arrive=segment.ripple.arrive if waits.any() else Arrival.TOGETHER,
        retime=path_mode is PathMode.MENDED,
        bend=path_mode is not PathMode.STRAIGHT,
        seed=departure.seed,
        half=departure.half_stage,
    )
    nothing = np.full(locomotion.count, -1, np.int32)
    return PlannedMotion(result.locomotion, nothing, result.retimed, result.bent, result.remaining)


def _paths_to_ways(
    segment: Segment,
    follow: FollowWays,
    ways: npt.NDArray[np.floating],
    departure: SegmentStart,
    draft: MotionDraft,
) -> Pieces[tuple[Float32, npt.NDArray[np.int32]]]:
    """Return the paths [m] of dancers who follow ways that were drawn or recorded (T145, T146), (D, K, 2) at even
    times, and the way of each, (D,), -1 for none.

    Each begins where she is, and comes to her way early in the segment. Whoever has no way goes to the edge.
    """
    lines = np.asarray(ways, np.float64)
    if follow.backwards:
        lines = lines[:, ::-1]
    if segment.mirror is not None:
        lines = mirror_places(lines, segment.mirror)
    slot, places = yield from assign_places(follow.matching, lines[:, 0], (), departure, draft)
    waiting = np.repeat(places[len(lines) :, None], lines.shape[1], axis=1)
    paths = np.concatenate([lines, waiting])[slot]
    away: Float64 = departure.position - paths[:, 0]
    length = max(departure.end - departure.begin, 1e-9)
    approach = min(APPROACH_MEASURES * departure.measure_beats / length, 0.5)
    share = np.clip(np.linspace(0.0, 1.0, lines.shape[1]) / approach, 0.0, 1.0)
    left = 1.0 - share * share * (3.0 - 2.0 * share)
    paths = paths + left[None, :, None] * away[:, None]
    return np.ascontiguousarray(paths, np.float32), np.where(slot < len(lines), slot, -1).astype(np.int32)
