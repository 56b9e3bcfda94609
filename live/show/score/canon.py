"""Echo: a group that dances what another one danced some measures ago (canon, T147)."""

from collections import OrderedDict
from typing import Final, Literal, Protocol

from live.graph.motion_graph import MotionGraph
from live.graph.search.sequence_spec import Wanted
from live.show.score.step_program import GroupProgramme, Nodes

REMEMBERED: Final = 80
"""Measures kept of what the other group was asked to dance: more than the longest canon."""


class Programme(Protocol):
    """Which step a group should dance in which measure: `GroupProgramme`, or its `Echo`."""

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
    """Says of each measure what `leader` said `measures` before; a sequence set for this group alone frees it.

    Calls reach the leader and come through in their time. The leader must be asked about a measure first.
    """

    def __init__(self, leader: GroupProgramme, own: GroupProgramme, *, measures: int) -> None:
        """`own`: the programme that a sequence set live goes to; `measures`: how much later, 0 to `REMEMBERED` - 1."""
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
        """Echo as another patch says."""
        self._later, self.travel_step = fresh._later, fresh.travel_step
        self._own.take_patch(fresh._own)
        self.steps = self._own.steps

    def follow(self, leader: GroupProgramme) -> None:
        """Echo this one from now on."""
        self._leader = leader

    def wanted(self, measure: int, nodes: Nodes) -> int:
        """The step to dance in `measure`; before the leader's first one, her first."""
        # whoever is free remembers what the leader dances all the same: she will follow again
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
        """A called step comes through from the leader; only a group that was freed dances it at once."""
        if self._free:
            self._own.call(step, measures=measures)

    def dance(self, wanted: list[Wanted]) -> None:
        """Dance these instead of what the leader danced."""
        self._free = True
        self._own.dance(wanted)

    @property
    def live(self) -> tuple[Wanted, ...]:
        """The sequence that was set live for this group alone; empty: none."""
        return self._own.live if self._free else ()

    def release(self) -> None:
        """Follow the leader again."""
        self._free = False
        self._own.release()

    def part_kind(self, measure: int) -> Literal["sequence", "improvised", "own"]:
        """Whose steps it dances in `measure`; what it echoes is its own."""
        return self._own.part_kind(measure)

    def improvise(self, on: bool) -> None:
        """Choose its steps itself, or echo again."""
        self._own.improvise(on)

    def take_back(self, measure: int) -> None:
        """What was said of `measure`, which has not begun, shall not have been."""
        self._own.take_back(measure)
        self._said.pop(measure, None)

    def take_graph(self, graph: MotionGraph) -> None:
        """Choose in a graph that has all nodes and steps of the old one."""
        self._own.take_graph(graph)
