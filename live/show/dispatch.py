"""Dispatch: every event of a show goes to the part that it concerns."""

from typing import ClassVar

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.assembly import Changeover
from live.show.audience.audience import AUDIENCE_EVENTS
from live.show.capture.capture_manager import MOCAP_EVENTS
from live.show.circuit_breakers import Stage, out_of_service
from live.show.dancers.step_requests import DIRECTIONS
from live.show.desk.light_desk import DESK_EVENTS
from live.show.group.group_commands import GROUP_EVENTS
from live.show.score.score_runner import SCORE_EVENTS
from live.show.sound.clock_commands import CLOCK_EVENTS, tell

FLOOR_AND_DESK = (*GROUP_EVENTS, *DESK_EVENTS)
"""Events that `_control` takes."""


class Dispatch(Changeover):
    """Events from outside come by `apply`, those of the show itself by `_act_on`; refused ones are counted."""

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
        act = self._ACTS.get(type(event))
        if act is not None:
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
            case events.BreakerTripped():
                self._trip(event)
            case events.ResetBreaker():
                self._reset(event)

    def _trip(self, event: events.BreakerTripped) -> None:
        """A stage goes out of service."""
        try:
            self.breakers.trip(event.name, event.why)
        except ValueError as error:
            self.refusals.add(f"{event.source}: {error}")
            return
        self.refusals.add(out_of_service(event.name, event.why))
        self._drop_begun()

    def _drop_begun(self) -> None:
        """What stages that are out of service have begun is dropped: nobody would end it, and until then there could be
        no snapshot. Asked at each measure line: events begin something meanwhile."""
        tripped = self.breakers.tripped
        stands = tripped(Stage.TICK)
        if stands or tripped(Stage.SELECTION):
            self.scheduler.drop_plan()
        if stands or tripped(Stage.STEERING):
            self.motion.evolutions.drop_begun()
        if stands or tripped(Stage.EDITS):
            self.reloading.drop()
            self._new_steps.drop()

    def _reset(self, event: events.ResetBreaker) -> None:
        try:
            self.breakers.reset(event.name)
        except ValueError as error:
            self.refusals.add(f"{event.source}: {error}")

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
    _ACTS: ClassVar = {kind: act for kinds, act in reversed(_TOLD) for kind in kinds}
    """The same for each kind: a flood has many, and one look is cheaper than one at every kind there is."""
