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
from live.clock.follower.manual_control import Seed
from live.clock.ticks import TICK
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import Choosing
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import TextureBank
from live.show.audience.audience import Audience
from live.show.capture.capture_manager import Mocap
from live.show.circuit_breakers import Breakers
from live.show.dancers.dancers import Dancers
from live.show.dancers.live_texture import Texturing
from live.show.dancers.step_requests import Directions
from live.show.dancers.variation import Variation
from live.show.desk.light_desk import Desk
from live.show.desk.refusals import Refusals
from live.show.group.casting import Casting
from live.show.group.group_commands import GroupControls
from live.show.group.group_motion import GroupMotion
from live.show.measure_span import MeasureSpan
from live.show.partner.partner_pairs import check_partners
from live.show.partner.partner_response import Answering
from live.show.partner.partner_sources import AnswerBank
from live.show.patch.patch import Patch
from live.show.patch.patch_update import Prepared, Reloading
from live.show.score.group_programs import programmes_of
from live.show.score.music_reactions import Reactions
from live.show.score.playhead import Playhead
from live.show.score.score_runner import Prompter
from live.show.selection.graph_update import NewSteps
from live.show.selection.initial_nodes import first_nodes
from live.show.selection.interrupts import Interrupts
from live.show.selection.scheduler import Scheduler
from live.show.sound.clock_commands import first_seeds, follower_of
from live.show.view.view_builder import Seen


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
        choosing: Choosing | None = None,
        bank: TextureBank | None = None,
        answers: AnswerBank | None = None,
        begin: bool = True,
    ) -> None:
        """`seed` and `tempo` [bpm] override the patch's; `reserve`: clips that events may add, by name; `choosing`:
        the selector prepared for the graph, if there is one; `bank`: motion for texturing upper bodies; `answers`:
        examples for partner responses. Without `begin` no measure begins, because a state will be restored.

        Raises UnknownStep for a step the library lacks.
        """
        self.patch = patch
        self.graph = graph
        self.seed = patch.seed if seed is None else seed
        self.follower = follower_of(patch, tempo)
        self._known = tempo is None
        self.timeline = self.follower.timeline
        self.casting = Casting(patch)
        self.casting.check()
        self.group = self.casting.group
        self.reactions = Reactions(patch)
        self.prompter = Prompter(patch, self.reactions, seed=self.seed)
        self.motion = GroupMotion(patch, self.casting, seed=self.seed, score=self.prompter.score)
        self.variation = Variation.of(patch, self.group, seed=self.seed, window=graph.window)
        self.dancers = Dancers(graph, self.variation, len(self.group))
        if bank is not None:
            beats = patch.clock.beats_per_measure
            self.dancers.texturing = Texturing(bank, self.variation, len(self.group), seed=self.seed, beats=beats)
        check_partners(patch, self.casting)
        self.answers = answers or AnswerBank(())
        """Examples for partner responses."""
        if answers is not None:
            self.dancers.answering = Answering(patch, self.casting, self.variation, answers)
        programmes = programmes_of(patch, graph, self.seed, self.prompter.score, self.prompter.mood)
        self.scheduler = Scheduler(patch, self.dancers, self.motion, programmes, self.group, choosing)
        self.interrupts = Interrupts(patch, self.dancers, self.motion, self.scheduler)
        self._controls = GroupControls(patch, self.motion, self.dancers, self.variation, self.prompter.score)
        self.span = MeasureSpan.at(self.timeline, self.timeline.beat_at(0.0))
        node = first_nodes(graph, self.scheduler, self.group, self.motion.partners.mirrored, self.span.number)
        self.dancers.start(node, self.state.position.astype(np.float64), self.motion.starting_heading)
        self.scheduler.aims.headings.begin(self.motion.starting_heading)
        self.mocap = Mocap(patch, self.motion, self.dancers, self.scheduler)
        self.desk = Desk(patch, self.prompter, self.motion, self.scheduler, self.variation, self.mocap)
        self.audience = Audience(patch.audience, seed=self.seed)
        self.blackout = False
        self.brightness = 1.0
        self.time = 0.0
        self.refusals = Refusals()
        self.breakers = Breakers()
        """Circuit breakers of the stages of a tick."""
        self._beat, self._beats_per_tick = self.timeline.beat_at(0.0), self.timeline.tempo * TICK / 60.0
        self.directions = Directions(
            patch, self.casting, self.dancers, self.variation, self.scheduler, self.interrupts, self.refusals
        )
        self._seen = Seen(self.dancers, self.motion, self.group, self.desk, self.audience)
        self._new_steps = NewSteps(reserve, self.refusals)
        self.reloading = Reloading(self.refusals)
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
        return self.prompter.playhead

    @property
    def danced(self) -> float:
        """Danced beats so far: (measure number + fraction) times beats per measure; the unit of `prompter.agenda`."""
        return self.span.danced(self.timeline.beat_at(self.time), self.patch.clock.beats_per_measure)

    def seed_tracker(self, told: Callable[[Seed], None]) -> None:
        """Send beat tracker seeds to `told`, now and in future. Thread: the show's calls it."""
        for seed in first_seeds(self.patch, self.follower, self._known):
            told(seed)
        self.follower.on_seed = told


_PARTS: Final = "live.show."


def exchange(part: Any, fresh: Any, old: Patch, new: Patch) -> None:
    """Update `part` and all parts below it with the data that `fresh` and its parts have from the patch `new`.

    `take_patch` is called once for each part, outermost first, while the part still holds the `old` patch.
    """
    _exchange(part, fresh, old, new, set())


def _exchange(part: Any, fresh: Any, old: Patch, new: Patch, met: set[int]) -> None:
    met.add(id(part))
    take = getattr(part, "take_patch", None)
    if take is not None:
        take(fresh)
    for name, value in list(vars(part).items()):
        if value is old:
            setattr(part, name, new)
        elif type(value).__module__.startswith(_PARTS) and hasattr(value, "__dict__") and id(value) not in met:
            like = getattr(fresh, name, None)
            if type(like) is type(value) and like is not value:
                _exchange(value, like, old, new, met)


class Changeover(Assembly):
    """Hot swap of graph and patch. Other threads prepare both; the swap happens while no next measure is decided."""

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Store a graph for the event StepsAdded that names its library's hash. Thread: any."""
        self._new_steps.offer(library, graph)

    def another(self, patch: Patch, graph: MotionGraph) -> Self:
        """Return a fresh show of another patch with this show's seed; it must not be run. Slow. Thread: any."""
        choosing = self.scheduler.choosing  # safe to share: the new show does not run
        known, bank = choosing if choosing.graph is graph else None, self.dancers.texturing.bank
        answers = None if self.dancers.answering is None else self.answers
        return type(self)(patch, graph, seed=self.seed, choosing=known, bank=bank, answers=answers)

    def offer_patch(self, prepared: Prepared) -> None:
        """Store a patch for the event PatchChanged that names its version. Thread: any."""
        self.reloading.offer(prepared)

    @property
    def latest_graph(self) -> MotionGraph:
        """The graph in use, or the one that replaces it at the next measure line."""
        return self._new_steps.coming or self.graph

    def _take_patch(self) -> None:
        """Apply an edited patch, if there is one. Call only while no next measure is decided."""
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
        """Apply an extended graph, if there is one."""
        grown = self._new_steps.take(self.dancers)
        if grown is None:
            return
        self.graph, choosing = grown
        self.dancers.take_graph(self.graph)
        self.scheduler.take_graph(self.graph, choosing)
