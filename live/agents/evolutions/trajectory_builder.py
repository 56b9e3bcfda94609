"""Planner from an intention to a locomotion: slots, paths, times and headings of each dancer (T085, T096-T103)."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions import paths
from live.agents.evolutions.collision_check import Mended, mending
from live.agents.evolutions.facing import Facing, Orientation, final_direction, linear, turn_beats, turned
from live.agents.evolutions.incremental_assignment import Pieces
from live.agents.evolutions.intention import (
    Evolve,
    Follow,
    FormationLike,
    Hold,
    Intention,
    Repertoire,
    Segment,
    Trajectory,
    Way,
)  # fmt: skip
from live.agents.evolutions.segment_start import Departure, Draft, Journey
from live.agents.evolutions.slot_layout import seated
from live.agents.evolutions.start_delays import Arrive, delays, squeezed, times
from live.agents.evolutions.trajectory import Float32, Float64, Locomotion
from live.agents.groups.roster import mirrored, mirrored_heading

CHECKED = 300
"""Larger groups are not checked for clearance; steering keeps them apart."""


def travelling(
    segment: Segment, intention: Intention, repertoire: Repertoire, departure: Departure, draft: Draft
) -> Pieces[Journey]:
    """Plan a segment whose intention prescribes places (all but `Procedural`), in pieces; `draft` is set first."""
    if isinstance(intention, Hold):
        formation = repertoire.formation(intention.formation, len(departure.numbers))
        soon = replace(departure, end=min(departure.end, departure.begin + departure.measure_beats))
        return (yield from _evolve(segment, Evolve(intention.formation, intention.matching), formation, soon, draft))
    if isinstance(intention, Evolve):
        formation = repertoire.formation(intention.formation, len(departure.numbers))
        return (yield from _evolve(segment, intention, formation, departure, draft))
    if isinstance(intention, Trajectory):
        return (yield from _trajectory(segment, intention, repertoire.path(intention.path), departure, draft))
    return _pause(departure)


def _pause(departure: Departure) -> Journey:
    count = len(departure.numbers)
    stays = times(departure.begin, departure.end, np.zeros(count))
    turns = linear(stays, departure.heading, departure.heading)
    ways = paths.straight(departure.position, departure.position)
    return Journey(Locomotion(ways, stays, turns), np.full(count, -1, np.int32))


def _evolve(
    segment: Segment, evolve: Evolve, formation: FormationLike, departure: Departure, draft: Draft
) -> Pieces[Journey]:
    slots = np.asarray(formation.slots, np.float64).reshape(-1, 2)
    facing = np.asarray(formation.heading, np.float64).reshape(-1)
    if segment.mirror is not None:
        slots, facing = mirrored(slots, segment.mirror), mirrored_heading(facing, segment.mirror)
    slot, places = yield from seated(evolve.matching, slots, formation.marks, departure)
    goal = places[slot]
    after = np.concatenate([facing, np.zeros(len(places) - len(facing))])[slot]
    slot = np.where(slot < len(slots), slot, -1).astype(np.int32)
    ways = paths.straight(departure.position, goal)
    timing = _timing(segment, ways, evolve.soft, evolve.orientation, departure, closing=True)
    rough = turned(timing.journey(), evolve.orientation, departure, after, closing=True)
    draft.journey = replace(rough, slot=slot)
    yield
    moved = yield from _timed(segment, timing, evolve.way, departure)
    journey = turned(moved, evolve.orientation, departure, after, closing=True)
    return replace(journey, slot=slot)


def _trajectory(
    segment: Segment, trajectory: Trajectory, polyline: npt.NDArray[np.floating], departure: Departure, draft: Draft
) -> Pieces[Journey]:
    line = np.asarray(polyline, np.float64)
    if segment.mirror is not None:
        line = mirrored(line, segment.mirror)
    together = trajectory.follow is Follow.FILE  # in single file all have to move at the same time
    if together:
        ways = paths.single_file(line, departure.position, gap=trajectory.gap)
        segment = replace(segment, ripple=replace(segment.ripple, beats=0.0))
    else:
        ways = paths.shifted(line, departure.position)
    facing = trajectory.orientation
    after = departure.heading
    if facing.facing in (Facing.TANGENT, Facing.MEASURES):
        after = final_direction(ways, departure.heading)
    timing = _timing(segment, ways, trajectory.soft, facing, departure, closing=False)
    draft.journey = turned(timing.journey(), facing, departure, after, closing=False)
    yield
    moved = yield from _timed(segment, timing, Way.STRAIGHT, departure)
    return turned(moved, facing, departure, after, closing=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Timing:
    """Paths with their times before collision repair, without turns."""

    locomotion: Locomotion
    waits: Float64
    begin: float
    end: float

    def journey(self) -> Journey:
        """Return the paths as a journey that has not been checked for collisions."""
        return Journey(self.locomotion, np.full(self.locomotion.count, -1, np.int32), checked=False)


def _timing(
    segment: Segment, ways: Float32, soft: float, facing: Orientation, departure: Departure, *, closing: bool
) -> _Timing:
    """Return when each dancer is under way. `closing`: leave time for the last turn."""
    begin, end = departure.begin, departure.end
    turn = turn_beats(facing, departure)
    begin, end = begin + turn, end - (turn if closing else 0.0)
    waits = squeezed(delays(segment.ripple, departure.position, departure.numbers, seed=departure.seed), end - begin)
    own = times(begin, end, waits, segment.ripple.arrive)
    still = linear(own, departure.heading, departure.heading)
    return _Timing(Locomotion(ways, own, still, soft), waits, begin, end)


def _timed(segment: Segment, timing: _Timing, way: Way, departure: Departure) -> Pieces[Journey]:
    """Return the path with its times, repaired as far as `way` asks; no turns yet."""
    locomotion, waits = timing.locomotion, timing.waits
    if locomotion.count > CHECKED:
        return timing.journey()
    result: Mended = yield from mending(
        locomotion,
        departure.radius,
        waits,
        begin=timing.begin,
        end=timing.end,
        arrive=segment.ripple.arrive if waits.any() else Arrive.TOGETHER,
        retime=way is Way.MENDED,
        bend=way is not Way.STRAIGHT,
        seed=departure.seed,
        half=departure.half,
    )
    nothing = np.full(locomotion.count, -1, np.int32)
    return Journey(result.locomotion, nothing, result.retimed, result.bent, result.remaining)
