"""Canon between groups: a group that repeats another group's steps some measures later (T147)."""

from collections import OrderedDict
from typing import TYPE_CHECKING, Final, Literal, Protocol

from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import SequenceEntry

if TYPE_CHECKING:
    from live.show.score.step_program import Nodes, StepProgram


HISTORY_MEASURES: Final = 80
"""Measures of the leader's steps that are kept: more than the longest canon."""


class StepSource(Protocol):
    """Source of the wanted step of a group for each measure: `StepProgram`, or its `Canon`."""

    travel_step: int | None
    steps: list[int]
    upcoming: tuple[SequenceEntry, ...]
    measures_done: int

    def step_for(self, measure: int, nodes: "Nodes") -> int: ...
    def call(self, step: int, *, measures: float) -> None: ...
    def set_sequence(self, steps: list[SequenceEntry]) -> None: ...
    def release(self) -> None: ...
    def waits_for(self, step: int | None) -> bool: ...
    def end_call(self) -> None: ...
    @property
    def live_sequence(self) -> tuple[SequenceEntry, ...]: ...
    def set_graph(self, graph: MotionGraph) -> None: ...
    def undo(self, measure: int) -> None: ...
    @property
    def is_asked(self) -> bool: ...
    def attach(self, running: "StepProgram") -> None: ...
    def improvise(self, on: bool) -> None: ...
    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]: ...


class Canon:
    """Canon of `leader`: wants in each measure what the leader wanted some measures before.

    A sequence set for this group alone ends the canon until `release`. Called steps go to the leader and arrive here
    with the canon's delay. Ask the leader for a measure before the echo.
    """

    def __init__(self, leader: "StepProgram", own: "StepProgram", *, measures: int) -> None:
        """`own`: the program for sequences set live; `measures`: the delay, 0 to `HISTORY_MEASURES` - 1."""
        self._leader = leader
        self._own = own
        self._delay = measures
        self._detached = False
        self._leader_steps: OrderedDict[int, tuple[int, tuple[SequenceEntry, ...], int]] = OrderedDict()
        self.travel_step = own.travel_step
        self.steps = own.steps
        self.upcoming: tuple[SequenceEntry, ...] = ()
        self.measures_done = 0

    def apply_patch(self, fresh: "Canon") -> None:
        """Adopt the settings of an edited patch."""
        self._delay, self.travel_step = fresh._delay, fresh.travel_step
        self._own.apply_patch(fresh._own)
        self.steps = self._own.steps

    @property
    def own(self) -> "StepProgram":
        """The program for steps of its own."""
        return self._own

    @property
    def is_asked(self) -> bool:
        """Whether steps of its own were requested."""
        return self._own.is_asked

    def attach(self, running: "StepProgram") -> None:
        """Take part in the show of another program."""
        self._own.attach(running)

    def set_leader(self, leader: "StepProgram") -> None:
        """Repeat this leader from now on."""
        self._leader = leader

    def step_for(self, measure: int, nodes: "Nodes") -> int:
        """Return the step to dance in `measure`; before the leader's first measure, the leader's first step."""
        # the leader's steps are recorded during an own sequence too: the canon resumes after it
        self._leader_steps[measure] = (
            self._leader.step_for(measure, nodes),
            self._leader.upcoming,
            self._leader.measures_done,
        )
        if len(self._leader_steps) > HISTORY_MEASURES:
            self._leader_steps.popitem(last=False)
        if self._detached or (self._own.part is not None and self._own.part.has_entry(measure)):
            step = self._own.step_for(measure, nodes)
            self.upcoming, self.measures_done = self._own.upcoming, self._own.measures_done
            return step
        first = next(iter(self._leader_steps))
        step, self.upcoming, self.measures_done = self._leader_steps.get(
            measure - self._delay, self._leader_steps[first]
        )
        return step

    def call(self, step: int, *, measures: float) -> None:
        """Call a step at once if the group dances a sequence of its own; otherwise the call arrives from the leader."""
        if self._detached:
            self._own.call(step, measures=measures)

    def set_sequence(self, steps: list[SequenceEntry]) -> None:
        """Dance this sequence instead of the canon."""
        self._detached = True
        self._own.set_sequence(steps)

    @property
    def live_sequence(self) -> tuple[SequenceEntry, ...]:
        """The sequence set live for this group alone; empty: none."""
        return self._own.live_sequence if self._detached else ()

    def release(self) -> None:
        """Follow the leader again."""
        self._detached = False
        self._own.release()

    def waits_for(self, step: int | None) -> bool:
        """Whether this step was called and no measure of it is decided; a step called from the leader is not known."""
        return self._own.waits_for(step)

    def end_call(self) -> None:
        """End a called step of its own; one called from the leader ends there."""
        self._own.end_call()

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps of `measure`; repeated steps count as the group's own."""
        return self._own.part_kind(measure)

    def improvise(self, on: bool) -> None:
        """Switch improvisation on, or return to the canon."""
        self._own.improvise(on)

    def undo(self, measure: int) -> None:
        """Undo the answer for `measure`, which has not begun."""
        self._own.undo(measure)
        self._leader_steps.pop(measure, None)

    def set_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._own.set_graph(graph)
