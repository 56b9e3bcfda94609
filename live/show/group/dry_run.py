"""Dry run of a score's evolutions: warns of ways too long for the steps, collisions and formations off the stage
(T088)."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
from shapely import LineString, Point

from live.agents.evolutions.collision_check import TOLERANCE
from live.agents.evolutions.dry_run import TooNear, simulate_plan
from live.agents.evolutions.intention import Segment
from live.agents.formations.formation import TOUCH_DISTANCE, Formation
from live.agents.formations.stage_fit import fit_stage
from live.base.arrays import Bool, Float32
from live.show.group.agent_run import agent_places
from live.show.group.group_motion import AGENT_RADIUS
from live.show.score.section_span import entry_span, score_length
from live.show.show import Show

MOVED_MEASURES = 128
"""Measures within which elements are simulated: agents take a second or two for so many."""
MAX_MEASURES = 400
"""Most measures of a dry run."""
REACH_TOLERANCE = 0.1
"""Tolerance beyond the steps' reach [m]: so small an error is invisible."""
MAX_WARNINGS = 6
"""Most warnings of each kind."""


def dry_run_warnings(show: Show) -> list[str]:
    """Return warnings about the segments of a fresh show, one line each; measures count from 1."""
    patch, evolutions = show.patch, show.motion.evolutions
    if not patch.segment:
        return []
    length = score_length(patch)
    measures = min(length or max(s.measure + s.measures for s in patch.segment), MAX_MEASURES)
    if patch.section and length is not None:  # as written, every section once
        show.playhead.loop((0, length - 1))
    segments = [segment for measure in range(measures) for segment in evolutions.score_segments(measure)]
    simulate = partial(
        simulate_plan,
        show.casting.roster,
        evolutions.repertoire,
        segments,
        show.state.position.copy(),
        measures=measures,
        measure_beats=float(patch.clock.beats_per_measure),
        half=(patch.stage.width / 2, patch.stage.depth / 2),
        radius=AGENT_RADIUS,
        seed=show.seed,
        available=show.motion.entrances.staying.copy(),
    )
    reach = show.scheduler.step_reach() + patch.locomotion.correction_m
    present = show.motion.present
    rehearsal = simulate()
    if patch.element and rehearsal.too_far(reach + REACH_TOLERANCE):  # perhaps an element leaves them nearer
        rehearsal = simulate(moved=_moved_by_elements(show, measures))
    far: dict[int, list[tuple[float, float]]] = {}
    for one in rehearsal.too_far(reach + REACH_TOLERANCE):
        if present[one.dancer]:
            far.setdefault(one.measure, []).append((one.distance, one.reach))
    notes = [
        f"measure {measure + 1}: {_dancers(len(ways))} {max(way for way, _ in ways):.1f} m to go, their steps reach "
        f"{min(most for _, most in ways) - REACH_TOLERANCE:.1f} m: give the segment more measures, or the group "
        "a step that goes farther"
        for measure, ways in sorted(far.items())
    ]
    far_notes = notes + _obstacle_warnings(show, rehearsal.places, rehearsal.under)
    pairs = [one for one in rehearsal.too_near if present[one.first] and present[one.second]]
    crowded, pairs = _crowded_places(show, segments, rehearsal.places, pairs)
    near = _near(show, segments, pairs)
    return [*_first(_formation_notes(show)), *_first(crowded), *_first(far_notes), *_first(near)]


def _moved_by_elements(show: Show, measures: int) -> dict[int, tuple[Bool, Float32]]:
    """Return who has been moved by an element, (A,), and where all stand then, (A, 2) [m], by the measure (from 0) at
    whose line the element is over; those of the first `MOVED_MEASURES`."""
    start, moved = show.state.position.copy(), dict[int, Bool]()
    for element in show.patch.element:
        line = math.ceil(entry_span(show.patch, element)[1] - 1e-9)
        if line < min(measures, MOVED_MEASURES):
            who = show.casting.select(element.group, start)
            moved[line] = moved[line] | who if line in moved else who
    places = agent_places(show, moved.keys())
    show.state.position[:] = start
    return {line: (who, places[line]) for line, who in moved.items()}


def _crowded_places(
    show: Show, segments: list[Segment], places: Float32, pairs: list[TooNear]
) -> tuple[list[str], list[TooNear]]:
    """Return warnings about groups who end on the places of others (T147), with how many fit, and all other pairs.

    `places` (M + 1, A, 2) [m] at the measure lines.
    """
    crowded: dict[int, list[tuple[int, int]]] = {}
    known, rest = set[tuple[int, int]](), list[TooNear]()
    for one in pairs:
        pair = one.first, one.second
        if pair in known:  # they still stand there
            continue
        there = places[one.measure + 1, list(pair)]
        if float(np.hypot(*(there[1] - there[0]))) >= TOUCH_DISTANCE - TOLERANCE:
            rest.append(one)
        elif _segment_of(show, segments, one, one.first) == _segment_of(show, segments, one, one.second):
            rest.append(one)  # within one formation, which has a warning of its own
        else:
            known.add(pair)
            crowded.setdefault(one.measure, []).append(pair)
    notes = []
    for measure, touching in sorted(crowded.items()):
        dancers, left = {dancer for pair in touching for dancer in pair}, list(touching)
        fit = len(dancers)
        while left:  # without the dancer who touches most others
            most = max(sorted(dancers), key=lambda dancer: sum(dancer in pair for pair in left))
            left, fit = [pair for pair in left if most not in pair], fit - 1
        notes.append(
            f"measure {measure + 2}: places of two groups overlap, {len(touching)} "
            f"pair{'s' * (len(touching) > 1)} of dancers would touch there: {fit} of these {len(dancers)} dancers fit; "
            "move one of the formations, or make it smaller"
        )
    return notes, rest


