"""Step program of a group: the wanted step for each measure, from a sequence, seeded chance, or calls."""

from copy import copy
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.live_sequence import HORIZON
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.structure_rules import UNREACHABLE
from live.show.patch.section_motion import GroupSection, parse_entry
from live.show.score.improviser import DrawState
from live.show.score.part import ANY_STEP, ScorePart
from live.show.score.step_names import UnknownStep, find_step, is_in_place, near_tempo, step_measures

Nodes = npt.NDArray[np.int32]

HOLD_MEASURES = 2
"""Minimum measures of a step drawn by chance."""


@dataclass(slots=True)
class _Call:
    """A called step, and its remaining measures."""

    step: int
    remaining: int
    done: int = 0


@dataclass(slots=True)
class _Position:
    """Position of a group in its program."""

    drawn_step: int
    """The last drawn step."""
    drawn_left: int = 0
    """Its remaining measures."""
    slot: int = 0
    measures_done: int = 0
    """Entry of the sequence, and its measures already over."""
    call: _Call | None = None

    def copy(self) -> "_Position":
        """Return an independent copy."""
        return replace(self, call=None if self.call is None else replace(self.call))

    def restart(self) -> None:
        """Return to the first entry."""
        self.slot, self.measures_done, self.drawn_left = 0, 0, 0


@dataclass(frozen=True, slots=True)
class _UndoState:
    """State before the last request, for `undo`."""

    answer: tuple[int, int] | None
    position: _Position
    draw_state: DrawState | None


