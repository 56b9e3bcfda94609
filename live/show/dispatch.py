"""Dispatch of events to the parts of a show."""

from typing import Any, ClassVar

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.assembly import HotSwap
from live.show.audience.audience import AUDIENCE_EVENTS
from live.show.capture.capture_manager import MOCAP_EVENTS
from live.show.circuit_breakers import Stage, describe_tripped
from live.show.dancers.step_requests import STEP_REQUEST_EVENTS
from live.show.desk.light_desk import DESK_EVENTS
from live.show.desk.undo_history import EDITED_PARTS
from live.show.group.group_commands import GROUP_EVENTS
from live.show.score.score_runner import SCORE_EVENTS
from live.show.sound.clock_commands import CLOCK_EVENTS, apply_clock_event

FLOOR_AND_DESK = (*GROUP_EVENTS, *DESK_EVENTS)
"""Events that `_handle_control` handles."""


class EventDispatcher(HotSwap):
    """Event dispatcher: `apply` for events from outside, `_handle` for the show's own. Refused events are counted."""

    def apply(self, event: ControlEvent) -> bool:
        """Apply an event, effective from the next tick. False, and counted, if it names something that does not
        exist."""
        before = self.refusals.count + self.follower.rejected
        if isinstance(event, events.MusicHeard):
            self._handle_music(event)
        elif isinstance(event, events.NotesHeard):
            self._handle_notes(event)
        elif type(event) in EDITED_PARTS:
            self.desk.undo_history.begin_edit(event)
            self._handle(event)
            self.desk.undo_history.end_edit(event)
        else:
            self._handle(event)
        return self.refusals.count + self.follower.rejected == before

    def _handle_music(self, event: events.MusicHeard) -> None:
        """Apply the patch's reactions to the music."""
        for change in self.reactions.handle_music(event):
            self._handle(change)
        for signal in self.score_runner.handle_music(event):
            self._handle(signal)
        self.score_runner.schedule_reactions(self.danced_beats, self.time)
        self.motion.elements.gain = self.reactions.strength

    def _handle_notes(self, event: events.NotesHeard) -> None:
        """Apply the patch's reactions to MIDI notes."""
        self.score_runner.handle_notes(event)
        for change in self.reactions.handle_notes(event):
            self._handle(change)
        self.motion.elements.gain = self.reactions.strength

    def _handle(self, event: ControlEvent) -> None:
        act = self._HANDLERS.get(type(event))
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
                self._new_steps.handle(event, self.graph)
            case events.PatchChanged():
                self.patch_updates.request(event, self.make_show, self.patch, self.latest_graph)
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
        """Take a stage out of service."""
        try:
            self.breakers.trip(event.name, event.why)
        except ValueError as error:
            self.refusals.add(f"{event.source}: {error}")
            return
        self.refusals.add(describe_tripped(event.name, event.why))
        self._drop_unfinished()

    def _drop_unfinished(self) -> None:
        """Drop the unfinished work of stages out of service. Nothing would finish it, and it would block snapshots.
        Called at each measure line, because events can begin new work."""
        tripped = self.breakers.trip_count
        stands = tripped(Stage.TICK)
        if stands or tripped(Stage.SELECTION):
            self.scheduler.drop_plan()
        if stands or tripped(Stage.STEERING):
            self.motion.evolutions.drop_incomplete()
        if stands or tripped(Stage.EDITS):
            self.patch_updates.discard()
            self._new_steps.drop()

    def _reset(self, event: events.ResetBreaker) -> None:
        try:
            self.breakers.reset(event.name)
        except ValueError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _handle_control(self, event: ControlEvent) -> None:
        """Handle an event for the groups' motion or the desk."""
        changes: list[ControlEvent] = []
        try:
            if isinstance(event, DESK_EVENTS):
                changes = self.desk.handle(event, timeline=self.timeline, danced_beats=self.danced_beats)
            else:
                self._controls.handle(event, time=self.time, timeline=self.timeline, span=self.span)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")
        if isinstance(event, events.FreezePicture):
            self._view_builder.update_frozen_view(self.time, self.timeline, self.span, tempo=self.follower.tempo)
        for change in changes:
            self._handle(change)

    def _handle_element(self, event: Any) -> None:
        """Place the element of an event now, or at the next measure line."""
        try:
            self.motion.elements.handle(
                event, beat=self.timeline.beat_at(self.time), next_line=self.span.end,
                beats_per_measure=self.timeline.beats_per_measure, position=self.state.position,
            )  # fmt: skip
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _handle_direction(self, event: ControlEvent) -> None:
        """Handle an event that directs steps or motion of groups."""
        self.directions.handle(event)

    def _handle_audience(self, event: ControlEvent) -> None:
        """Handle an event from the audience's phones, or the operator's settings for them."""
        known: dict[str, tuple[str, ...]] = {}
        if isinstance(event, events.AskVote):
            known = {"step": tuple(self.graph.library.steps), "scene": tuple(self.desk.scenes.names),
                     "look": tuple(look.name for look in self.patch.looks),
                     "cue": tuple(cue.name for cue in self.patch.cue)}  # fmt: skip
        try:
            self.audience.handle(
                event, self.motion.elements, beat=self.timeline.beat_at(self.time), measure=self.span.number,
                beats_per_measure=self.timeline.beats_per_measure, position=self.state.position, known=known,
            )  # fmt: skip
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _handle_score(self, event: ControlEvent) -> None:
        """Handle a signal or a jump in the score; the next measure is planned again if there is still time."""
        try:
            moved = self.score_runner.handle(event)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")
            return
        self.score_runner.schedule_reactions(self.danced_beats, self.time)
        if moved:
            self.motion.withdraw(self.span.number + 1)
            if not self.scheduler.replan(self.span, self.timeline, self.time):
                self.score_runner.record_late_jump()

    def _handle_mocap(self, event: ControlEvent) -> None:
        """Handle a pose or a setting of a captured performer."""
        beat = self.span.danced_beats(self.timeline.beat_at(event.time), self.patch.clock.beats_per_measure)
        try:
            self.mocap.handle(event, beat=beat)
        except PersonError as error:
            self.refusals.add(f"{event.source}: {error}")

    def _handle_clock(self, event: ControlEvent) -> None:
        words = apply_clock_event(self.follower, event)
        if words:
            self.refusals.add(f"{event.source}: {words}")

    _HANDLER_GROUPS: ClassVar = (
        ((events.PlaceElement,), _handle_element), (FLOOR_AND_DESK, _handle_control), (CLOCK_EVENTS, _handle_clock),
        (MOCAP_EVENTS, _handle_mocap),
        (STEP_REQUEST_EVENTS, _handle_direction), (SCORE_EVENTS, _handle_score), (AUDIENCE_EVENTS, _handle_audience),
    )  # fmt: skip
    """The handler of each group of events."""
    _HANDLERS: ClassVar = {kind: act for kinds, act in reversed(_HANDLER_GROUPS) for kind in kinds}
    """The handler by event type: one dictionary look-up per event, which matters in a flood."""
