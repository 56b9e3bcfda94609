"""Targets of step selection: the wanted step, position (T067, T068) and heading (T126, T127) of each dancer."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int32
from live.clock.timeline import Timeline
from live.control.events.event import ControlEvent
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import wrap_angle
from live.graph.select.reachability import paces
from live.graph.select.selector import StepSelector
from live.show.group.group_values import GroupValues
from live.show.patch.patch import Patch
from live.show.patch.section_motion import ATTRACTOR, CENTRE, DANCER, DEGREES, GROUP, PATH, PUBLIC, Facing, parse_facing
from live.show.score.canon import Canon, StepSource
from live.show.score.step_program import StepProgram
from live.show.score.subgroups import MAX_SUBGROUPS, Subgroups
from live.show.selection.choices import StepChoices
from live.show.selection.lookahead import StepCosts

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion


MIN_DIRECTION_LENGTH = 0.25
"""A displacement shorter than this [m] in a measure has no direction: a standing dancer keeps the heading (T126)."""
MIN_FACING_DISTANCE = 0.3
"""Dancers do not turn towards targets nearer than this [m]."""


class Headings:
    """Target headings of A dancers, measure after measure.

    Wanted headings are smoothed by T127: a quarter of the turn in one measure, half in the next, a quarter in the
    third. Later wishes are unknown in a live show, so the turn begins with the measure in which it is wanted.
    """

    def __init__(self, patch: Patch, motion: "GroupMotion") -> None:
        """Create the headings of a patch. Raises PersonError for an unknown facing."""
        self._patch = patch
        self._motion = motion
        count = len(motion.casting.group)
        self._facing = GroupValues([self.parse(section.facing) for section in patch.group])
        self._raw = np.zeros((2, count))
        """Wanted headings of the last two measures, unwrapped, the newest first [rad], shape (2, A)."""
        self._before = self._raw.copy()

    def parse(self, words: str) -> Facing:
        """Parse a facing for this show. Raises PersonError for unknown words."""
        casting = self._motion.casting
        return parse_facing(words, dancers=len(casting.group), groups=casting.names)

    def apply_patch(self, fresh: "Headings") -> None:
        """Apply the facings that differ between the old and the new patch. Others keep their live values."""
        for index, (old, new) in enumerate(zip(self._patch.group, fresh._patch.group, strict=True)):
            if old.facing != new.facing:
                self._facing.set_group(index, fresh._facing.groups[index], self._motion.casting.group)

    def set(self, groups: list[int] | None, who: Bool, facing: Facing) -> None:
        """Set the facing of whole groups, or (None) of the dancers `who` (A,), from the next decided measure on."""
        if groups is None:
            self._facing.set_dancers(who, facing)
        for group in groups or ():
            self._facing.set_group(group, facing, self._motion.casting.group)

    def edited_values(self, event: ControlEvent) -> dict[int, Any]:
        """Return the facings by group and of dancers, see `EditablePart`."""
        return self._facing.by_key()

    def restore_values(self, values: Mapping[int, Any]) -> None:
        """See `EditablePart`."""
        self._facing.restore(values, self._raw.shape[1])

    def reset(self, heading: Float64) -> None:
        """Initialize with the dancers' `heading` (A,) [rad]."""
        self._raw[:] = heading

    def undo(self) -> None:
        """Undo the last call of `advance`."""
        self._raw[:] = self._before

    def advance(self, start: Float64, wish: Float64, planned: Float64, known: Bool) -> Float64:
        """Return headings (A,) [rad] for the end of the next measure of dancers who go from `start` to `wish` (A, 2).

        `planned` (A,) are the headings of dancers in an evolution (`known`), which are smoothed already. Called once
        for each measure.
        """
        self._before[:] = self._raw
        wanted = self._raw[0].copy()
        group = self._motion.casting.group
        for everybody, facing in self._facing.parts(group):
            for index in np.unique(group[everybody]).tolist():  # some facings mean something else for each group
                members = everybody[group[everybody] == index]
                wanted[members] = self._wanted(facing, members, start, wish, wanted)
        passing = self._motion.entrances.passing  # dancers who enter or leave face the way they go
        wanted[passing] = _towards(wish - start, MIN_DIRECTION_LENGTH, wanted)[passing]
        wanted[known] = planned[known]
        newest = self._raw[0] + wrap_angle(wanted - self._raw[0])
        smooth = 0.25 * newest + 0.5 * self._raw[0] + 0.25 * self._raw[1]
        smooth[known | passing] = newest[known | passing]
        self._raw[1], self._raw[0] = self._raw[0], newest
        self._raw[1, passing] = newest[passing]
        return np.asarray(smooth)

    def _wanted(
        self, facing: Facing, members: npt.NDArray[np.intp], start: Float64, wish: Float64, last: Float64
    ) -> Float64:
        """Return the wanted headings of `members` (n,), (n,)."""
        match facing.kind:
            case k if k == PUBLIC:
                return np.zeros(len(members))
            case k if k == DEGREES:
                return np.full(len(members), facing.heading)
            case k if k == PATH:
                return _towards((wish - start)[members], MIN_DIRECTION_LENGTH, last[members])
        place = self._place(facing, members)
        if place is None:
            return last[members]
        return _towards(place - wish[members], MIN_FACING_DISTANCE, last[members])

    def _place(self, facing: Facing, members: npt.NDArray[np.intp]) -> Float64 | None:
        """Return the place that the members face [m], (2,) or (n, 2); None if there is none."""
        group, position = self._motion.casting.group, self._motion.state.position.astype(np.float64)
        index = int(group[members[0]])
        match facing.kind:
            case k if k == CENTRE:
                return np.array(self._patch.group[index].centre)
            case k if k == DANCER:
                return position[facing.dancer] if self._motion.present[facing.dancer] else None
            case k if k == GROUP:
                whom = (group == self._motion.casting.names.index(facing.name)) & self._motion.present
                return position[whom].mean(axis=0) if whom.any() else None
            case k if k == ATTRACTOR:
                return self._motion.elements.attractor_of(int(members[0]))
        return None


