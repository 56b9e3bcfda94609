"""Exchange of graph, patch and partners' examples while a show runs.

Another thread prepares the new graph or examples, or a fresh show of the new patch; the running show then takes over
from it. Both shows have the same parts in the same order. A part with data from the patch implements
`apply_patch(fresh)`; attributes that hold the patch itself are replaced by the new patch.
"""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol

from live.control.events import events
from live.control.events.event import ControlEvent
from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.show.desk.refusals import Refusals
from live.show.partner.example_updates import ExampleUpdates
from live.show.patch.patch import Patch
from live.show.patch.patch_update import PatchUpdates, PreparedPatch
from live.show.selection.graph_update import GraphUpdates
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.graph.select.selector import StepSelector
    from live.show.capture.seen_steps import SeenSteps
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.partner.example_bank import ExampleBank
    from live.show.selection.scheduler import Scheduler

_PARTS: Final = "live.show."


class FreshShow(Protocol):
    """A show that was built to be taken over from, and is never run."""

    hot_swap: "HotSwap"
    scheduler: "Scheduler"

    @property
    def patch(self) -> Patch:
        """The new patch."""
        ...

    @property
    def graph(self) -> MotionGraph:
        """Its graph."""
        ...


class HotSwap:
    """Patch and graph of one show, and those that will replace them, while no next measure is decided."""

    EVENTS = (events.StepsAdded, events.StepsChanged, events.PatchChanged, events.ExamplesChanged)

    def __init__(
        self,
        patch: Patch,
        graph: MotionGraph,
        dancers: "Dancers",
        scheduler: "Scheduler",
        motion: "GroupMotion",
        seen_steps: "SeenSteps",
        refusals: Refusals,
        *,
        assemble: Callable[..., "FreshShow"],
        seed: int,
        answers: "ExampleBank",
        reserve: Mapping[str, StepClip] | None,
        later_answers: Mapping[str, "ExampleBank"] | None = None,
    ) -> None:
        """`assemble` builds a show, with `seed` and `answers`; `reserve`: clips that events may add, by name;
        `later_answers`: examples that events may have taken over, by digest."""
        self.patch = patch
        """The patch in force."""
        self.graph = graph
        """The graph in use."""
        self.answers = answers
        """Examples for partner responses."""
        self.parts: tuple[Any, ...] = ()
        """The parts of the show with data from the patch, outermost first."""
        self.graph_updates = GraphUpdates(reserve, refusals)
        self.patch_updates = PatchUpdates(refusals)
        self.example_updates = ExampleUpdates(later_answers, refusals)
        self._refusals = refusals
        self._dancers, self._scheduler, self._motion = dancers, scheduler, motion
        self._seen_steps = seen_steps
        self._seed = seed
        self._assemble: Callable[..., FreshShow] | None = assemble

    def resume(
        self, fresh: "HotSwap", reserve: Mapping[str, StepClip], later_answers: Mapping[str, "ExampleBank"]
    ) -> None:
        """Take from an unused show what a snapshot lacks; clips and examples for later events as at the beginning."""
        self._assemble = fresh._assemble
        self.graph_updates.set_reserve(reserve)
        self.example_updates.set_reserve(later_answers)

    @property
    def at_rest(self) -> bool:
        """Whether neither a graph nor a patch nor examples wait."""
        return self.graph_updates.at_rest and self.patch_updates.waiting is None and self.example_updates.at_rest

    # -- preparation -------------------------------------------------------------------------------------------------

    def offer_graph(self, library: str, graph: MotionGraph) -> None:
        """Store a graph for the event StepsAdded that names its library's hash. Thread: any."""
        self.graph_updates.offer(library, graph)

    def offer_patch(self, prepared: PreparedPatch) -> None:
        """Store a patch for the event PatchChanged that names its version. Thread: any."""
        self.patch_updates.offer(prepared)

    def offer_examples(self, bank: "ExampleBank") -> None:
        """Store examples for the event ExamplesChanged that names their digest. Thread: any."""
        self.example_updates.offer(bank)

    @property
    def latest_graph(self) -> MotionGraph:
        """The graph in use, or the one that replaces it at the next measure line."""
        return self.graph_updates.waiting_graph or self.graph

    def make_show(self, patch: Patch, graph: MotionGraph) -> "FreshShow":
        """Return a fresh show of another patch with this show's seed; it must not be run. Slow. Thread: any."""
        assert self._assemble is not None
        choosing = self._scheduler.choosing  # safe to share: the new show does not run
        known, bank = choosing if choosing.graph is graph else None, self._dancers.texture.bank
        answers = None if self._dancers.partner_response is None else self.answers
        return self._assemble(patch, graph, seed=self._seed, selector=known, bank=bank, answers=answers)

    # -- stage EDITS -------------------------------------------------------------------------------------------------

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `EVENTS`: what it names is used as soon as possible."""
        match event:
            case events.StepsAdded() | events.StepsChanged():
                self.graph_updates.handle(event, self.graph)
            case events.PatchChanged():
                self.patch_updates.request(event, self.make_show, self.patch, self.latest_graph)
            case events.ExamplesChanged():
                self.example_updates.handle(event)

    def tick(self, now: Now) -> None:
        """Exchange the patch, or a graph with a step that was just learnt, if a new one waits and the plan of the next
        measure can still be dropped."""
        if self.graph_updates.at_once and self._scheduler.replan(now.span, now.timeline, now.time):
            self._apply_graph()
        if self.patch_updates.is_due(now.span.number) and self._scheduler.replan(now.span, now.timeline, now.time):
            self._apply_patch(now)

    def cross_measure_line(self, now: Now) -> None:
        """Exchange graph, examples and patch, if new ones wait."""
        self._apply_graph()
        self._apply_examples()
        self._apply_patch(now)

    def discard(self) -> None:
        """Discard what waits; its file has to be saved again."""
        self.patch_updates.discard()
        self.graph_updates.drop()
        self.example_updates.drop()

    def _apply_patch(self, now: Now) -> None:
        fresh: FreshShow | None = self.patch_updates.pop_ready(self.patch, self._dancers.node)
        if fresh is None:
            return
        self._apply_graph()
        if fresh.graph is not self.graph:
            self._set_graph(fresh.graph, fresh.scheduler.choosing)
        self.adopt(fresh)
        self._motion.withdraw(now.span.number + 1)

    def adopt(self, fresh: "FreshShow") -> None:
        """Give all parts the data that those of the `fresh` show have from its patch.

        `apply_patch` is called once for each part, outermost first, while the part still holds the old patch.
        """
        visited: set[int] = set()
        old, self.patch = self.patch, fresh.patch
        for part, like in zip(self.parts, fresh.hot_swap.parts, strict=True):
            if id(part) not in visited:
                _swap_patch(part, like, old, self.patch, visited)

    def _apply_graph(self) -> None:
        grown = self.graph_updates.pop(self._dancers)
        if grown is not None:
            self._set_graph(*grown)

    def _apply_examples(self) -> None:
        answering, bank = self._dancers.partner_response, self.example_updates.pop()
        if bank is None or answering is None:
            return
        try:
            lost = answering.set_bank(bank)
        except ValueError as error:
            self._refusals.add(f"examples: {error}")
            return
        self.answers = bank
        for words in lost:
            self._refusals.add(words)

    def _set_graph(self, graph: MotionGraph, choosing: "StepSelector") -> None:
        self.graph = graph
        self._dancers.set_graph(graph)
        self._scheduler.set_graph(graph, choosing)
        self._seen_steps.set_graph(graph)


def _swap_patch(part: Any, fresh: Any, old: Patch, new: Patch, visited: set[int]) -> None:
    visited.add(id(part))
    take = getattr(part, "apply_patch", None)
    if take is not None:
        take(fresh)
    for name, value in list(vars(part).items()):
        if value is old:
            setattr(part, name, new)
        elif type(value).__module__.startswith(_PARTS) and hasattr(value, "__dict__") and id(value) not in visited:
            like = getattr(fresh, name, None)
            if type(like) is type(value) and like is not value:
                _swap_patch(value, like, old, new, visited)
