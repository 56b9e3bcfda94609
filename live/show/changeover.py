"""Changeover: a running show goes over to a graph that has grown, and to a patch that was edited."""

from typing import Self

from live.graph.motion_graph import MotionGraph
from live.show.assembly import Assembly
from live.show.exchange import exchange
from live.show.patch.patch import Patch
from live.show.patch.reloading import Prepared


class Changeover(Assembly):
    """What other threads prepared is held here, and taken while nobody's next measure is decided."""

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Hold a graph ready for the event StepsAdded that names its library's hash. Thread: any."""
        self._new_steps.offer(library, graph)

    def another(self, patch: Patch, graph: MotionGraph) -> Self:
        """A fresh show of another patch, with this one's seed; not to be run. Takes a while; thread: any."""
        choosing = self.scheduler.choosing  # of a show that does not run nobody reads or changes it
        known, bank = choosing if choosing.graph is graph else None, self.dancers.texturing.bank
        answers = None if self.dancers.answering is None else self.answers
        return type(self)(patch, graph, seed=self.seed, choosing=known, bank=bank, answers=answers)

    def offer_patch(self, prepared: Prepared) -> None:
        """Hold a patch ready for the event PatchChanged that names its version. Thread: any."""
        self.reloading.offer(prepared)

    @property
    def latest_graph(self) -> MotionGraph:
        """The graph that is danced, or that will be from the next measure line on."""
        return self._new_steps.coming or self.graph

    def _take_patch(self) -> None:
        """Go on as an edited patch says, if there is one. To be called while nobody's next measure is decided."""
        fresh = self.reloading.take(self.patch, self.dancers.node)
        if fresh is None:
            return
        self._take_graph()
        if fresh.graph is not self.graph:
            self.graph = fresh.graph
            self.dancers.take_graph(self.graph)
            self.scheduler.take_graph(self.graph, fresh.scheduler.choosing)
        exchange(self, fresh, self.patch, fresh.patch)
        self.motion.withdraw(self.span.number + 1)

    def _take_graph(self) -> None:
        """Dance in the graph that has grown, if there is one."""
        grown = self._new_steps.take(self.dancers)
        if grown is None:
            return
        self.graph, choosing = grown
        self.dancers.take_graph(self.graph)
        self.scheduler.take_graph(self.graph, choosing)
