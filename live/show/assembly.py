"""Construction of a show's parts from patch and graph, and hot swap of both while the show runs.

For a patch swap another thread builds a fresh show; the running show then takes over references from it. Both shows
have the same parts under the same attribute names. A part with data from the patch implements `take_patch(fresh)`;
attributes that hold the patch itself are replaced by the new patch.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Final, Self

import numpy as np

from live.agents.crowd.agent_state import AgentState
from live.clock.follower.manual_control import TrackerHint
from live.clock.ticks import TICK
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import TextureBank
from live.show.audience.audience import Audience
from live.show.capture.capture_manager import CaptureManager
from live.show.circuit_breakers import CircuitBreakers
from live.show.dancers.dancers import Dancers
from live.show.dancers.live_texture import LiveTexture
from live.show.dancers.step_requests import StepRequests
from live.show.dancers.variation import Variation
from live.show.desk.light_desk import LightDesk
from live.show.desk.refusals import Refusals
from live.show.group.casting import Casting
from live.show.group.group_commands import GroupCommands
from live.show.group.group_motion import GroupMotion
from live.show.measure_span import MeasureSpan
from live.show.partner.partner_pairs import check_partners
from live.show.partner.partner_response import PartnerResponse
from live.show.partner.partner_sources import ExampleBank
from live.show.patch.patch import Patch
from live.show.patch.patch_update import PatchUpdates, PreparedPatch
from live.show.score.group_programs import build_programs
from live.show.score.music_reactions import Reactions
from live.show.score.playhead import Playhead
from live.show.score.score_runner import ScoreRunner
from live.show.selection.graph_update import GraphUpdates
from live.show.selection.initial_nodes import initial_nodes
from live.show.selection.interrupts import Interrupts
from live.show.selection.scheduler import Scheduler
from live.show.sound.clock_commands import initial_seeds, make_follower
from live.show.view.view_builder import ViewBuilder


class Assembly(ABC):
    """The parts of a show, at the start of the first measure. `Show` runs them."""

    def __init__(
        self,
        patch: Patch,
        graph: MotionGraph,
        *,
        seed: int | None = None,
        tempo: float | None = None,
        reserve: Mapping[str, StepClip] | None = None,
        selector: StepSelector | None = None,
        bank: TextureBank | None = None,
        answers: ExampleBank | None = None,
        begin: bool = True,
    ) -> None:
        """`seed` and `tempo` [bpm] override the patch's; `reserve`: clips that events may add, by name; `selector`:
        the selector prepared for the graph, if there is one; `bank`: motion for texturing upper bodies; `answers`:
        examples for partner responses. Without `begin` no measure begins, because a state will be restored.

        Raises UnknownStep for a step the library lacks.
        """
        self.patch = patch
        self.graph = graph
        self.seed = patch.seed if seed is None else seed
        self.follower = make_follower(patch, tempo)
        self._known = tempo is None
        self.timeline = self.follower.timeline
        self.casting = Casting(patch)
        self.casting.check()
        self.group = self.casting.group
        self.reactions = Reactions(patch)
        self.score_runner = ScoreRunner(patch, self.reactions, seed=self.seed)
        self.motion = GroupMotion(patch, self.casting, seed=self.seed, score=self.score_runner.score)
        self.variation = Variation.of(patch, self.group, seed=self.seed, window=graph.window)
        self.dancers = Dancers(graph, self.variation, len(self.group))
        if bank is not None:
            beats = patch.clock.beats_per_measure
            self.dancers.texture = LiveTexture(bank, self.variation, len(self.group), seed=self.seed, beats=beats)
        check_partners(patch, self.casting)
        self.answers = answers or ExampleBank(())
        """Examples for partner responses."""
        if answers is not None:
            self.dancers.partner_response = PartnerResponse(patch, self.casting, self.variation, answers)
        programmes = build_programs(patch, graph, self.seed, self.score_runner.score, self.score_runner.mood)
        self.scheduler = Scheduler(patch, self.dancers, self.motion, programmes, self.group, selector)
        self.interrupts = Interrupts(patch, self.dancers, self.motion, self.scheduler)
        self._controls = GroupCommands(patch, self.motion, self.dancers, self.variation, self.score_runner.score)
        self.span = MeasureSpan.at(self.timeline, self.timeline.beat_at(0.0))
        node = initial_nodes(graph, self.scheduler, self.group, self.motion.partners.mirrored, self.span.number)
        self.dancers.start(node, self.state.position.astype(np.float64), self.motion.starting_heading)
        self.scheduler.targets.headings.reset(self.motion.starting_heading)
        self.mocap = CaptureManager(patch, self.motion, self.dancers, self.scheduler)
        self.desk = LightDesk(patch, self.score_runner, self.motion, self.scheduler, self.variation, self.mocap)
        self.audience = Audience(patch.audience, seed=self.seed)
        self.blackout = False
        self.brightness = 1.0
        self.time = 0.0
        self.refusals = Refusals()
        self.breakers = CircuitBreakers()
        """Circuit breakers of the stages of a tick."""
        self._beat, self._beats_per_tick = self.timeline.beat_at(0.0), self.timeline.tempo * TICK / 60.0
        self.directions = StepRequests(
            patch, self.casting, self.dancers, self.variation, self.scheduler, self.interrupts, self.refusals
        )
        self._view_builder = ViewBuilder(self.dancers, self.motion, self.group, self.desk, self.audience)
        self._new_steps = GraphUpdates(reserve, self.refusals)
        self.patch_updates = PatchUpdates(self.refusals)
        if begin:
            self._begin_measure(self.span.end - self.timeline.beats_per_measure)

    @abstractmethod
    def _begin_measure(self, beat: float) -> None:
        """Begin the measure `span` at `beat`."""

    @property
    def state(self) -> AgentState:
        """The current agent state."""
        return self.motion.state

    @property
    def playhead(self) -> Playhead:
        """The position in the score."""
        return self.score_runner.playhead

    @property
    def danced_beats(self) -> float:
        """Danced beats so far: (measure number + fraction) times beats per measure; unit of `beat_scheduler` too."""
        return self.span.danced_beats(self.timeline.beat_at(self.time), self.patch.clock.beats_per_measure)

    def seed_tracker(self, listener: Callable[[TrackerHint], None]) -> None:
        """Send beat tracker seeds to `listener`, now and in future. Thread: the show's calls it."""
        for seed in initial_seeds(self.patch, self.follower, self._known):
            listener(seed)
        self.follower.on_hint = listener


