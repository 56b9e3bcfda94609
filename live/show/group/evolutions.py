"""Evolutions of a show: segments from the score or from live controls, run by a plan (T085-T089, T095-T103)."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentState
from live.agents.evolutions.facing import Facing, Orientation
from live.agents.evolutions.intention import (
    AssignmentMethod,
    Evolve,
    FollowMode,
    FollowWays,
    Hold,
    Intention,
    Matching,
    PathMode,
    Pause,
    Repertoire,
    Segment,
    Trajectory,
)
from live.agents.evolutions.running_plan import Plan
from live.agents.evolutions.slot_assignment import Cost
from live.agents.evolutions.start_delays import Ripple, StartOrder
from live.agents.formations.formation import Formation, formation_of
from live.agents.formations.formation_spec import FormationSpec
from live.agents.formations.like import capacity_of, specs_from_tables
from live.agents.groups.roster import Line
from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.errors import PersonError, error_context
from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.group.casting import EVERYONE, Casting
from live.show.group.formations import Formations, NamedFormation
from live.show.group.material import compute_evolutions, evolution_ways
from live.show.patch.patch import Patch
from live.show.patch.section_motion import GroupSection
from live.show.patch.section_score import SegmentSection
from live.show.patch_checks.score_conflicts import DancerSelections, check_group_calls, check_regroups, check_segments
from live.show.score.score import Score

SegmentEvent = events.Evolve | events.Travel | events.Pause


def matching_of(word: str) -> Matching:
    """Return the slot assignment named by a patch or control. Raises PersonError for other words."""
    if word == "number":
        return Matching(by=AssignmentMethod.ID)
    try:
        return Matching(cost=Cost(word))
    except ValueError:
        raise PersonError(f"match {word[:40]!r} is unknown", f"there are: {', '.join(Cost)}, number") from None


def selection_expression(words: str) -> str:
    """Return a plan's selection expression for the words of a patch or control; "*" becomes ""."""
    return "" if words.strip() in EVERYONE else words.casefold().strip()


_USUAL_FACING: Final = {(False, False): "linear", (True, False): "tangent", (False, True): "measures"}
"""How dancers face, whether or not a segment has a path or an evolution, if it does not say."""


def segment_of_section(section: SegmentSection, *, start: int, formation: str, path: str) -> Segment:
    """Return the score's segment from measure `start` (from 0) on, with these names of its formation and path."""
    orientation = Orientation(
        Facing(section.facing or _USUAL_FACING[section.path is not None, section.evolution is not None]),
        tuple(math.radians(heading) for heading in section.headings_deg),
    )
    intention: Intention
    matching = matching_of(section.match)
    if section.hold:
        intention = Hold(formation, matching)
    elif section.formation is not None:
        intention = Evolve(formation, matching, PathMode(section.way), orientation, section.soft)
    elif section.evolution is not None:
        intention = FollowWays(section.evolution.casefold().strip(), matching, orientation, section.backwards)
    elif section.path is not None:
        follow = FollowMode.FILE if section.single_file else FollowMode.SHIFTED
        intention = Trajectory(path, follow, orientation=orientation, soft=section.soft)
    else:
        intention = Pause()
    mirror = Line() if section.mirror is True else None
    if isinstance(section.mirror, tuple):
        mirror = Line.through(*section.mirror)
    return Segment(
        intention,
        selection_expression(section.group),
        start,
        section.measures,
        Ripple(section.ripple_beats, StartOrder(section.ripple_from)),
        mirror,
        section.beats_later,
    )


def segment_of_event(event: SegmentEvent, *, start: int, formation: str, path: str) -> tuple[Segment, Float64 | None]:
    """Return the segment of a control and the path it draws, to be stored as `path`, if any.

    `formation` is the formation's name in the plan. Raises PersonError for a path without points.
    """
    group, measures = selection_expression(event.group), max(1, math.ceil(event.measures - 1e-9))
    match event:
        case events.Evolve():
            evolve = Evolve(formation, matching_of(event.match))
            return Segment(evolve, group, start, measures, Ripple(event.ripple)), None
        case events.Travel():
            if not event.points:
                raise PersonError("a path needs points", "write x z of each in metres, as in -3 0, 0 -2.5, 3 0")
            follow = FollowMode.FILE if event.single_file else FollowMode.SHIFTED
            return Segment(Trajectory(path, follow), group, start, measures), np.array(event.points)
        case events.Pause():
            return Segment(Pause(), group, start, measures), None