def _towards(way: Float64, least: float, last: Float64) -> Float64:
    """Return headings (n,) along `way` (n, 2) [m], or `last` (n,) where it is shorter than `least` [m]."""
    return np.where(np.hypot(*way.T) > least, np.arctan2(way[:, 0], way[:, 1]), last)


STANDING_DISTANCE: float = 0.15
"""A group stands if the median of its dancers' ways in the next measure is shorter than this [m]."""
TARGET_CORRECTION_SHARE: float = 0.8
"""Share of the possible correction that targets may use beyond a step's reach. The rest is kept for path separation.
Steps in place may use all of it."""


MIN_TURN_GAIN: float = 0.3
"""Dancers turn where they go if that gets them farther by this [m]."""
FREE_SHORTFALL: float = 0.2
"""To arrive counts more than where one faces. Dancers who would end farther than this [m] from their targets, though
corrected, turn any way that helps, ..."""
PLANNED_SHORTFALL: float = 0.4
"""... those in an evolution only if it is farther than this [m], ..."""
NO_SHORTFALL: float = 1e6
"""... and partners and captured dancers never."""


class StepTargets:
    """Targets of A dancers for one measure, computed piece by piece."""

    def __init__(
        self,
        patch: Patch,
        dancers: "Dancers",
        motion: "GroupMotion",
        programmes: list[StepSource],
        subgroups: Subgroups,
        group: Int32,
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures."""
        self._patch, self._dancers, self._motion = patch, dancers, motion
        self._programmes, self._subgroups, self._group = programmes, subgroups, group
        self.order = list(range(len(programmes)))
        """The groups in the order of their computation: echoes after the groups that they echo."""
        self.reorder()
        self.headings = Headings(patch, motion)
        count = len(group)
        self.speed: Float32 = np.zeros(count, np.float32)
        """Top speed of each agent that its dancer's steps can follow [m/s], shape (A,)."""
        self._row_count = len(programmes) + min(count, MAX_SUBGROUPS)
        # measure and step of each group, then of the subgroups that dance
        self._wanted_steps: list[tuple[int | None, int]] = [(None, 0)] * self._row_count
        self.step = np.zeros(count, np.int32)
        """The wanted step of each dancer, below 0 for any, shape (A,)."""
        self.row = np.zeros(count, np.int32)
        """Row of `ahead` that applies to each dancer, shape (A,)."""
        self.heading = np.zeros(count)
        """Target heading of each dancer at the end [rad], shape (A,)."""
        self.turn_shortfall = np.zeros(count)
        """How far from their targets dancers would have to end to turn any way instead [m], (A,)."""

    def reorder(self) -> None:
        """Update the order after a change of the groups that echo others."""
        self.order.sort(key=lambda index: (isinstance(self._programmes[index], Canon), index))

    def set_graph(self, graph: MotionGraph, choosing: StepSelector) -> None:
        """Switch to this graph."""
        library = graph.library
        self._choosing = choosing
        self.step_costs = StepCosts(graph)
        self.ahead = np.zeros((2 * self._row_count, library.node_count))
        """Number of wrong measures for each next node, for each group or subgroup R and its travel step, (2 R, N)."""
        reach = [library.max_travel(step) for step in range(len(library.steps))]
        # reach of one measure of each step [m]; last, for ANY_STEP, the largest
        self._reach = np.array([*reach, max(reach)])
        # how far a measure of each step follows an agent in any direction [m]
        self._pace = paces(graph, self._patch.locomotion.correction_m)
        for programme in self._programmes:
            programme.set_graph(graph)
        self._subgroups.set_graph(graph)

    def assign(self, measure: int) -> list[int]:
        """Find the subgroups that dance in `measure`; return the rows of all programs in the order of their
        computation."""
        casting, position = self._motion.casting, self._motion.state.position
        self._subgroups.assign(measure, lambda words: casting.select(words, position))
        groups = len(self._programmes)
        return [*self.order, *range(groups, groups + len(self._subgroups.active))]

    def program(self, row: int) -> StepSource:
        """Return the program of a row: of a group, or of a subgroup that dances."""
        groups = len(self._programmes)
        return self._programmes[row] if row < groups else self._subgroups.active[row - groups].program

    def rows(self) -> Int32:
        """Return the row of each dancer's program, (A,)."""
        return np.where(
            self._subgroups.of_dancer < 0, self._group, len(self._programmes) + self._subgroups.of_dancer
        ).astype(np.int32)

    def step_reach(self) -> Float64:
        """Return the reach in one measure of the group's farthest step, for each dancer [m], shape (A,)."""
        most, rows = np.zeros(len(self._group)), self.rows()
        for row in np.unique(rows).tolist():
            programme = self.program(row)
            steps = [*programme.steps, *([] if programme.travel_step is None else [programme.travel_step])]
            most[rows == row] = max(float(self._reach[step]) for step in steps)
        return most

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Set the agents' top speeds to what the group's steps and the correction can follow."""
        seconds = timeline.beats_per_measure * 60.0 / timeline.tempo
        rows = self.rows()
        for row in [*self.order, *range(len(self._programmes), int(rows.max(initial=0)) + 1)]:
            programme, (asked_for, step), members = self.program(row), self._wanted_steps[row], rows == row
            if isinstance(programme, StepProgram):
                programme.measure_s = seconds
            if asked_for != measure:
                step = programme.step_for(measure, self._dancers.node[members])
            steps = [step] if programme.travel_step is None else [step, programme.travel_step]
            self.speed[members] = max(float(self._pace[s]) for s in steps) / seconds

    def set_wishes(self, choices: StepChoices) -> None:
        """Set the wished positions and headings for the end of the next measure. The look-ahead must be finished."""
        present = self._dancers.present
        wish, known, planned = self._motion.predicted_ends()
        choices.begin(*present.ends(), self._motion.present)
        choices.wish[:] = wish
        self.heading[:] = self.headings.advance(choices.start_position, wish, planned, known)
        self.turn_shortfall[:] = np.where(known, PLANNED_SHORTFALL, FREE_SHORTFALL)
        self.turn_shortfall[self._motion.partners.leader] = self.turn_shortfall[self._motion.partners.follower] = (
            NO_SHORTFALL
        )
        if (answers := self._dancers.partner_response) is not None:
            for pair in answers.pairs:
                self.turn_shortfall[[pair.leader, pair.follower]] = NO_SHORTFALL
        self.turn_shortfall[self._dancers.captured_dancers()] = NO_SHORTFALL
        if len(self._motion.partners.leader):
            self._motion.partners.adjust_targets(
                choices.wish, self.heading, choices.start_position, choices.heading, known
            )

    def set_wanted_step(self, row: int, measure: int, choices: StepChoices) -> None:
        """Set the wanted step of the dancers of a row in `measure`: its program's next one, or its travel step for
        dancers whose way is too far for that."""
        programme, members = self.program(row), self.rows() == row
        way = np.hypot(*(choices.wish - choices.start_position).T)
        if isinstance(programme, StepProgram):
            programme.standing = not members.any() or bool(np.median(way[members]) < STANDING_DISTANCE)
        step = programme.step_for(measure, self._dancers.node[members])
        self._wanted_steps[row] = measure, step
        self.step[members] = step
        self.row[members] = 2 * row
        self.ahead[2 * row] = self.step_costs.sequence_cost(programme.upcoming, programme.measures_done)
        if programme.travel_step is not None and self._reach[programme.travel_step] > self._reach[step]:
            far = members & (way > self._reach[step] + 0.5 * self._patch.locomotion.correction_m)
            self.step[far] = programme.travel_step
            self.row[far] = 2 * row + 1
            self.ahead[2 * row + 1] = self.step_costs.step_distance(programme.travel_step)

    def _reached(self, choices: StepChoices, way: Float64, heading: Float64, bound: Float64) -> Float64:
        """Return the part of each `way` (A, 2) [m] that the wanted step reaches ending with `heading` (A,) [rad]."""
        change = wrap_angle(heading - choices.heading)
        return self._choosing.reach_table.limit_travel(
            self.step, choices.heading, change, way, TARGET_CORRECTION_SHARE * bound, bound
        )

    def limit_targets(self, choices: StepChoices, bound: Float64) -> None:
        """Limit the targets (predicted agents) to the reach of the steps with `bound` (A,) [m] of correction.

        Dancers whose steps do not go that way with the wanted heading turn towards it: a library of walks goes forward
        only.
        """
        way = choices.wish - choices.start_position
        reached = self._reached(choices, way, self.heading, bound)
        path = np.arctan2(way[:, 0], way[:, 1])
        turned = self._reached(choices, way, path, bound)
        free = self.turn_shortfall <= FREE_SHORTFALL
        turns = free & (np.hypot(*turned.T) > np.hypot(*reached.T) + MIN_TURN_GAIN)
        self.heading[turns] = path[turns]
        choices.target[:] = choices.start_position + np.where(turns[:, None], turned, reached)
        if len(self._motion.partners.leader):
            self._motion.partners.gather(choices.target, self.heading)
        choices.step[:] = self.step
