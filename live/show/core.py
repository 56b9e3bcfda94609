"""Show: the deterministic core. Events and ticks in, states and views out; it reads no clock, device or disk.

The same patch, library, seed and (tick, event) list give bit-identical states, live or replayed.
"""

import hashlib
from collections.abc import Callable, Mapping
from typing import Any

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
from live.graph.insertion import insert_clips, stranded
from live.graph.live_sequence import HORIZON, LiveSequence
from live.graph.motion_graph import MotionGraph
from live.graph.wanted import parse_sequence
from live.motion.skeleton import JOINT_COUNT
from live.motion.step_clip import StepClip
from live.show.casting import Casting
from live.show.clock_events import CLOCK_EVENTS, first_seeds, follower_of, tell
from live.show.dancers import Dancers
from live.show.echo import Echo
from live.show.group_controls import GROUP_EVENTS, GroupControls
from live.show.group_motion import GroupMotion
from live.show.interrupts import Interrupts
from live.show.measure import MeasureSpan
from live.show.patch import Patch
from live.show.programme import UnknownStep, find_step
from live.show.programmes import programmes_of
from live.show.reactions import Reactions
from live.show.ripple import parse_ripple
from live.show.scheduler import Scheduler
from live.show.variation import Variation, Variety, varieties_of

