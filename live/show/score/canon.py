"""Canon between groups: a group that repeats another group's steps some measures later (T147)."""

from collections import OrderedDict
from typing import Final, Literal, Protocol

from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import Wanted
from live.show.score.step_program import GroupProgramme, Nodes

REMEMBERED: Final = 80
"""Measures of the leader's steps that are kept: more than the longest canon."""


class Programme(Protocol):
    """Source of the wanted step of a group for each measure: `GroupProgramme`, or its `Echo`."""

    travel_step: int | None
    steps: list[int]
    coming: tuple[Wanted, ...]
    into: int

    def wanted(self, measure: int, nodes: Nodes) -> int: ...
    def call(self, step: int, *, measures: float) -> None: ...
    def dance(self, wanted: list[Wanted]) -> None: ...
    def release(self) -> None: ...
    @property
    def live(self) -> tuple[Wanted, ...]: ...
    def take_graph(self, graph: MotionGraph) -> None: ...
    def take_back(self, measure: int) -> None: ...
    def improvise(self, on: bool) -> None: ...
    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]: ...


class Echo:
    """Canon of `leader`: wants in each measure what the leader wanted some measures before.

    A sequence set for this group alone ends the canon until `release`. Called steps go to the leader and arrive here
    with the canon's delay. Ask the leader for a measure before the echo.
    """

    def __init__(self, leader: GroupProgramme, own: GroupProgramme, *, measures: int) -> None:
        """`own`: the program for sequences set live; `measures`: the delay, 0 to `REMEMBERED` - 1."""
        self._leader = leader
        self._own = own
        self._later = measures
        self._free = False
        self._said: OrderedDict[int, tuple[int, tuple[Wanted, ...], int]] = OrderedDict()
        self.travel_step = own.travel_step
        self.steps = own.steps
        self.coming: tuple[Wanted, ...] = ()
        self.into = 0

    def take_patch(self, fresh: "Echo") -> None:
        """Adopt the settings of an edited patch."""
        self._later, self.travel_step = fresh._later, fresh.travel_step
        self._own.take_patch(fresh._own)
        self.steps = self._own.steps

    def follow(self, leader: GroupProgramme) -> None:
        """Repeat this leader from now on."""
        self._leader = leader

    def wanted(self, measure: int, nodes: Nodes) -> int:
        """Return the step to dance in `measure`; before the leader's first measure, the leader's first step."""
        # the leader's steps are recorded during an own sequence too: the canon resumes after it
        self._said[measure] = (self._leader.wanted(measure, nodes), self._leader.coming, self._leader.into)
        if len(self._said) > REMEMBERED:
            self._said.popitem(last=False)
        if self._free or (self._own.part is not None and self._own.part.holds(measure)):
            step = self._own.wanted(measure, nodes)
            self.coming, self.into = self._own.coming, self._own.into
            return step
        first = next(iter(self._said))
        step, self.coming, self.into = self._said.get(measure - self._later, self._said[first])
        return step

    def call(self, step: int, *, measures: float) -> None:
        """Call a step at once if the group dances a sequence of its own; otherwise the call arrives from the leader."""
        if self._free:
            self._own.call(step, measures=measures)

    def dance(self, wanted: list[Wanted]) -> None:
        """Dance this sequence instead of the canon."""
        self._free = True
        self._own.dance(wanted)

    @property
    def live(self) -> tuple[Wanted, ...]:
        """The sequence set live for this group alone; empty: none."""
        return self._own.live if self._free else ()

    def release(self) -> None:
        """Follow the leader again."""
        self._free = False
        self._own.release()

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Return the origin of the steps of `measure`; repeated steps count as the group's own."""
        return self._own.part_kind(measure)

    def improvise(self, on: bool) -> None:
        """Switch improvisation on, or return to the canon."""
        self._own.improvise(on)

    def take_back(self, measure: int) -> None:
        """Undo the answer for `measure`, which has not begun."""
        self._own.take_back(measure)
        self._said.pop(measure, None)

    def take_graph(self, graph: MotionGraph) -> None:
        """Use a graph that contains all nodes and steps of the old one."""
        self._own.take_graph(graph)