def _near(show: Show, segments: list[Segment], pairs: list[TooNear]) -> list[str]:
    """Return warnings about dancers who would meet: the nearest pair of each segment, and the number of others."""
    met: dict[int, list[TooNear]] = {}
    for one in pairs:
        met.setdefault(_segment_of(show, segments, one), []).append(one)
    notes = []
    for number, ones in sorted(met.items()):
        worst = min(ones, key=lambda one: (one.distance, one.measure, one.first, one.second))
        others = {(one.first, one.second) for one in ones} - {(worst.first, worst.second)}
        begins = segments[number].start + 1 if number >= 0 else worst.measure + 1
        more = f"; {len(others)} more pair{'s' * (len(others) > 1)} would meet in it" if others else ""
        notes.append(
            f"measure {worst.measure + 1}: dancers {worst.first + 1} and {worst.second + 1} would come as near as "
            f"{worst.distance:.2f} m on their ways in the segment that begins in measure {begins}; they will go "
            f"around each other{more}"
        )
    return notes


def _segment_of(show: Show, segments: list[Segment], one: TooNear, *dancers: int) -> int:
    """Return the index of the segment in which two dancers meet, -1 for none: the last to begin that may move them, or
    these `dancers` of them."""
    beats, casting = show.patch.clock.beats_per_measure, show.casting
    found = -1
    for number, segment in enumerate(segments):
        if segment.start <= one.measure < segment.end_beat(beats) / beats:
            sure = casting.select(segment.group, show.state.position)[list(dancers) or [one.first, one.second]].any()
            if found < 0 or sure or casting.depends_on_places(segment.group):
                found = number
    return found


def _formation_notes(show: Show) -> list[str]:
    """Return warnings about formations that are too tight or off the stage for their number of dancers."""
    notes = []
    stage, evolutions = show.patch.stage, show.motion.evolutions
    for section in show.patch.segment:
        if section.formation is None:
            continue
        who = show.casting.select(section.group, show.state.position) & show.motion.present
        if not who.any() and not show.casting.depends_on_places(section.group):
            notes.append(f"measure {section.measure}: nobody is {section.group!r} as the groups are at the beginning")
            continue
        formation = evolutions.formation(section.formation, int(who.sum()))
        where = f"measure {section.measure}: {section.formation}"
        notes += [f"{where}: {warning}" for warning in formation.warnings]
        if formation.min_distance < TOUCH_DISTANCE - TOLERANCE:
            fitting = _fitting(partial(evolutions.formation, section.formation), int(who.sum()))
            notes.append(f"{where}: {fitting} of these {int(who.sum())} dancers fit without touching")
        fit = fit_stage(formation, stage.width, stage.depth)
        if not fit.fits:
            notes.append(f"{where}: {len(fit.outside)} places lie off the stage: {fit.remedy}")
    return list(dict.fromkeys(notes))


def _fitting(formation: Callable[[int], Formation], count: int) -> int:
    """Return how many of `count` dancers a formation has places for on which nobody touches (bisection)."""
    fits, too_many = min(count, 1), count
    while too_many - fits > 1:
        middle = (fits + too_many) // 2
        if formation(middle).min_distance >= TOUCH_DISTANCE - TOLERANCE:
            fits = middle
        else:
            too_many = middle
    return fits


def _first(notes: list[str]) -> list[str]:
    more = len(notes) - MAX_WARNINGS
    return notes if more <= 0 else [*notes[:MAX_WARNINGS], f"... and {more} more of this kind"]


def _dancers(count: int) -> str:
    return "a dancer has" if count == 1 else f"{count} dancers have"


def _obstacle_warnings(show: Show, places: npt.NDArray[np.float32], under: npt.NDArray[np.bool_]) -> list[str]:
    """Return warnings about items of the set in the dancers' ways.

    `places` (M + 1, A, 2) [m] at the measure lines; `under` (M, A): whether a dancer is under a segment.
    """
    notes = []
    things = [
        (item.name, LineString([item.at, item.wall_to]) if item.wall_to else Point(item.at), item.radius)
        for item in show.patch.obstacle
    ]
    for measure, dancer in np.argwhere(under & show.motion.present):
        way = LineString(places[measure : measure + 2, dancer])
        for name, thing, radius in things:
            if way.distance(thing) < AGENT_RADIUS + (radius if isinstance(thing, Point) else 0.0):
                notes.append(f"measure {measure + 1}: {name!r} stands in the way of dancers; draw a path around it")
    return list(dict.fromkeys(notes))
