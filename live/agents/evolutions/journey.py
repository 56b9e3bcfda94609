"""From an intention to a locomotion: who goes where, on which way, at which time, facing where (T085, T096-T103)."""

from collections.abc import Set
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.agents.evolutions import orientation, paths
from live.agents.evolutions.clearance import Approach
from live.agents.evolutions.delays import Arrive, delays, squeezed, times
from live.agents.evolutions.divided import DividedMatching
from live.agents.evolutions.intention import (
    By,
    Evolve,
    Follow,
    FormationLike,
    Hold,
    Intention,
    Matching,
    Repertoire,
    Trajectory,
    Way,
)  # fmt: skip
from live.agents.evolutions.kernels import profile
from live.agents.evolutions.locomotion import Float32, Float64, Locomotion
from live.agents.evolutions.matching import by_id
from live.agents.evolutions.mend import Mended, mending
from live.agents.evolutions.orientation import Facing, Orientation
from live.agents.evolutions.pieces import Pieces
from live.agents.evolutions.sections import sections
from live.agents.evolutions.segment import Segment
from live.agents.evolutions.standing_clear import clear_places
from live.agents.groups.relations import mirrored, mirrored_heading

CHECKED = 300
"""Groups larger than this are not checked for clearance: what they need is left to steering."""
CLEAR_GAP = 1.0
"""Metres between dancers who stand clear of a formation."""


@dataclass(frozen=True, slots=True, eq=False)
class Departure:
    """The boundary condition at the start: D dancers, where they stand and face, and the time there is."""

    numbers: npt.NDArray[np.int32]
    """Their indices among all dancers, shape (D,)."""
    position: Float64
    """Places [m], shape (D, 2)."""
    heading: Float64
    """Headings [rad], shape (D,)."""
    words: tuple[Set[str], ...]
    """The attributes of each, length D."""
    begin: float
    """Beat of the start."""
    end: float
    """Beat by which all have arrived."""
    measure_beats: float
    """Beats of a measure."""
    radius: Float64
    """Body radii [m], shape (D,)."""
    half: tuple[float, float]
    """Half the width and depth of the stage [m]."""
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class Journey:
    """The locomotion of a segment, and what there is to say of it."""

    locomotion: Locomotion
    slot: npt.NDArray[np.int32]
    """Slot of the formation that each dancer goes to, shape (D,); -1: none."""
    retimed: int = 0
    """How many dancers start at another time than asked, so that nobody meets."""
    bent: bool = False
    """Whether ways were bent, so that nobody meets."""
    remaining: tuple[Approach, ...] = ()
    """Pairs (rows of the locomotion) that come nearer than their bodies on these ways: left to steering."""
    checked: bool = True
    """Whether clearance was looked at; above `CHECKED` dancers it is not."""


@dataclass(slots=True, eq=False)
class Draft:
    """What is known of a journey as soon as everybody has her place: the ways before they are mended."""

    journey: Journey | None = None


def travelling(
    segment: Segment, intention: Intention, repertoire: Repertoire, departure: Departure, draft: Draft
) -> Pieces[Journey]:
    """Work out a segment whose intention prescribes places (all but `Procedural`), in pieces; `draft` comes first."""
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
    turns = orientation.linear(stays, departure.heading, departure.heading)
    ways = paths.straight(departure.position, departure.position)
    return Journey(Locomotion(ways, stays, turns), np.full(count, -1, np.int32))


def _evolve(
    segment: Segment, evolve: Evolve, formation: FormationLike, departure: Departure, draft: Draft
) -> Pieces[Journey]:
    slots = np.asarray(formation.slots, np.float64).reshape(-1, 2)
    facing = np.asarray(formation.heading, np.float64).reshape(-1)
    if segment.mirror is not None:
        slots, facing = mirrored(slots, segment.mirror), mirrored_heading(facing, segment.mirror)
    slot, places = yield from _matched(evolve.matching, slots, formation.marks, departure)
    goal = places[slot]
    after = np.concatenate([facing, np.zeros(len(places) - len(facing))])[slot]
    slot = np.where(slot < len(slots), slot, -1).astype(np.int32)
    ways = paths.straight(departure.position, goal)
    timing = _timing(segment, ways, evolve.soft, evolve.orientation, departure, closing=True)
    rough = _turned(timing.journey(), evolve.orientation, departure, after, closing=True)
    draft.journey = replace(rough, slot=slot)
    yield
    moved = yield from _timed(segment, timing, evolve.way, departure)
    journey = _turned(moved, evolve.orientation, departure, after, closing=True)
    return replace(journey, slot=slot)


def _matched(
    matching: Matching, slots: Float64, marks: object, departure: Departure
) -> Pieces[tuple[npt.NDArray[np.int32], Float64]]:
    """Everybody's row of the places: the slots, and after them places to stand clear for those without one."""
    count = len(departure.numbers)
    words = tuple(marks) if isinstance(marks, list | tuple) and len(marks) == len(slots) else ("",) * len(slots)
    dancer_section, slot_section = sections(departure.words, words)
    left_over = count - _seats(dancer_section, slot_section)
    clear = clear_places(left_over, departure.position, slots, half=departure.half, gap=CLEAR_GAP)
    places = np.concatenate([slots, clear])
    slot_section = np.concatenate([slot_section, np.zeros(len(clear), np.int32)])
    if matching.by is By.ID:
        slot = by_id(count, len(slots))
        slot[slot < 0] = len(slots) + np.arange((slot < 0).sum())
        return slot, (places if len(clear) else slots)
    solver = DividedMatching()
    solver.begin(
        departure.position,
        places,
        cost=matching.cost,
        equal_weight=matching.equal_weight,
        fill=matching.fill,
        dancer_section=dancer_section,
        slot_section=slot_section,
    )
    while not solver.done:
        solver.work()
        yield
    return solver.slot, places


