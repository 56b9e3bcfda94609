"""Step program of a group: the wanted step for each measure, from a sequence, seeded chance, or calls."""

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
"""Minimum measures of a step drawn by chance."""


@dataclass(slots=True)
class _Call:
    """A called step, and its remaining measures."""

    step: int
    left: int
    done: int = 0


@dataclass(slots=True)
class _Place:
    """Position of a group in its program."""

    drawn: int
    """The last drawn step."""
    drawn_left: int = 0
    """Its remaining measures."""
    slot: int = 0
    into: int = 0
    """Entry of the sequence, and its measures already over."""
    call: _Call | None = None

    def copy(self) -> "_Place":
        """Return an independent copy."""
        return replace(self, call=None if self.call is None else replace(self.call))

    def begin_anew(self) -> None:
        """Return to the first entry."""
        self.slot, self.into, self.drawn_left = 0, 0, 0


@dataclass(frozen=True, slots=True)
class _Before:
    """State before the last request, for `take_back`."""

    asked: tuple[int, int] | None
    place: _Place
    kept: Kept | None


class GroupProgramme:
    """Wanted steps of one group, measure by measure. Seeded: the same seed and calls give the same dance.

    A called step interrupts the sequence, which then resumes. A step of several measures that was cut short starts
    again.
    """

    def __init__(self, graph: MotionGraph, group: GroupSection, *, seed: int, index: int) -> None:
        """Raises UnknownStep if the group names an unknown step."""
        self._graph = graph
        self._seed = (seed, index)
        self._random = group.choose == "random"
        entries = [parse_entry(entry) for entry in group.steps]
        key = "steps"
        try:
            self.steps = [find_step(graph, name) for name, _ in entries]
            """Steps named by the group."""
            key = "travel_step"
            self.travel_step = None if group.travel_step is None else find_step(graph, group.travel_step)
            """Step for distances too long for the current step, or None."""
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
        """Steps wanted from the last requested measure on, at least as far as the search horizon."""
        self.into = 0
        """Measures of the first of these already over at that measure."""
        self.part: Part | None = None
        """The group's part in the score; None: none."""
        self.stands = False
        """Whether the group stands; chance then prefers steps in place."""

    def take_patch(self, fresh: "GroupProgramme") -> None:
        """Adopt another program of this group; a sequence that is unchanged up to here continues."""
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
        """Dance `step` from the next unchosen measure on, for a number of measures (rounded up)."""
        for place in self._places:
            place.call = _Call(step, max(1, int(np.ceil(measures))))

    def take_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one; a group that drew from all steps also draws
        new ones."""
        old, self._graph = self._graph, graph
        if self.part is not None:
            self.part.take_graph(graph)
        everything = {step for step in range(len(old.library.steps)) if len(old.entries(step))}
        if self._random and everything <= set(self.steps):
            new = range(len(old.library.steps), len(graph.library.steps))
            self.steps += [step for step in new if len(graph.entries(step))]

    def dance(self, wanted: list[Wanted]) -> None:
        """Repeat these steps in order from the next unchosen measure on."""
        self._live = list(wanted)
        for place in self._places:
            place.call, place.slot, place.into = None, 0, 0

    @property
    def live(self) -> tuple[Wanted, ...]:
        """The sequence set live; empty: none."""
        return tuple(self._live)

    def release(self) -> None:
        """Clear a called step and a sequence set live; the patch's own steps start again."""
        for place in self._places:
            place.call = None
        self.improvise(False)
        if self._live:
            self._live = []
            for place in self._places:
                place.begin_anew()

    def improvise(self, on: bool) -> None:
        """Improvise from the next unchosen measure on, or follow the score."""
        if self.part is not None:
            self.part.improvise(on)

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps in `measure`: sequence, improvised, or the group's own."""
        return "own" if self.part is None else self.part.kind(measure)

    def take_back(self, measure: int) -> None:
        """Undo the answer for `measure`, which has not begun; it will be requested again."""
        if self._asked is not None and self._asked[0] == measure and self._before is not None:
            before, self._before = self._before, None
            self._asked, self._place = before.asked, before.place
            if self.part is not None and before.kept is not None:
                self.part.kept = before.kept

    @property
    def _places(self) -> list[_Place]:
        """The present position, and the one restored by `take_back`.

        Commands in between apply to both, because `take_back` does not undo commands.
        """
        return [self._place] if self._before is None else [self._place, self._before.place]

    @property
    def _slots(self) -> list[Wanted]:
        return self._live or self._own

    @property
    def _draws(self) -> bool:
        """Whether steps are drawn by chance; not while a sequence is set live."""
        return self._random and not self._live

    def wanted(self, measure: int, nodes: Nodes) -> int:
        """Return the step to dance in `measure`, ANY_STEP if any will do.

        Ask for measures in order, with the `nodes` of the dancers before it. Repeated requests for one measure give the
        same answer. Before the first downbeat (measures below 0) it is the first step.
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
        # a dancer within a step of several measures finishes it: a call waits until one dancer is free to follow it
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
        """Return the slot's step and advance by one measure."""
        entry = self._slots[self._place.slot]
        self.into, self.coming = self._place.into, self._slots_from(self._place.slot)
        self._place.into += 1
        if self._place.into >= entry.measures:
            self._place.slot, self._place.into = (self._place.slot + 1) % len(self._slots), 0
        return _step_of(entry)

    def _draw_next(self, measure: int, nodes: Nodes) -> int:
        """Return the drawn step until its measures are over, then draw another."""
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
        """Return the next steps of the sequence, at least one per measure of the horizon; none if drawn by chance."""
        if self._draws:
            return ()
        slots = self._slots
        return tuple(slots[(slot + n) % len(slots)] for n in range(HORIZON + 1))

    def _length(self, step: int) -> int:
        return length_of(self._graph, step)

    def _draw(self, measure: int, nodes: Nodes) -> int:
        """Draw among the group's steps with equal weights: not the last one, and reachable at once if possible."""
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
