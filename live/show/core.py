"""Show: the deterministic core. Events and ticks in, states and views out; it reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed.
"""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from live.agents.crowd.model import AgentState
from live.base.errors import PersonError
from live.base.kernels import damper
from live.base.stage_view import StageView
from live.clock.following.seed import Seed
from live.clock.moment import Moment
from live.clock.ticks import TICK
from live.control import events
from live.control.events import ControlEvent
from live.graph.choosing.choosing import Choosing
from live.graph.motion_graph import MotionGraph
from live.motion.step_clip import StepClip
from live.motion.texture.bank import TextureBank
from live.show.answer_bank import AnswerBank
from live.show.answer_pairs import check_partners
from live.show.answering import Answering
from live.show.audience import AUDIENCE_EVENTS, Audience
from live.show.casting import Casting
from live.show.clock_events import CLOCK_EVENTS, first_seeds, follower_of, tell
from live.show.dancers import Dancers
from live.show.desk import DESK_EVENTS, Desk
from live.show.directions import DIRECTIONS, Directions
from live.show.exchange import exchange
from live.show.first_nodes import first_nodes
from live.show.group_controls import GROUP_EVENTS, GroupControls
from live.show.group_motion import GroupMotion
from live.show.interrupts import Interrupts
from live.show.measure import MeasureSpan
from live.show.mocap import MOCAP_EVENTS, Mocap
from live.show.new_steps import NewSteps
from live.show.patch import Patch
from live.show.playhead import Playhead
from live.show.programmes import programmes_of
from live.show.prompter import SCORE_EVENTS, Prompter
from live.show.reactions import Reactions
from live.show.refusals import Refusals
from live.show.reloading import Prepared, Reloading
from live.show.scheduler import Scheduler
from live.show.seen import Seen
from live.show.texturing import Texturing
from live.show.variation import Variation

FADE_HALFLIFE = 0.06
"""Half-life of a blackout's fade [s]: dark within a fifth of a second, without a flash."""
SHORTEST_RETIME = 0.5
"""A measure is never re-timed to end within fewer beats than this."""
LEAP = 1e-6
"""The clock's beat has jumped if it is so far [beats] from where the last tick's Timeline takes it."""
FLOOR_AND_DESK = (*GROUP_EVENTS, *DESK_EVENTS)
"""Events that `_control` takes."""
CALLS_IN_TURN = 4
"""A signal may call what gives a signal ... so many times in one tick; the rest waits for the next."""
LINES_PER_TICK = 4
"""Measure lines crossed in one tick at most, should the tempo ever run away."""