MAX_LIVE_PATHS: Final = 16
"""Most paths drawn live that are kept; a new one replaces the oldest."""


class Evolutions:
    """The running plan of a show. Beats are danced beats: (measure + fraction) times the beats of a measure."""

    def __init__(
        self, patch: Patch, casting: Casting, *, radius: Float32, seed: int, score: Score | None = None
    ) -> None:
        """Create the plan of a patch. Raises PersonError for an invalid formation, path or group."""
        self._patch, self._casting = patch, casting
        self._score = score or Score(patch)
        counts = {*(group.dancers for group in patch.group), patch.dancer_count}
        self._formations = Formations(specs_from_tables(patch.formation, sorted(counts)), seed=seed)
        self._formations.precompute({1, *counts})  # 1: whether it exists
        compute_evolutions(patch, self._formations.written)
        half = (patch.stage.width / 2, patch.stage.depth / 2)
        self._beats = patch.clock.beats_per_measure
        self._plan = Plan(casting.roster, Repertoire(), measure_beats=self._beats, half=half, radius=radius, seed=seed)
        self._planned_measure = self._measure = -1
        self._measure_segments: list[Segment] = []
        self._next, self._fresh = 0, False  # the measure after this one, and whether this one has just begun
        self._heading: Float64 | None = None  # headings at the line, until the next measure is prepared
        self._live_path_count = 0
        claims = DancerSelections(patch, casting)
        for index, section in enumerate(patch.segment):  # errors are reported at the start, not in measure 200
            where = f"segment in measure {section.measure}"
            if section.formation is not None:
                with error_context(where, ("segment", index, "formation")):
                    self._register_formation(section.formation)
            if section.evolution is not None:
                with error_context(where, ("segment", index, "evolution")):
                    self.ways(section.evolution)
            with error_context(where, ("segment", index, "group")):
                claims.bits(section.group)
            with error_context(where, ("segment", index, "formation")):
                self._check_room(section)
        for index, regroup in enumerate(patch.regroup):
            with error_context(f"regroup in measure {regroup.measure}", ("regroup", index, "dancers")):
                claims.bits(regroup.dancers)
        check_segments(patch.segment, self._score, claims)
        check_regroups(patch.regroup, self._score, casting)
        check_group_calls(patch, claims, self._formations.find)

    def ways(self, name: str) -> Float32:
        """Return the ways of the evolution with this name as knots at even times, (D, K, 2) [m]."""
        return evolution_ways(self._patch, name, self._formations.written)

    def _check_room(self, section: SegmentSection | GroupSection) -> None:
        """Raise PersonError if a formation is squeezed into a region that has no room for all dancers; those who are
        selected by place are not counted."""
        if section.formation is None:
            return
        spec = self._formations.find(section.formation).spec
        if isinstance(section, GroupSection):
            dancers = section.dancers
        elif self._casting.depends_on_places(section.group):
            return
        else:
            count = self._patch.dancer_count
            dancers = int(self._casting.select(section.group, np.zeros((len(self._casting.group), 2)))[:count].sum())
        most = capacity_of(spec) if spec.like is not None else None
        if most is not None and dancers > most:
            raise PersonError(
                f"the region of {spec.name!r} has room for {most} of {dancers} dancers",
                "a larger region, or fewer dancers",
            )

    def apply_patch(self, fresh: "Evolutions") -> None:
        """Apply the formations of another patch. Dancers in an edited one go to its new places.

        Formations that were defined live and are not in the patch stay.
        """
        for formation in self._formations.apply_patch(fresh._formations):
            if formation.name in self._plan.repertoire.formations:
                self._plan.repertoire = self._plan.repertoire.with_formation(formation)
                self._move_to(formation.name, self._planned_measure)
        self.update_groups()

    def starting_places(self) -> Float64:
        """Return the starting places of all groups' dancers, one group after the other, (dancers, 2) [m]."""
        places = []
        for index, section in enumerate(self._patch.group):
            with error_context(f"group {section.name!r}", ("group", index, "formation")):
                self._check_room(section)
                places.append(self._group_starting_places(section))
        return np.concatenate(places)

    def _group_starting_places(self, section: GroupSection) -> Float64:
        """Return the starting places of a group's dancers, (dancers, 2) [m]. Partners share a place."""
        if section.partners is None:
            return self._formations.starting_places(section)
        pairs = section.model_copy(update={"dancers": (section.dancers + 1) // 2})
        return np.repeat(self._formations.starting_places(pairs), 2, axis=0)[: section.dancers]

    def _register_formation(self, words: str, *, live: bool = False) -> str:
        """Return the plan's name of the formation with this name or notation, and add it to the repertoire."""
        formation = self._formations.find(words, live=live)
        if self._plan.repertoire.formations.get(formation.name) is not formation:
            self._plan.repertoire = self._plan.repertoire.with_formation(formation)
        return formation.name

    # -- measures ------------------------------------------------------------------------------------------------

    def _plan_up_to(self, measure: int) -> None:
        """Plan the score's segments of the measures up to `measure`, once."""
        for number in range(max(self._planned_measure + 1, measure - 1), measure + 1):
            self._measure_segments = self.score_segments(number)
            for segment in self._measure_segments:
                self._plan.add(segment)
        self._planned_measure = max(self._planned_measure, measure)

    def withdraw(self, measure: int) -> None:
        """Replace the planned segments of `measure`, which has not begun, after the score has jumped."""
        if measure > self._planned_measure:
            return
        self._plan.remove(self._measure_segments)
        self._planned_measure = measure - 1
        self._plan_up_to(measure)

    def score_segments(self, measure: int) -> list[Segment]:
        """Return the score's segments for `measure` (from 0), and add their formations and paths to the repertoire."""
        segments = []
        for index, section in enumerate(self._score.segments(measure)):
            formation = "" if section.formation is None else self._register_formation(section.formation)
            way = f"score {index} of measure {section.measure}"
            if section.path is not None:
                self._plan.repertoire = self._plan.repertoire.with_path(way, np.array(section.path))
            if section.evolution is not None:
                self._register_ways(section.evolution)
            segments.append(segment_of_section(section, start=measure, formation=formation, path=way))
        return segments

    def _register_ways(self, name: str) -> None:
        """Add the ways of an evolution to the repertoire."""
        folded, ways = name.casefold().strip(), self.ways(name)
        if self._plan.repertoire.ways.get(folded) is not ways:
            self._plan.repertoire = self._plan.repertoire.with_ways(folded, ways)

    def formation(self, words: str, count: int) -> Formation:
        """Return the formation with this name or notation for `count` dancers, with its warnings."""
        named_formation = self._formations.find(words)
        return formation_of(named_formation.spec, count, named_formation.seed)

    def written_formation(self, words: str) -> FormationSpec:
        """Return the formation of the patch with this name, or of this notation. Raises PersonError for others."""
        return self._formations.written(words)

    def formation_name(self, words: str) -> str:
        """Return the name of the formation with this name or notation. Raises PersonError for one that is neither, or
        that cannot be read while a show runs."""
        return self._formations.find(words, live=True).name

    @property
    def repertoire(self) -> Repertoire:
        """The formations and paths that segments refer to."""
        return self._plan.repertoire

    def begin_measure(self, measure: int, position: Float32, heading: Float64, available: Bool) -> None:
        """Begin the segments of `measure` (from 0) for the dancers `available` (A,), from where they are now."""
        self._measure = measure
        if measure < 0:
            return
        self._plan.available = available
        self._plan_up_to(measure)
        self._plan.begin_measure(measure, position, heading)
        self._plan.forget(measure + 1)
        self._plan_up_to(measure + 1)
        self._next, self._heading, self._fresh = measure + 1, heading, True

    def prepare(self, measure: int, position: Float32, heading: Float64) -> None:
        """Begin to compute the segments of `measure` ahead of time, from predicted places and headings."""
        if measure >= 0:
            self._plan.prepare(measure, position, heading)

    # -- live ----------------------------------------------------------------------------------------------------

    def handle(self, event: SegmentEvent, *, measure: int, beat: float, position: Float32, heading: Float64) -> None:
        """Apply an event at the danced `beat`, in `measure`, or at its end. Raises PersonError for an empty or invalid
        request."""
        if not self._casting.select(event.group, position).any():
            raise PersonError(f"nobody is {event.group!r} now")
        way = f"live {self._live_path_count % MAX_LIVE_PATHS}"
        formation = self._register_formation(event.formation, live=True) if isinstance(event, events.Evolve) else ""
        segment, drawn = segment_of_event(event, start=max(measure + 1, 0), formation=formation, path=way)
        if drawn is not None:
            self._live_path_count += 1
            self._plan.repertoire = self._plan.repertoire.with_path(way, drawn)
        if event.next or beat < 0.0:
            self._plan.add(segment, replace=True)
        else:
            self._plan.start_now(segment, beat, position, heading)

    def define(self, event: events.DefineFormation, *, measure: int) -> None:
        """Define or replace a formation by name, within `measure`. Dancers in it go to its new places (T087)."""
        self._replace_formation(self._formations.define(event.name, event.formation), measure)

    @property
    def formations(self) -> dict[str, NamedFormation]:
        """All named formations, by case-folded name."""
        return self._formations.named

    def edited_values(self, event: ControlEvent) -> dict[str, NamedFormation]:
        """See `EditablePart`."""
        return self.formations

    def restore_values(self, values: Mapping[str, NamedFormation | None]) -> None:
        """Set formations, by case-folded name, to earlier ones; None removes a name."""
        for name, formation in values.items():
            self._formations.restore(name, formation)
            if formation is not None:
                self._replace_formation(formation, self._measure)

    def _replace_formation(self, formation: NamedFormation, measure: int) -> None:
        """Put the formation into the repertoire. Dancers in it go to its new places from `measure` + 1 on."""
        self._plan.repertoire = self._plan.repertoire.with_formation(formation)
        self._move_to(formation.name, measure + 1)

    def _move_to(self, name: str, measure: int) -> None:
        """Send dancers in the formation `name`, or on the way there, to its places from `measure` on."""
        for motion in self._plan.motions:
            if isinstance(motion.intention, Hold | Evolve) and motion.intention.formation == name:
                self._plan.add(replace(motion.segment, start=max(measure, 0), delay=0.0))

    def resize(self, half: tuple[float, float], fitting: Float64 | None, *, measure: int) -> None:
        """Set the stage's half sizes [m] within `measure`, and fit formations to `fitting` (2,) [m] or to none (None).

        Dancers in a formation, or on the way there, go to its new places.
        """
        self._plan.resize(half)
        if not self._formations.fit(fitting):
            return
        for motion in self._plan.motions:
            if isinstance(motion.intention, Hold | Evolve):
                self._plan.add(replace(motion.segment, start=max(measure + 1, 0), delay=0.0))

    def release(self, who: Bool) -> None:
        """End the running segments of the dancers in the mask `who` (A,)."""
        self._plan.release(who)

    def clear(self, who: Bool) -> None:
        """Remove all segments, planned ones included, of the dancers in the mask `who` (A,)."""
        self._plan.clear(who)

    def update_groups(self) -> None:
        """Update the plan after dancers have changed their groups."""
        self._plan.roster = self._casting.roster

    # -- ticks ---------------------------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """Whether a segment that may hold dancers has begun or is being computed."""
        return self._plan.running

    def moved(self) -> Iterator[tuple[str, Bool]]:
        """Yield the selection of each segment that lasts now, and the dancers that it controls, (A,)."""
        for motion in self._plan.motions:
            if self._measure * self._beats >= motion.segment.end_beat(self._beats):
                continue
            who = np.zeros(len(self._casting.group), np.bool_)
            who[motion.dancers[motion.controlled != 0]] = True
            if who.any():
                yield motion.segment.group, who

    def begun(self) -> Iterator[tuple[Segment, Int32]]:
        """Yield the segments that have begun and still lead somebody, with the indices of the dancers whom they lead,
        (D,)."""
        for motion in self._plan.motions:
            led = motion.dancers[motion.controlled != 0]
            if len(led):
                yield motion.segment, led.astype(np.int32)

    @property
    def at_rest(self) -> bool:
        """Whether no segment is partly computed."""
        return self._plan.idle

    def drop_incomplete(self) -> None:
        """Drop segments that are partly computed, and free their dancers."""
        self._plan.drop_incomplete()

    def work(self, position: Float32) -> None:
        """Do one small piece of the pending computation, for agents at `position` (A, 2) [m].

        The tick of a line continues pending work. The next tick prepares the measure after it, if possible.
        """
        if self._heading is not None and not self._fresh:
            heading, self._heading = self._heading, None
            self._plan.prepare(self._next, position, heading, if_controlled=True)
        self._fresh = False
        self._plan.work()

    def write(self, wants: AgentCommand, state: AgentState, beat: float, beats_per_second: float) -> None:
        """Write the commands of agents under a segment at the danced `beat`."""
        self._plan.write_commands(wants, state, beat, beats_per_second)

    def target(self, beat: float) -> tuple[Bool, Float32, Float32]:
        """Return which dancers are under a segment at a future danced `beat`, (A,), their places, (A, 2) [m], and their
        headings."""
        setting = self._plan.predicted_state(beat)
        return setting.controlled == 1, setting.position, setting.heading
