"""Programme: which step each group should dance in which measure: by sequence, by seeded chance, or as called."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import NEVER, MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import Wanted
from live.show.patch.section_motion import GroupSection, parse_entry
from live.show.score.improviser import Kept
from live.show.score.part import ANY_STEP, Part
from live.show.score.step_names import UnknownStep, find_step, in_place, length_of

Nodes = npt.NDArray[np.int32]

HOLD_MEASURES = 2
"""Measures for which a step drawn by chance is danced at least."""


@dataclass(slots=True)
class _Call:
    """A step called from outside, and how many measures of it are still to come."""

    step: int
    left: int
    done: int = 0


@dataclass(slots=True)
class _Place:
    """Where a group is in what it dances."""

    drawn: int
    """The step that was drawn last."""
    drawn_left: int = 0
    """Measures of it that are still to come."""
    slot: int = 0
    into: int = 0
    """The entry of the sequence, and how many of its measures are over."""
    call: _Call | None = None

    def copy(self) -> "_Place":
        """One that changes by itself."""
        return replace(self, call=None if self.call is None else replace(self.call))

    def begin_anew(self) -> None:
        """Back to the first entry."""
        self.slot, self.into, self.drawn_left = 0, 0, 0


@dataclass(frozen=True, slots=True)
class _Before:
    """What was so before a measure was asked for."""

    asked: tuple[int, int] | None
    place: _Place
    kept: Kept | None


class GroupProgramme:
    """The wishes of one group, measure after measure. Seeded: the same seed and calls give the same dance.

    A called step interrupts the sequence, which then goes on where it was; a step of several measures that was cut
    short is begun anew.
    """

    def __init__(self, graph: MotionGraph, group: GroupSection, *, seed: int, index: int) -> None:
        """Raises UnknownStep if the group names a step that is not there."""
        self._graph = graph
        self._seed = (seed, index)
        self._random = group.choose == "random"
        entries = [parse_entry(entry) for entry in group.steps]
        key = "steps"
        try:
            self.steps = [find_step(graph, name) for name, _ in entries]
            """The steps it names."""
            key = "travel_step"
            self.travel_step = None if group.travel_step is None else find_step(graph, group.travel_step)
            """The step for ways too far for the step in turn, or None."""
        except UnknownStep as error:
            unknown = UnknownStep(f"group {group.name!r}: {error}")
            unknown.place = ("group", index, key)
            raise unknown from None
        self._own = [
            Wanted(step, self._length(step))
            for step, (_, times) in zip(self.steps, entries, strict=True)
            for _ in range(times)
        ]
        self._live: list[Wanted] = []
        self._asked: tuple[int, int] | None = None
        self._place = _Place(self.steps[0])
        self._before: _Before | None = None
        self.coming: tuple[Wanted, ...] = ()
        """What is to be danced from the measure on that was last asked for, at least as far as a search looks."""
        self.into = 0
        """How many measures of the first of them are over by then."""
        self.part: Part | None = None
        """What the score has for the group; None: nothing."""
        self.stands = False
        """Whether the group stands: then chance draws among the steps that can be danced in place."""

    def take_patch(self, fresh: "GroupProgramme") -> None:
        """Dance what another programme of this group says; a sequence that was the same so far goes on."""
        if (fresh._own, fresh._random, fresh.steps) != (self._own, self._random, self.steps):
            drawn = self._random or fresh._random
            for place in () if self._live else self._places:
                here = place.slot + 1
                if drawn or here > len(fresh._own) or fresh._own[:here] != self._own[:here]:
                    place.begin_anew()
            self._own, self._random, self.steps = fresh._own, fresh._random, fresh.steps
        self.travel_step = fresh.travel_step
        if self.part is not None and fresh.part is not None:
            self.part.take_patch(fresh.part)

    def call(self, step: int, *, measures: float) -> None:
        """Dance `step` from the next measure on that is not chosen yet, for a number of measures (rounded up)."""
        for place in self._places:
            place.call = _Call(step, max(1, int(np.ceil(measures))))

    def take_graph(self, graph: MotionGraph) -> None:
        """Choose in a graph that has all nodes and steps of the old one; who drew from all steps draws the new, too."""
        old, self._graph = self._graph, graph
        if self.part is not None:
            self.part.take_graph(graph)
        everything = {step for step in range(len(old.library.steps)) if len(old.entries(step))}
        if self._random and everything <= set(self.steps):
            new = range(len(old.library.steps), len(graph.library.steps))
            self.steps += [step for step in new if len(graph.entries(step))]

    def dance(self, wanted: list[Wanted]) -> None:
        """Dance these in order, again and again, from the next measure on that is not chosen yet."""
        self._live = list(wanted)
        for place in self._places:
            place.call, place.slot, place.into = None, 0, 0

    @property
    def live(self) -> tuple[Wanted, ...]:
        """The sequence that was set live; empty: none."""
        return tuple(self._live)

    def release(self) -> None:
        """Forget a called step and a sequence set live: the patch's own begins anew."""
        for place in self._places:
            place.call = None
        self.improvise(False)
        if self._live:
            self._live = []
            for place in self._places:
                place.begin_anew()

    def improvise(self, on: bool) -> None:
        """Choose its steps itself from the next measure on that is not chosen yet, or dance what the score has."""
        if self.part is not None:
            self.part.improvise(on)

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Whose steps the group dances in `measure`: the score's, those it chooses itself, or its own."""
        return "own" if self.part is None else self.part.kind(measure)

    def take_back(self, measure: int) -> None:
        """What was said of `measure`, which has not begun, shall not have been: it will be asked for again."""
        if self._asked is not None and self._asked[0] == measure and self._before is not None:
            before, self._before = self._before, None
            self._asked, self._place = before.asked, before.place
            if self.part is not None and before.kept is not None:
                self.part.kept = before.kept

    @property
    def _places(self) -> list[_Place]:
        """Where the group is, and where it will be again if the last measure is taken back: what somebody asks for
        meanwhile concerns both, for that is not taken back, and another sequence has other entries."""
        return [self._place] if self._before is None else [self._place, self._before.place]

    @property
    def _slots(self) -> list[Wanted]:
        return self._live or self._own

    @property
    def _draws(self) -> bool:
        """Whether chance chooses: not while a sequence was set live."""
        return self._random and not self._live

    def wanted(self, measure: int, nodes: Nodes) -> int:
        """The step to dance in `measure`, ANY_STEP if any will do.

        To be asked in the order of the measures, for dancers who were in `nodes` before it. Asked again for the same
        measure it gives the same answer. Before the first downbeat (measures below 0) it is the first step.
        """
        if self._asked is not None and self._asked[0] == measure:
            return self._asked[1]
        self._before = _Before(self._asked, self._place.copy(), None if self.part is None else self.part.kept)
        if measure < 0 and not self._draws:
            step = _step_of(self._slots[0])
            self.into, self.coming = 0, (self._slots[0],)
        else:
            step = self._next(measure, nodes)
        if self.part is not None:
            self.part.note(measure, step, self.into)
        self._asked = (measure, step)
        return step

    def _next(self, measure: int, nodes: Nodes) -> int:
        library = self._graph.library
        # whoever is within a step of several measures finishes it: a call waits until somebody is free to follow it
        within = library.node_measure[nodes] < library.node_measures[nodes] - 1
        if self._place.call is not None and not (len(nodes) and within.all()):
            step = self._place.call.step
            length = self._length(step)
            again = -(-(self._place.call.left + self._place.call.done % length) // length)
            self.into, self.coming = (
                self._place.call.done % length,
                (*[Wanted(step, length)] * again, *self._slots_from(self._place.slot)),
            )
            self._place.call.left -= 1
            self._place.call.done += 1
            if self._place.call.left <= 0:
                self._place.call = None
            self._place.into = 0
            self._place.drawn_left = 0
            return step
        if self.part is not None and not self._live:
            told = self.part.told(measure, nodes, self._slots_from(self._place.slot), stands=self.stands)
            if told is not None:
                step, self.coming, self.into = told
                self._place.into = self._place.drawn_left = 0
                return step
        return self._draw_next(measure, nodes) if self._draws else self._sequence_next()

    def _sequence_next(self) -> int:
        """The slot's step, and one measure further."""
        entry = self._slots[self._place.slot]
        self.into, self.coming = self._place.into, self._slots_from(self._place.slot)
        self._place.into += 1
        if self._place.into >= entry.measures:
            self._place.slot, self._place.into = (self._place.slot + 1) % len(self._slots), 0
        return _step_of(entry)

    def _draw_next(self, measure: int, nodes: Nodes) -> int:
        """The drawn step until its measures are over, then another."""
        if self._place.drawn_left <= 0:
            self._place.drawn = self._draw(measure, nodes)
            length = self._length(self._place.drawn)
            self._place.drawn_left = length * -(-HOLD_MEASURES // length)
        length = self._length(self._place.drawn)
        self.into = -self._place.drawn_left % length
        self.coming = (Wanted(self._place.drawn, length),) * -(-self._place.drawn_left // length)
        self._place.drawn_left -= 1
        return self._place.drawn

    def _slots_from(self, slot: int) -> tuple[Wanted, ...]:
        """The next steps of the sequence, one for each measure of the horizon at least; none where chance draws."""
        if self._draws:
            return ()
        slots = self._slots
        return tuple(slots[(slot + n) % len(slots)] for n in range(HORIZON + 1))

    def _length(self, step: int) -> int:
        return length_of(self._graph, step)

    def _draw(self, measure: int, nodes: Nodes) -> int:
        """Draw among the group's steps, evenly; not the last one again, and reachable at once if any is."""
        chance = np.random.default_rng([*self._seed, max(measure, 0)])
        hops = self._graph.hops[self.steps][:, nodes]
        near = [s for s, h in zip(self.steps, hops, strict=True) if (h <= 1).all()]
        far = [s for s, h in zip(self.steps, hops, strict=True) if (h < NEVER).all()]
        if self.stands and (still := [step for step in near if in_place(self._graph, step)]):
            near = still
        for choice in (near, far, self.steps):
            fresh = [step for step in choice if step != self._place.drawn]
            if fresh:
                return int(fresh[int(chance.integers(len(fresh)))])
        return self._place.drawn


def _step_of(entry: Wanted) -> int:
    return ANY_STEP if entry.step is None else entry.step