_PARTS: Final = "live.show."


def swap_patch(part: Any, fresh: Any, old: Patch, new: Patch) -> None:
    """Update `part` and all parts below it with the data that `fresh` and its parts have from the patch `new`.

    `apply_patch` is called once for each part, outermost first, while the part still holds the `old` patch.
    """
    _swap_patch(part, fresh, old, new, set())


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


class HotSwap(Assembly):
    """Hot swap of graph and patch. Other threads prepare both; the swap happens while no next measure is decided."""

    def offer_graph(self, library: str, graph: MotionGraph) -> None:
        """Store a graph for the event StepsAdded that names its library's hash. Thread: any."""
        self._new_steps.offer(library, graph)

    def make_show(self, patch: Patch, graph: MotionGraph) -> Self:
        """Return a fresh show of another patch with this show's seed; it must not be run. Slow. Thread: any."""
        choosing = self.scheduler.choosing  # safe to share: the new show does not run
        known, bank = choosing if choosing.graph is graph else None, self.dancers.texture.bank
        answers = None if self.dancers.partner_response is None else self.answers
        return type(self)(patch, graph, seed=self.seed, selector=known, bank=bank, answers=answers)

    def offer_patch(self, prepared: PreparedPatch) -> None:
        """Store a patch for the event PatchChanged that names its version. Thread: any."""
        self.patch_updates.offer(prepared)

    @property
    def latest_graph(self) -> MotionGraph:
        """The graph in use, or the one that replaces it at the next measure line."""
        return self._new_steps.waiting_graph or self.graph

    def _apply_patch(self) -> None:
        """Apply an edited patch, if there is one. Call only while no next measure is decided."""
        fresh = self.patch_updates.pop_ready(self.patch, self.dancers.node)
        if fresh is None:
            return
        self._apply_graph()
        if fresh.graph is not self.graph:
            self.graph = fresh.graph
            self.dancers.set_graph(self.graph)
            self.scheduler.set_graph(self.graph, fresh.scheduler.choosing)
        swap_patch(self, fresh, self.patch, fresh.patch)
        self.motion.withdraw(self.span.number + 1)

    def _apply_graph(self) -> None:
        """Apply an extended graph, if there is one."""
        grown = self._new_steps.pop(self.dancers)
        if grown is None:
            return
        self.graph, choosing = grown
        self.dancers.set_graph(self.graph)
        self.scheduler.set_graph(self.graph, choosing)