FADE_HALFLIFE = 0.06
"""Half-life of a blackout's fade [s]: dark within a fifth of a second, without a flash."""
SHORTEST_RETIME = 0.5
"""A measure is never re-timed to end within fewer beats than this."""
LEAP = 1e-6
"""The clock's beat has jumped if it is so far [beats] from where the last tick's Timeline takes it."""
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
    ) -> None:
        """`seed` and `tempo` [bpm] override the patch's; `reserve` holds clips that events may add, by name.

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
        self.motion = GroupMotion(patch, self.casting, seed=self.seed)
        self._group_names = {section.name.casefold(): index for index, section in enumerate(patch.group)}
        beats = patch.clock.beats_per_measure
        self.variation = Variation(
            varieties_of(patch),
            self.group,
            seed=self.seed,
            beats_per_measure=beats,
            window=graph.window,
            late=tuple(float(section.beats_later % beats) for section in patch.group),
            ripples=tuple(parse_ripple(section.ripple, section.ripple_beats) for section in patch.group),
        )
        self.dancers = Dancers(graph, self.variation, len(self.group))
        programmes = programmes_of(patch, graph, self.seed)
        self.scheduler = Scheduler(patch, self.dancers, self.motion, programmes, self.group)
        self.interrupts = Interrupts(patch, self.dancers, self.motion, self.scheduler)
        self._controls = GroupControls(patch, self.motion, self.dancers, self.variation)
        self.span = MeasureSpan.at(self.timeline, self.timeline.beat_at(0.0))
        self._start_dancers()
        self.reactions = Reactions(patch)
        self.blackout = False
        self.brightness = 1.0
        self.time = 0.0
        self._reserve = dict(reserve or {})
        self._offered: dict[str, tuple[MotionGraph, Choosing]] = {}
        self._next_graph: tuple[MotionGraph, Choosing] | None = None
        self.asked: int | None = None
        """The dancer of whom somebody wants to know why she dances what she dances, None for nobody."""
        self.refused = 0
        """Events that asked for something the show does not have (a step that is not there)."""
        self.refusal = ""
        """The last such event in words, for the operator."""
        self._begin_measure(self.span.end - self.timeline.beats_per_measure)

    @property
    def state(self) -> AgentState:
        """The agents now."""
        return self.motion.state

    def _start_dancers(self) -> None:
        """Everybody begins with her group's first step, on the spot if that lets the sequence go on."""
        graph, library = self.graph, self.graph.library
        node = np.zeros(len(self.group), np.int32)
        for index in self.scheduler.order:
            programme = self.scheduler.programmes[index]
            entries = graph.entries(programme.wanted(self.span.number, node[self.group == index]))
            ahead = self.scheduler.foresight.sequence(programme.coming, programme.into)[entries]
            cost = ahead + 0.1 * np.hypot(*library.node_travel[entries].T)
            members, side = self.group == index, library.node_side[entries]
            node[members] = entries[np.argmin(cost)]
            other = members & self.motion.partners.mirrored
            node[other] = entries[np.argmin(cost + (side == library.node_side[node[other][:1]].sum()))]
        self.dancers.start(node, self.state.position.astype(np.float64), self.motion.starting_heading)
        self.scheduler.aims.headings.begin(self.motion.starting_heading)

    # -- events ------------------------------------------------------------------------------------------------

    def apply(self, event: ControlEvent) -> bool:
        """Let an event act, from the next tick on; False if it asked for what is not there (which is counted)."""
        before = self.refused + self.follower.rejected
        if isinstance(event, events.MusicHeard):
            self._hear(event)
        else:
            self._act_on(event)
        return self.refused + self.follower.rejected == before

    def _hear(self, event: events.MusicHeard) -> None:
        """What the music is like changes what the patch says it changes."""
        for change in self.reactions.hear(event):
            self._act_on(change)
        self.motion.elements.gain = self.reactions.strength

    def _act_on(self, event: ControlEvent) -> None:
        if isinstance(event, GROUP_EVENTS):
            try:
                self._controls.act(event, time=self.time, timeline=self.timeline, span=self.span)
            except PersonError as error:
                self._refuse(f"{event.source}: {error}")
            return
        if isinstance(event, CLOCK_EVENTS):
            self._tell_clock(event)
            return
        match event:
            case events.Clear():
                self._controls.clear(self.time, self.timeline)
                self.interrupts.clear()
                for programme in self.scheduler.programmes:
                    programme.release()
            case events.CallStep() | events.StepNow():
                self._call_step(event)
            case events.StepsAdded():
                self._add_steps(event)
            case events.SetSequence():
                self._set_sequence(event)
            case events.SetMotion() | events.SetFacing() | events.AskWhy():
                self._set(event)
            case events.Blackout():
                self.blackout = event.on
            case events.TicksSkipped():
                self.time += event.count * TICK

    def _tell_clock(self, event: ControlEvent) -> None:
        words = tell(self.follower, event)
        if words:
            self._refuse(f"{event.source}: {words}")

    def seed_tracker(self, told: Callable[[Seed], None]) -> None:
        """Tell `told`, now and in future, what a tracker of sound should know. Thread: the show's calls it."""
        for seed in first_seeds(self.patch, self.follower, self._known):
            told(seed)
        self.follower.on_seed = told

    def _call_step(self, event: events.CallStep | events.StepNow) -> None:
        try:
            if isinstance(event, events.StepNow):
                self.interrupts.cue(event)
                return
            step = find_step(self.graph, event.name)
        except (UnknownStep, PersonError) as error:
            self._refuse(f"{event.source}: {error}")
            return
        members = self._members(event.group)
        if members is None:
            self._refuse(f"{event.source}: no group is called {event.group!r}")
            return
        for index in members:
            self.scheduler.programmes[index].call(step, measures=event.measures)

    def offer(self, library: str, graph: MotionGraph) -> None:
        """Hold a graph ready for the event StepsAdded that names its library's hash. Thread: any."""
        self._offered[library] = graph, Choosing.of(graph)

    def _add_steps(self, event: events.StepsAdded) -> None:
        offered = self._offered.pop(event.library, None)
        if offered is None:  # a replay has no thread that would have joined them
            keys = event.clips.split("\n")
            if any(key not in self._reserve for key in keys):
                self._refuse(f"{event.source}: the new steps are not there any more")
                return
            known = self.graph if self._next_graph is None else self._next_graph[0]
            graph = insert_clips(known, [self._reserve[key] for key in keys])
            offered = graph, Choosing.of(graph)
        self._next_graph = offered

    def _take_graph(self) -> None:
        """Dance in the new graph, unless it would leave somebody without a way on."""
        offered, self._next_graph = self._next_graph, None
        if offered is None:
            return
        graph, choosing = offered
        if stranded(graph, self.dancers.node).any():
            self._refuse("library: the new steps would leave dancers without a next step; they wait")
            return
        self.graph = graph
        self.dancers.take_graph(graph)
        self.scheduler.take_graph(graph, choosing)

    def _set_sequence(self, event: events.SetSequence) -> None:
        """Change what a group dances, if its dancers can dance it within two measures; else the dance goes on."""
        members = self._members(event.group)
        if members is None:
            self._refuse(f"{event.source}: no group is called {event.group!r}")
            return
        try:
            wanted = parse_sequence(event.steps, self.graph.library)
        except PersonError as error:
            self._refuse(f"{event.source}: {error}")
            return
        danced = self.dancers.coming if self.dancers.decided else self.dancers.present
        nodes = danced.node[np.isin(self.group, members)]
        if LiveSequence(self.graph, []).ask(wanted[: HORIZON + 1], nodes) is None:
            self._refuse(f"{event.source}: {event.steps!r} cannot be joined from here; live dance says what is missing")
            return
        for index in members:
            programme = self.scheduler.programmes[index]
            if len(members) == 1 or not isinstance(programme, Echo):  # all together, those who echo go on echoing
                programme.dance(wanted)

    def _set(self, event: events.SetMotion | events.SetFacing | events.AskWhy) -> None:
        match event:
            case events.SetMotion():
                self._set_motion(event)
            case events.SetFacing():
                self._set_facing(event)
            case events.AskWhy():
                self.asked = event.dancer - 1 if 1 <= event.dancer <= len(self.group) else None

    def _set_motion(self, event: events.SetMotion) -> None:
        members = self._members(event.group)
        if members is None or event.parameter not in Variety.names():
            self._refuse(f"{event.source}: nothing to set for {event.parameter!r} of group {event.group!r}")
            return
        for index in members:
            self.variation.set(event.parameter, event.value, index)

    def _set_facing(self, event: events.SetFacing) -> None:
        headings, members = self.scheduler.aims.headings, self._members(event.group)
        try:
            facing = headings.parse(event.facing)
        except PersonError as error:
            self._refuse(f"{event.source}: {error}")
            return
        if members is None:
            self._refuse(f"{event.source}: no group is called {event.group!r}")
            return
        for index in members:
            headings.set(index, facing)

    def _members(self, name: str) -> list[int] | None:
        """The groups that a name means, by index: "" and "*" are all; None if there is no such group."""
        if name in ("", "*"):
            return list(range(len(self._group_names)))
        index = self._group_names.get(name.casefold())
        return None if index is None else [index]

    def _refuse(self, words: str) -> None:
        self.refused += 1
        self.refusal = words

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
            self._cross_measure_line(time)
            crossed = True
        self.scheduler.work(self.span, self.timeline, time)
        self.interrupts.tick(self.span, self.timeline, time)
        carrying, fraction = self.scheduler.carrying, self.span.fraction(beat)
        speed, dancer = self.scheduler.speed, carrying.reference
        self.motion.tick(time, self.timeline, self.span, speed=speed, dancer=dancer, pace=carrying.pace)
        carrying.tick(fraction, self.timeline.tempo / (60.0 * self.timeline.beats_per_measure))
        self.dancers.tick(fraction, time, TICK)
        partners = self.motion.partners
        self.dancers.hands.tick(partners.other, partners.hand, TICK, self.timeline.tempo)
        self.brightness = damper(self.brightness, 0.0 if self.blackout else 1.0, FADE_HALFLIFE, TICK)
        return crossed

    def _cross_measure_line(self, time: float) -> None:
        if not self.dancers.decided:
            self.scheduler.decide(self.span, self.timeline, time)
        line = self.span.end
        self.scheduler.carrying.cross_measure_line()
        self.dancers.cross_measure_line()
        self._take_graph()
        self.span = self.span.next(self.timeline)
        self._begin_measure(line)
        for change in self.reactions.cross_measure_line(time):
            self._act_on(change)

    def _begin_measure(self, beat: float) -> None:
        self._controls.cross_measure_line(self.span.number)
        self.variation.begin_measure(self.span.number)
        timing = self.motion.partners.timing()
        self.variation.delay(timing, self.state.position, self.motion.present, self.dancers.present)
        self.scheduler.set_speed(self.span.number, self.timeline)
        heading = self.dancers.present.begin_heading()
        try:
            entered = self.motion.begin_measure(self.span, beat, self.timeline, heading)
        except PersonError as error:  # a score that asks for the impossible in measure 200 stops no show
            self._refuse(f"score: {error}")
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
        if self.asked is None:
            return None
        return self.scheduler.choices.why(self.asked, self.scheduler.choosing)

    # -- what is seen ------------------------------------------------------------------------------------------

    def view(self) -> StageView:
        """An empty drawing snapshot of the right size, to be filled each frame."""
        return StageView.allocate(len(self.group), JOINT_COUNT)

    def fill(self, view: StageView, time: float) -> None:
        """Fill the snapshot for `time` [s]: poses at the exact beat, at most a tick after the last one."""
        beat = self.timeline.beat_at(time)
        fraction = self.span.fraction(beat)
        self.dancers.pose(fraction, time, out=(view.joint_position, view.joint_rotation))
        self.motion.show(view)
        view.group[:] = self.group
        view.time, view.beat, view.tempo = time, beat, self.follower.tempo
        view.measure, view.beats_per_measure = self.span.number, self.timeline.beats_per_measure
        view.phase = fraction * self.timeline.beats_per_measure
        view.brightness = self.brightness

    def state_hash(self) -> str:
        """A short hash over every bit of the agents' and dancers' states and the poses of this tick."""
        digest = hashlib.blake2b(digest_size=8)
        dancers = self.dancers
        beat = self.timeline.beat_at(self.time)
        position, rotation = dancers.pose(self.span.fraction(beat), self.time)
        danced = dancers.present
        for array in (
            self.state.flat, self.motion.entrances.state, self.group, danced.node, danced.placement, danced.correction,
            danced.aimed, danced.take, danced.warp, dancers.lock.state, self.variation.phase, position, rotation,
            np.array([beat, self.timeline.tempo, self.brightness]),
        ):  # fmt: skip
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()