def _seats(dancer_section: npt.NDArray[np.int32], slot_section: npt.NDArray[np.int32]) -> int:
    """How many dancers find a slot: on those of their section, and the rest on those without a mark."""
    seated, rest = 0, 0
    for section in np.unique(dancer_section):
        members, own = int((dancer_section == section).sum()), int((slot_section == section).sum())
        if section == 0:
            rest += members
        else:
            seated += min(members, own)
            rest += max(members - own, 0)
    return seated + min(rest, int((slot_section == 0).sum()))


def _trajectory(
    segment: Segment, trajectory: Trajectory, polyline: npt.NDArray[np.floating], departure: Departure, draft: Draft
) -> Pieces[Journey]:
    line = np.asarray(polyline, np.float64)
    if segment.mirror is not None:
        line = mirrored(line, segment.mirror)
    together = trajectory.follow is Follow.FILE  # on a string all have to move at the same time
    if together:
        ways = paths.single_file(line, departure.position, gap=trajectory.gap)
        segment = replace(segment, ripple=replace(segment.ripple, beats=0.0))
    else:
        ways = paths.shifted(line, departure.position)
    facing = trajectory.orientation
    after = departure.heading
    if facing.facing in (Facing.TANGENT, Facing.MEASURES):
        after = orientation.final_direction(ways, departure.heading)
    timing = _timing(segment, ways, trajectory.soft, facing, departure, closing=False)
    draft.journey = _turned(timing.journey(), facing, departure, after, closing=False)
    yield
    moved = yield from _timed(segment, timing, Way.STRAIGHT, departure)
    return _turned(moved, facing, departure, after, closing=False)


@dataclass(frozen=True, slots=True, eq=False)
class _Timing:
    """Ways with their times as they are asked for, before anything is mended; no turns yet."""

    locomotion: Locomotion
    waits: Float64
    begin: float
    end: float

    def journey(self) -> Journey:
        """The same as a journey that nobody has looked at."""
        return Journey(self.locomotion, np.full(self.locomotion.count, -1, np.int32), checked=False)


def _timing(
    segment: Segment, ways: Float32, soft: float, facing: Orientation, departure: Departure, *, closing: bool
) -> _Timing:
    """When everybody is on her way. `closing`: leave time for the last turn."""
    begin, end = departure.begin, departure.end
    turn = _turn_beats(facing, departure)
    begin, end = begin + turn, end - (turn if closing else 0.0)
    waits = squeezed(delays(segment.ripple, departure.position, departure.numbers, seed=departure.seed), end - begin)
    own = times(begin, end, waits, segment.ripple.arrive)
    still = orientation.linear(own, departure.heading, departure.heading)
    return _Timing(Locomotion(ways, own, still, soft), waits, begin, end)


def _timed(segment: Segment, timing: _Timing, way: Way, departure: Departure) -> Pieces[Journey]:
    """The way with its times, mended as far as asked; no turns yet."""
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


def _turn_beats(facing: Orientation, departure: Departure) -> float:
    """Beats for each turn on the spot, which the way has to leave."""
    if facing.facing is not Facing.TANGENT:
        return 0.0
    return min(max(facing.turn_beats, 0.0), (departure.end - departure.begin) / 8.0)


def _turned(
    journey: Journey, facing: Orientation, departure: Departure, after: npt.ArrayLike, *, closing: bool
) -> Journey:
    """The same with the headings asked for; `closing` says whether the last heading must be met exactly."""
    moved, before, last = journey.locomotion, departure.heading, np.asarray(after, np.float64)
    if facing.facing is Facing.LINEAR:
        turns = orientation.linear(moved.times, before, last)
    elif facing.facing is Facing.TANGENT:
        shares = _knot_shares(moved)
        turns = orientation.tangent(moved.ways, shares, moved.times, _turn_beats(facing, departure), before, last)
    else:
        turns = _measure_turns(moved, facing, departure, last, closing)
    return replace(journey, locomotion=replace(moved, turns=turns))


def _knot_shares(moved: Locomotion) -> Float64:
    """The share of the time at which each knot of a way is passed, shape (K,)."""
    fine = np.linspace(0.0, 1.0, 513)
    gone = np.array([profile(float(t), moved.soft) for t in fine])
    return np.interp(np.linspace(0.0, 1.0, moved.ways.shape[1]), gone, fine)


def _measure_turns(
    moved: Locomotion, facing: Orientation, departure: Departure, last: Float64, closing: bool
) -> Float64:
    measures = max(1, round((departure.end - departure.begin) / departure.measure_beats))
    lines = departure.begin + departure.measure_beats * np.arange(measures + 1)
    if facing.facing is Facing.DECLARED:
        declared = facing.headings or (0.0,)
        series = np.array([declared[min(n, len(declared) - 1)] for n in range(measures)])
        headings = np.broadcast_to(series, (moved.count, measures))
        last, closing = headings[:, -1], False
    else:
        headings = orientation.travelled(moved.sampled(lines)[0], last)
    if facing.smooth:
        around = np.concatenate([departure.heading[:, None], headings, last[:, None]], axis=1)
        headings = orientation.smoothed(around)[:, 1:-1]
    if closing:
        headings = np.concatenate([headings[:, :-1], last[:, None]], axis=1)
    return orientation.by_measure(departure.begin, departure.measure_beats, departure.heading, headings)
