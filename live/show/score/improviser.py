"""Improvisation for groups: `[[improvise]]` tables draw steps by weights, music and what other groups danced.

All random choices derive from (seed, section, turn, group, measure), so the same events give the same dance, live or
replayed. `ImprovisedMotion` draws motion calls at each phrase.
"""

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError, error_context
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.structure_rules import UNREACHABLE
from live.show.patch.section_score import ImproviseSection
from live.show.score.music_reactions import Mood
from live.show.score.playhead import END, Place
from live.show.score.score import Score
from live.show.score.sequence_lookup import describe_place
from live.show.score.step_history import StepHistory
from live.show.score.step_names import UnknownStep, find_step, is_in_place, near_tempo, step_measures

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph

NO_INDEX: Final = -1
EntrySpan = tuple[int, float, float, tuple[str | int, ...]]
"""Section, first measure in it, measure after the last, and place in the patch of an entry."""


@dataclass(frozen=True, slots=True, eq=False)
class ImproviseTable:
    """One `[[improvise]]` table resolved for one group: step indices and the measures it covers."""

    section: int
    begin: int
    """First measure within the section, from 0."""
    end: int | None
    """Measure after the last; None: no end."""
    settings: ImproviseSection
    steps: tuple[int, ...]
    weights: npt.NDArray[np.float64]
    factors: tuple[npt.NDArray[np.float64], ...]
    """For each rule, the factors that multiply the weights."""
    where: tuple[str | int, ...]
    """Its place in the patch: list and index."""
    caller: int
    """Group to answer in call and response, NOBODY for none."""
    listening: int | None

    def covers(self, place: Place) -> bool:
        """Whether a place is in its measures."""
        within = place.measure >= self.begin and (self.end is None or place.measure < self.end)
        return within and place.section == self.section


def resolve_table(
    section: ImproviseSection,
    score: Score,
    graph: "MotionGraph",
    own: list[int],
    groups: list[str],
    group: int,
    where: tuple[str | int, ...] = (),
) -> ImproviseTable | None:
    """Resolve one `[[improvise]]` table for `group`, whose own steps are `own`; None if its place never comes.

    Raises PersonError for unknown names, or limits that cannot be kept.
    """
    place = score.place_of(section.section, section.measure)
    if place is None:
        return None
    with error_context(
        describe_place(section.section, section.measure, f"improvise of group {groups[group]!r}"), where
    ):
        try:
            given = {find_step(graph, name): weight for name, weight in section.steps.items()}
            weights = given or dict.fromkeys(own, 1.0)
            steps = tuple(weights)
            factors = []
            for rule in section.rule:
                favours = {find_step(graph, name): factor for name, factor in rule.favours.items()}
                factors.append(np.array([favours.get(step, 1.0) for step in steps]))
            listening = None if section.listening is None else find_step(graph, section.listening)
        except UnknownStep as error:
            raise PersonError(str(error)) from None
        if sum(weight > 0.0 for weight in weights.values()) < 2 and section.most < 1000:
            raise PersonError(
                f"with one step alone it would come more than {section.most} times in a row",
                "give it more steps, or most = 1000",
            )
        caller = NO_INDEX
        if section.answers is not None:
            caller = [name.casefold() for name in groups].index(section.answers.casefold())
    size = score.playhead.sections[place[0]].measures if place[0] != END else None
    end = size if section.measures is None else place[1] + section.measures
    return ImproviseTable(place[0], place[1], end, section, steps, np.array(list(weights.values())), tuple(factors),
                          where, caller, listening)  # fmt: skip


Nodes = npt.NDArray[np.int32]
DrawState = tuple[int, int, int]
"""Last drawn step, measures left of it, and the index of the table that drew it."""
StepChoice = tuple[int, tuple[SequenceEntry, ...], int]

STEP_SALT: Final = 0x1A9
"""Salt that separates these random numbers from those of a group's own steps."""