class StepProgram:
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
            SequenceEntry(step, self._length(step))
            for step, (_, times) in zip(self.steps, entries, strict=True)
            for _ in range(times)
        ]
        self._live: list[SequenceEntry] = []
        self._answer: tuple[int, int] | None = None
        self._position = _Position(self.steps[0])
        self._undo_state: _UndoState | None = None
        self.upcoming: tuple[SequenceEntry, ...] = ()
        """Steps wanted from the last requested measure on, at least as far as the search horizon."""
        self.measures_done = 0
        """Measures of the first of these already over at that measure."""
        self.part: ScorePart | None = None
        """The group's part in the score; None: none."""
        self.standing = False
        """Whether the group stands; chance then prefers steps in place."""
        self.measure_s = 0.0
        """Duration of a measure [s]: chance prefers steps that were recorded near that tempo; 0: not known."""

    def apply_patch(self, fresh: "StepProgram") -> None:
        """Adopt another program of this group; a sequence that is unchanged up to here continues."""
        if (fresh._own, fresh._random, fresh.steps) != (self._own, self._random, self.steps):
            drawn = self._random or fresh._random
            for place in () if self._live else self._positions:
                here = place.slot + 1
                if drawn or here > len(fresh._own) or fresh._own[:here] != self._own[:here]:
                    place.restart()
            self._own, self._random, self.steps = fresh._own, fresh._random, fresh.steps
        self.travel_step = fresh.travel_step
        if self.part is not None and fresh.part is not None:
            self.part.apply_patch(fresh.part)

    def call(self, step: int, *, measures: float) -> None:
        """Dance `step` from the next unchosen measure on, for a number of measures (rounded up)."""
        for place in self._positions:
            place.call = _Call(step, max(1, int(np.ceil(measures))))

    def waits_for(self, step: int | None) -> bool:
        """Whether this step was called and no measure of it is decided."""
        call = self._position.call
        return call is not None and call.step == step and call.done == 0

    def end_call(self) -> None:
        """End a called step; the sequence resumes."""
        for place in self._positions:
            place.call = None

    def set_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one; a group that drew from all steps also draws
        new ones."""
        old, self._graph = self._graph, graph
        if self.part is not None:
            self.part.set_graph(graph)
        everything = {step for step in range(len(old.library.steps)) if len(old.entries(step))}
        if self._random and everything <= set(self.steps):
            new = range(len(old.library.steps), len(graph.library.steps))
            self.steps += [step for step in new if len(graph.entries(step))]

    def set_sequence(self, steps: list[SequenceEntry]) -> None:
        """Repeat these steps in order from the next unchosen measure on."""
        self._live = list(steps)
        for place in self._positions:
            place.call, place.slot, place.measures_done = None, 0, 0

    @property
    def live_sequence(self) -> tuple[SequenceEntry, ...]:
        """The sequence set live; empty: none."""
        return tuple(self._live)

    def release(self) -> None:
        """Clear a called step and a sequence set live; the patch's own steps start again."""
        self.end_call()
        self.improvise(False)
        if self._live:
            self._live = []
            for place in self._positions:
                place.restart()

    def improvise(self, on: bool) -> None:
        """Improvise from the next unchosen measure on, or follow the score."""
        if self.part is not None:
            self.part.improvise(on)

    @property
    def is_asked(self) -> bool:
        """Whether a step, a sequence or improvisation was requested, and still counts."""
        return bool(self._live) or self._position.call is not None or (self.part is not None and self.part.improvises)

    def attach(self, running: "StepProgram") -> None:
        """Take part in the show of another program."""
        if self.part is not None and running.part is not None:
            self.part.attach(running.part)

    def copy(self, number: int) -> "StepProgram":
        """Return an independent copy for the subgroup with this number."""
        other = copy(self)
        other._seed = (self._seed[0], number)
        other._live, other._position = list(self._live), self._position.copy()
        if self._undo_state is not None:
            other._undo_state = replace(self._undo_state, position=self._undo_state.position.copy())
        other.part = None if self.part is None else self.part.copy(number)
        return other

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps in `measure`: sequence, improvised, or the group's own."""
        return "own" if self.part is None else self.part.kind(measure)

    def undo(self, measure: int) -> None:
        """Undo the answer for `measure`, which has not begun; it will be requested again."""
        if self._answer is not None and self._answer[0] == measure and self._undo_state is not None:
            before, self._undo_state = self._undo_state, None
            self._answer, self._position = before.answer, before.position
            if self.part is not None and before.draw_state is not None:
                self.part.draw_state = before.draw_state

    @property
    def _positions(self) -> list[_Position]:
        """The present position, and the one restored by `undo`.

        Commands in between apply to both, because `undo` does not undo commands.
        """
        return [self._position] if self._undo_state is None else [self._position, self._undo_state.position]

    @property
    def _slots(self) -> list[SequenceEntry]:
        return self._live or self._own

    @property
    def _draws(self) -> bool:
        """Whether steps are drawn by chance; not while a sequence is set live."""
        return self._random and not self._live

    def step_for(self, measure: int, nodes: Nodes) -> int:
        """Return the step to dance in `measure`, ANY_STEP if any will do.

        Ask for measures in order, with the `nodes` of the dancers before it. Repeated requests for one measure give the
        same answer. Before the first downbeat (measures below 0) it is the first step.
        """
        if self._answer is not None and self._answer[0] == measure:
            return self._answer[1]
        self._undo_state = _UndoState(
            self._answer, self._position.copy(), None if self.part is None else self.part.draw_state
        )
        if measure < 0 and not self._draws:
            step = _step_of(self._slots[0])
            self.measures_done, self.upcoming = 0, (self._slots[0],)
        else:
            step = self._next(measure, nodes)
        if self.part is not None:
            self.part.record(measure, step, self.measures_done)
        self._answer = (measure, step)
        return step

    def _next(self, measure: int, nodes: Nodes) -> int:
        library = self._graph.library
        # a dancer within a step of several measures finishes it: a call waits until one dancer is free to follow it
        within = library.node_measure[nodes] < library.node_measures[nodes] - 1
        if self._position.call is not None and not (len(nodes) and within.all()):
            step = self._position.call.step
            length = self._length(step)
            again = -(-(self._position.call.remaining + self._position.call.done % length) // length)
            self.measures_done, self.upcoming = (
                self._position.call.done % length,
                (*[SequenceEntry(step, length)] * again, *self._slots_from(self._position.slot)),
            )
            self._position.call.remaining -= 1
            self._position.call.done += 1
            if self._position.call.remaining <= 0:
                self._position.call = None
            self._position.measures_done = 0
            self._position.drawn_left = 0
            return step
        if self.part is not None and not self._live:
            slots = self._slots_from(self._position.slot)
            told = self.part.choose(measure, nodes, slots, standing=self.standing, measure_s=self.measure_s)
            if told is not None:
                step, self.upcoming, self.measures_done = told
                self._position.measures_done = self._position.drawn_left = 0
                return step
        return self._draw_next(measure, nodes) if self._draws else self._sequence_next()

    def _sequence_next(self) -> int:
        """Return the slot's step and advance by one measure."""
        entry = self._slots[self._position.slot]
        self.measures_done, self.upcoming = self._position.measures_done, self._slots_from(self._position.slot)
        self._position.measures_done += 1
        if self._position.measures_done >= entry.measures:
            self._position.slot, self._position.measures_done = (self._position.slot + 1) % len(self._slots), 0
        return _step_of(entry)

    def _draw_next(self, measure: int, nodes: Nodes) -> int:
        """Return the drawn step until its measures are over, then draw another."""
        if self._position.drawn_left <= 0:
            self._position.drawn_step = self._draw(measure, nodes)
            length = self._length(self._position.drawn_step)
            self._position.drawn_left = length * -(-HOLD_MEASURES // length)
        length = self._length(self._position.drawn_step)
        self.measures_done = -self._position.drawn_left % length
        self.upcoming = (SequenceEntry(self._position.drawn_step, length),) * -(-self._position.drawn_left // length)
        self._position.drawn_left -= 1
        return self._position.drawn_step

    def _slots_from(self, slot: int) -> tuple[SequenceEntry, ...]:
        """Return the next steps of the sequence, at least one per measure of the horizon; none if drawn by chance."""
        if self._draws:
            return ()
        slots = self._slots
        return tuple(slots[(slot + n) % len(slots)] for n in range(HORIZON + 1))

    def _length(self, step: int) -> int:
        return step_measures(self._graph, step)

    def _draw(self, measure: int, nodes: Nodes) -> int:
        """Draw among the group's steps with equal weights: not the last one, and reachable at once if possible."""
        chance = np.random.default_rng([*self._seed, max(measure, 0)])
        near_it = near_tempo(self._graph, self.steps, self.measure_s)
        steps = [step for step, good in zip(self.steps, near_it, strict=True) if good] or self.steps
        hops = self._graph.hops[steps][:, nodes]
        near = [s for s, h in zip(steps, hops, strict=True) if (h <= 1).all()]
        far = [s for s, h in zip(steps, hops, strict=True) if (h < UNREACHABLE).all()]
        if self.standing and (still := [step for step in near if is_in_place(self._graph, step)]):
            near = still
        for choice in (near, far, steps):
            fresh = [step for step in choice if step != self._position.drawn_step]
            if fresh:
                return int(fresh[int(chance.integers(len(fresh)))])
        return self._position.drawn_step


def _step_of(entry: SequenceEntry) -> int:
    return ANY_STEP if entry.step is None else entry.step