class Show:
    """One show. Call `apply` for events, then `tick` for each due tick, and `fill` for each frame."""

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
    ) -> None:
        """`seed` and `tempo` [bpm] override the patch's; `reserve` holds clips that events may add, by name;
        `choosing` is what is prepared of the graph, if it is known; `bank` what upper bodies may be textured with;
        `answers` what partners answer from.

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
        """What partners answer from."""
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
        self.desk = Desk(patch, self.prompter, self.motion, self.scheduler, self.variation)
        self.audience = Audience(patch.audience, seed=self.seed)
        self.blackout = False
        self.brightness = 1.0
        self.time = 0.0
        self.refusals = Refusals()
        self.directions = Directions(
            patch, self.casting, self.dancers, self.variation, self.scheduler, self.interrupts, self.refusals
        )
        self._seen = Seen(self.dancers, self.motion, self.group, self.desk, self.audience)
        self._new_steps = NewSteps(reserve, self.refusals)
        self.reloading = Reloading(self.refusals)
        self._begin_measure(self.span.end - self.timeline.beats_per_measure)

    @property
    def state(self) -> AgentState:
        """The agents now."""
        return self.motion.state

    @property
    def playhead(self) -> Playhead:
        """Where the score is."""
        return self.prompter.playhead

    @property
    def danced(self) -> float:
        """Beats danced so far: (measure + how far it is) times the beats of a measure; those of `prompter.agenda`."""
        return self.span.danced(self.timeline.beat_at(self.time), self.patch.clock.beats_per_measure)

    # -- events ------------------------------------------------------------------------------------------------

    def apply(self, event: ControlEvent) -> bool:
        """Let an event act, from the next tick on; False if it asked for what is not there (which is counted)."""
        before = self.refusals.count + self.follower.rejected
        if isinstance(event, events.MusicHeard):
            self._hear(event)
        elif isinstance(event, events.NotesHeard):
            self._hear_notes(event)
        else:
            self.desk.edits.before(event)
            self._act_on(event)
            self.desk.edits.after(event)
        return self.refusals.count + self.follower.rejected == before

    def _hear(self, event: events.MusicHeard) -> None:
        """What the music is like changes what the patch says it changes."""
        for change in self.reactions.hear(event):
            self._act_on(change)
        for signal in self.prompter.hear(event):
            self._act_on(signal)
        self.prompter.take_reactions(self.danced, self.time)
        self.motion.elements.gain = self.reactions.strength

    def _hear_notes(self, event: events.NotesHeard) -> None:
        """What is played changes what the patch says it changes."""
        self.prompter.hear_notes(event)
        for change in self.reactions.hear_notes(event):
            self._act_on(change)
        self.motion.elements.gain = self.reactions.strength

    def _act_on(self, event: ControlEvent) -> None:
        for kinds, act in self._TOLD:
            if isinstance(event, kinds):
                act(self, event)
                return
        match event:
            case events.Clear():
                self._controls.clear(self.time, self.timeline)
                self.interrupts.clear()
                for programme in self.scheduler.programmes:
                    programme.release()
            case events.StepsAdded() | events.StepsChanged():
                self._new_steps.hear(event, self.graph)
            case events.PatchChanged():
                self.reloading.ask(event, self.another, self.patch, self.latest_graph)
            case events.Blackout():
                self.blackout = event.on
            case events.TicksSkipped():
                self.time += event.count * TICK
                self.desk.tick(self.timeline, event.count)

    def _control(self, event: ControlEvent) -> None:
        """What groups do on the floor, and what the desk says."""
        changes: list[ControlEvent] = []
        try:
            if isinstance(event, DESK_EVENTS):
                changes = self.desk.act(event, timeline=self.timeline, danced=self.danced)
            else:
                self._controls.act(event, time=self.time, timeline=self.timeline, span=self.span)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")
        if isinstance(event, events.FreezePicture):
            self._seen.keep(self.time, self.timeline, self.span, tempo=self.follower.tempo)
        for change in changes:
            self._act_on(change)

    def _direct(self, event: ControlEvent) -> None:
        """What directs steps and motion of groups."""
        self.desk.notice(event)
        self.directions.act(event)

    def _tell_audience(self, event: ControlEvent) -> None:
        """What the audience's phones want, or what the operator lets them."""
        known: dict[str, tuple[str, ...]] = {}
        if isinstance(event, events.AskVote):
            known = {"step": tuple(self.graph.library.steps), "scene": tuple(self.desk.scenes.names),
                     "look": tuple(look.name for look in self.patch.looks),
                     "cue": tuple(cue.name for cue in self.patch.cue)}  # fmt: skip
        try:
            self.audience.act(
                event, self.motion.elements, beat=self.timeline.beat_at(self.time), measure=self.span.number,
                beats_per_measure=self.timeline.beats_per_measure, position=self.state.position, known=known,
            )  # fmt: skip
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _tell_prompter(self, event: ControlEvent) -> None:
        """A signal is given, or the score goes elsewhere: what of the coming measure can still be planned anew is."""
        try:
            moved = self.prompter.act(event)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")
            return
        self.prompter.take_reactions(self.danced, self.time)
        if moved:
            self.motion.withdraw(self.span.number + 1)
            if not self.scheduler.plan_anew(self.span, self.timeline, self.time):
                self.prompter.came_late()

    def _tell_mocap(self, event: ControlEvent) -> None:
        """A captured performer moves, or something is said of her."""
        beat = self.span.danced(self.timeline.beat_at(event.time), self.patch.clock.beats_per_measure)
        try:
            self.mocap.act(event, beat=beat)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _tell_clock(self, event: ControlEvent) -> None:
        words = tell(self.follower, event)
        if words:
            self.refusals.add(f"{event.source}: {words}")

    _TOLD: ClassVar = (
        (FLOOR_AND_DESK, _control), (CLOCK_EVENTS, _tell_clock), (MOCAP_EVENTS, _tell_mocap), (DIRECTIONS, _direct),
        (SCORE_EVENTS, _tell_prompter), (AUDIENCE_EVENTS, _tell_audience),
    )  # fmt: skip
    """Who is told which events."""

    def seed_tracker(self, told: Callable[[Seed], None]) -> None:
        """Tell `told`, now and in future, what a tracker of sound should know. Thread: the show's calls it."""
        for seed in first_seeds(self.patch, self.follower, self._known):
            told(seed)
        self.follower.on_seed = told

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Hold a graph ready for the event StepsAdded that names its library's hash. Thread: any."""
        self._new_steps.offer(library, graph)

    def another(self, patch: Patch, graph: MotionGraph) -> "Show":
        """A fresh show of another patch, with this one's seed; not to be run. Takes a while; thread: any."""
        choosing = self.scheduler.choosing  # of a show that does not run nobody reads or changes it
        known, bank = choosing if choosing.graph is graph else None, self.dancers.texturing.bank
        answers = None if self.dancers.answering is None else self.answers
        return Show(patch, graph, seed=self.seed, choosing=known, bank=bank, answers=answers)

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

    # -- time --------------------------------------------------------------------------------------------------

    def tick(self, time: float) -> bool:
        """Advance to the tick at `time` [s]; True if a measure line was crossed."""
        self.time = time
        expected = self.timeline.beat_at(time)
        self.timeline = self.follower.advance(time)
        beat = self.timeline.beat_at(time)
        if abs(beat - expected) > LEAP:
            self.span.leap(self.timeline, expected, beat, shortest=SHORTEST_RETIME)
        self.span.follow(self.timeline, beat, shortest=SHORTEST_RETIME)
        crossed = False
        for _ in range(LINES_PER_TICK):
            if beat < self.span.end:
                break
            self._fire((self.span.number + 1) * self.patch.clock.beats_per_measure)
            self._cross_measure_line(time)
            crossed = True
        self.desk.tick(self.timeline)
        self.audience.tick()
        self._fire(self.danced)
        if self.reloading.due(self.span.number) and self.scheduler.plan_anew(self.span, self.timeline, time):
            self._take_patch()
        self.scheduler.work(self.span, self.timeline, time)
        self.interrupts.tick(self.span, self.timeline, time)
        carrying, fraction = self.scheduler.carrying, self.span.fraction(beat)
        speed, dancer = self.scheduler.speed, carrying.reference
        self.motion.tick(time, self.timeline, self.span, speed=speed, dancer=dancer, pace=carrying.pace)
        self.motion.go_along(self.dancers.answering, self.dancers.shown)
        carrying.tick(fraction, self.timeline.tempo / (60.0 * self.timeline.beats_per_measure))
        self.dancers.tick(fraction, time, TICK)
        self.mocap.tick(time, self.danced, self.timeline, self.span.end)
        self._answer(fraction, time)
        partners = self.motion.partners
        if len(partners.leader) or self.dancers.hands.held:
            self.dancers.hands.tick(partners.other, partners.hand, TICK, self.timeline.tempo)
        self.brightness = damper(self.brightness, 0.0 if self.blackout else 1.0, FADE_HALFLIFE, TICK)
        return crossed

    def _answer(self, fraction: float, time: float) -> None:
        """Who answers others is taken along; what she dances is told whoever reacts to it."""
        answering, state = self.dancers.answering, self.state
        if answering is None:
            return
        moved = self.dancers.answer(self.motion.staying, (state.position, state.velocity), fraction, time, TICK)
        rows = np.flatnonzero(moved.any(axis=1))
        if len(rows):
            self.scheduler.carrying.take_along(rows, moved[rows])
        for label in answering.take_fresh():
            self.reactions.unit(label)
            self.prompter.take_reactions(self.danced, time)

    def _fire(self, danced: float) -> None:
        """What waits for a beat up to `danced` happens, and what that calls at once."""
        for _ in range(CALLS_IN_TURN):
            due = [*self.prompter.agenda.fire(danced), *self.desk.fire(danced, self.time)]
            for event in due:
                self._act_on(event)
            if not due:
                return

    def _cross_measure_line(self, time: float) -> None:
        if not self.dancers.decided:
            self.scheduler.decide(self.span, self.timeline, time)
        line = self.span.end
        self.scheduler.carrying.cross_measure_line()
        self.dancers.cross_measure_line()
        self._take_graph()
        self._take_patch()
        self.span = self.span.next(self.timeline)
        self._begin_measure(line)
        for change in (*self.reactions.cross_measure_line(time), *self.desk.begin_measure(self.danced)):
            self._act_on(change)
        for change in self.audience.begin_measure(self.span.number, time):
            self._act_on(change)

    def _begin_measure(self, beat: float) -> None:
        self.prompter.begin_measure(self.span.number, self.time)
        if self.dancers.answering is not None:
            self.dancers.answering.begin_measure()
        self._controls.cross_measure_line(self.span.number)
        self.variation.begin_measure(self.span.number)
        timing = self.motion.partners.timing()
        self.variation.delay(timing, self.state.position, self.motion.present, self.dancers.present)
        self.scheduler.set_speed(self.span.number, self.timeline)
        heading = self.dancers.present.begin_heading()
        try:
            entered = self.motion.begin_measure(self.span, beat, self.timeline, heading)
        except PersonError as error:  # a score that asks for the impossible in measure 200 stops no show
            self.refusals.add(f"score: {error}")
            entered = np.zeros(0, np.intp)
        if len(entered):
            place = self.state.position[entered].astype(np.float64)
            way = self.motion.entrances.goal[entered] - place
            self.dancers.place(entered, place, np.arctan2(way[:, 0], way[:, 1]))
        self.scheduler.carrying.begin_measure(anew=bool(len(entered)))

    def moment(self, time: float) -> Moment:
        """Musical time at `time` [s]."""
        return Moment.of(self.timeline, time, self.follower.confidence)

    def why(self) -> dict[str, Any] | None:
        """Why the dancer somebody asked about dances what she dances, see `Choices.why`; None for nobody."""
        asked = self.directions.asked
        return None if asked is None else self.scheduler.choices.why(asked, self.scheduler.choosing)

    # -- what is seen ------------------------------------------------------------------------------------------

    def view(self) -> StageView:
        """An empty drawing snapshot of the right size, to be filled each frame."""
        return self._seen.view()

    def fill(self, view: StageView, time: float) -> None:
        """Fill the snapshot for `time` [s]: poses at the exact beat, at most a tick after the last one."""
        tempo, brightness = self.follower.tempo, self.brightness * self.desk.master.level
        self._seen.fill(view, time, self.timeline, self.span, tempo=tempo, brightness=brightness, ticked=self.time)

    def state_hash(self) -> str:
        """A short hash over every bit of the agents' and dancers' states and the poses of this tick."""
        brightness = self.brightness * self.desk.master.level
        return self._seen.state_hash(self.time, self.timeline, self.span, brightness=brightness)