class Improviser:
    """The step choices of one group. Ask for measures in order."""

    def __init__(
        self, tables: list[ImproviseTable], default_table: ImproviseTable, score: Score, history: StepHistory,
        mood: Mood, *, group: int, seed: int, graph: "MotionGraph",
    ) -> None:  # fmt: skip
        """`default_table`: the table used when improvisation is requested where the score has none."""
        self._tables, self._default_table = tables, default_table
        self._score, self._history, self._mood, self._group = score, history, mood, group
        self._seed, self._graph = seed, graph
        self.draw_state: DrawState = (NO_INDEX, 0, NO_INDEX)
        """State needed to ask for a measure again."""
        self.forced = False
        """Whether improvisation is requested by command, regardless of the score."""

    def apply_patch(self, fresh: "Improviser") -> None:
        """Adopt the tables of an edited patch."""
        self._tables, self._default_table = fresh._tables, fresh._default_table
        self._history.capacity = max(self._history.capacity, fresh._history.capacity)

    def set_graph(self, graph: "MotionGraph") -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._graph = graph

    def attach(self, running: "Improviser") -> None:
        """Take part in the show of another improviser: its score, history and mood."""
        self._score, self._history, self._mood = running._score, running._history, running._mood

    def copy(self, number: int) -> "Improviser":
        """Return an independent copy for the subgroup with this number, with the same past."""
        other = copy(self)
        other._group = number
        self._history.copy_steps(self._group, number)
        return other

    def forget(self) -> None:
        """Forget the steps of a subgroup that has ended."""
        self._history.forget(self._group)

    def spans(self) -> Iterator[EntrySpan]:
        """Yield section, first measure, measure after the last, and place in the patch of each table."""
        for one in self._tables:
            yield one.section, one.begin, math.inf if one.end is None else one.end, one.where

    def entry(self, place: Place) -> tuple[int, int] | None:
        """Return index and first measure of the table for a place, without one that was requested; None if none."""
        for index, table in enumerate(self._tables):
            if table.covers(place):
                return index, table.begin
        return None

    def _table(self, place: Place) -> int | None:
        """Return the index of the table for this place; the last index is the usual one."""
        for index, table in enumerate(self._tables):
            if table.covers(place):
                return index
        if not self.forced:
            return None
        return 0 if self._tables else len(self._tables)

    def is_improvised(self, measure: int) -> bool:
        """Whether the group improvises in `measure`."""
        return self._table(self._score.place(measure)) is not None

    def record(self, measure: int, step: int, into: int) -> None:
        """Record the step that the group dances in `measure`, whatever its origin."""
        self._history.record(self._group, measure, step, into)

    def choose(self, measure: int, nodes: Nodes, *, standing: bool, measure_s: float = 0.0) -> StepChoice | None:
        """Return what the group dances in `measure`, see `Part.told`; None if it does not improvise."""
        place = self._score.place(measure)
        index = self._table(place)
        if index is None:
            return None
        table = [*self._tables, self._default_table][index]
        told = self._respond(table, measure, place) if table.caller != NO_INDEX else None
        return self._continue_draw(table, index, place, measure, nodes, (standing, measure_s)) if told is None else told

    def _respond(self, table: ImproviseTable, measure: int, place: Place) -> StepChoice | None:
        """In every second phrase return what the caller danced one phrase earlier, otherwise the listening step."""
        size = table.settings.phrase
        if not self._is_response(table, place):
            return None if table.listening is None else self._repeat(table.listening, measure)
        if table.settings.answer == "other":
            return None
        said = self._history.step_at(table.caller, measure - size)
        if said is None:
            return None
        step, into = said
        return step, (SequenceEntry(step, step_measures(self._graph, step)),), into

    @staticmethod
    def _is_response(table: ImproviseTable, place: Place) -> bool:
        return bool((place.measure - table.begin) // table.settings.phrase % 2)

    def _repeat(self, step: int, measure: int) -> StepChoice:
        """Repeat one step."""
        length = step_measures(self._graph, step)
        before = self._history.step_at(self._group, measure - 1)
        into = (before[1] + 1) % length if before is not None and before[0] == step else 0
        return step, (SequenceEntry(step, length),), into

    # -- chance ------------------------------------------------------------------------------------------------

    def _continue_draw(
        self, table: ImproviseTable, index: int, place: Place, measure: int, nodes: Nodes, suits: tuple[bool, float]
    ) -> StepChoice:
        """Return the drawn step until its measures are over, then draw the next."""
        step, left, whose = self.draw_state
        last, run = self._run(measure)
        length = 0 if step == NO_INDEX else step_measures(self._graph, step)
        if (
            whose != index
            or last != step
            or self._history.step_at(self._group, measure - 1) != (step, length - left - 1)
        ):
            left = 0  # another step was danced in between
        if left <= 0:
            if last not in table.steps or run >= table.settings.at_least:
                last = self._draw(table, place, measure, nodes, suits)
            step = last
            left = length = step_measures(self._graph, step)
        self.draw_state = (step, left - 1, index)
        return step, (SequenceEntry(step, length),), length - left

    def _run(self, measure: int) -> tuple[int, int]:
        """Return the step before `measure`, and how often in a row it has begun."""
        said = self._history.step_at(self._group, measure - 1)
        if said is None:
            return NO_INDEX, 0
        step, run = said[0], 0
        while said is not None and said[0] == step:
            run += said[1] == 0
            measure -= 1
            said = self._history.step_at(self._group, measure - 1)
        return step, run

    def _draw(self, table: ImproviseTable, place: Place, measure: int, nodes: Nodes, suits: tuple[bool, float]) -> int:
        """Draw by weight among the allowed steps, preferring steps that are reachable at once; `suits`: whether the
        dancers stand, and the duration of a measure [s]."""
        standing, measure_s = suits
        weights = self._weights(table, place, measure)
        steps = np.array(table.steps)
        hops = self._graph.hops[steps][:, nodes].max(axis=1, initial=0)
        possible = weights > 0.0
        near = possible & near_tempo(self._graph, table.steps, measure_s)
        possible = near if near.any() else possible
        still = possible & np.array([is_in_place(self._graph, step) for step in table.steps])
        for good in ([still & (hops <= 1)] if standing else []) + [
            possible & (hops <= 1),
            possible & (hops < UNREACHABLE),
        ]:
            if good.any():
                possible = good
                break
        weights = np.where(possible, weights, 0.0)
        seeds = [self._seed, STEP_SALT, place.section + 1, place.turn, self._group, max(place.measure, 0)]
        if not self._score.playhead.entered(measure):  # a held measure must not repeat the same draw
            seeds.append(measure)
        chance = float(np.random.default_rng(seeds).random())
        row = int(np.searchsorted(np.cumsum(weights), chance * weights.sum(), side="right"))
        return int(steps[min(row, len(steps) - 1)])

    def _weights(self, table: ImproviseTable, place: Place, measure: int) -> npt.NDArray[np.float64]:
        """Return the current step weights: limits, then the music rules, skipping any that would leave no step."""
        step, run = self._run(measure)
        allowed = table.weights.copy()
        if run >= table.settings.most and step in table.steps:
            allowed[table.steps.index(step)] = 0.0
        if not allowed.any():
            allowed = table.weights.copy()
        others = allowed.copy()
        if table.caller != NO_INDEX and table.settings.answer == "other" and self._is_response(table, place):
            size = table.settings.phrase
            called = measure - (place.measure - table.begin) % size - size
            phrase = (self._history.step_at(table.caller, m) for m in range(called, called + size))
            danced = {said[0] for said in phrase if said is not None}
            others[[step in danced for step in table.steps]] = 0.0
        if not others.any():
            others = allowed
        favoured = others.copy()
        for rule, factors in zip(table.settings.rule, table.factors, strict=True):
            value = self._mood.value(rule.of)
            if (rule.above is None or value >= rule.above) and (rule.below is None or value <= rule.below):
                favoured *= factors
        return favoured if favoured.any() else others


MOTION_SALT = 0x307
"""Salt that separates these random numbers from those of steps."""


class ImprovisedMotion:
    """Drawer for the `[[improvise.motion]]` entries of a patch, seeded by (seed, section, turn, table, measure)."""

    def __init__(self, sections: tuple[ImproviseSection, ...], score: Score, seed: int) -> None:
        self._score, self._seed = score, seed
        self._tables: list[tuple[int, int, int, int | None, ImproviseSection]] = []
        for index, section in enumerate(sections):
            place = score.place_of(section.section, section.measure)
            if place is not None and section.motion:
                end = place[1] + section.measures if section.measures is not None else None
                self._tables.append((index, place[0], place[1], end, section))

    def apply_patch(self, fresh: "ImprovisedMotion") -> None:
        """Adopt the tables of an edited patch."""
        self._tables = fresh._tables

    def calls(self, measure: int, time: float) -> list[ControlEvent]:
        """Return the calls drawn at the line of `measure` (from 0), if a phrase begins there."""
        if measure < 0 or not self._score.playhead.entered(measure):
            return []
        place = self._score.place(measure)
        called: list[ControlEvent] = []
        for index, section, begin, end, asked in self._tables:
            if place.section != section or place.measure < begin or (end is not None and place.measure >= end):
                continue
            if (place.measure - begin) % asked.phrase:
                continue
            chance = np.random.default_rng(
                (self._seed, MOTION_SALT, place.section + 1, place.turn, index, place.measure)
            )
            weights = np.cumsum([item.weight for item in asked.motion])
            row = int(np.searchsorted(weights, float(chance.random()) * weights[-1], side="right"))
            item = asked.motion[min(row, len(asked.motion) - 1)]
            event = None if item.call is None else REGISTRY.call(item.call, item.values, time, "score")
            if isinstance(event, ControlEvent):
                called.append(event)
        return called
