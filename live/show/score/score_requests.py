"""Handler for events that change the course of the score: jumps, signals, and the music that triggers signals."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.score.music_reactions import Reactions
from live.show.score.score_runner import SCORE_EVENTS, ScoreRunner
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.scheduler import Scheduler


class ScoreRequests:
    """Passes events to score and reactions; a changed next measure is planned again if there is still time."""

    EVENTS = (*SCORE_EVENTS, events.MusicHeard, events.NotesHeard, events.CurveMoved)

    def __init__(
        self, score_runner: ScoreRunner, reactions: Reactions, motion: "GroupMotion", scheduler: "Scheduler"
    ) -> None:
        self._score_runner, self._reactions = score_runner, reactions
        self._motion, self._scheduler = motion, scheduler

    def handle(self, event: ControlEvent, now: Now) -> Iterable[ControlEvent]:
        """Handle an event of `EVENTS`; raises PersonError for a missing place or an unknown signal.

        Returns the changes that follow the music.
        """
        match event:
            case events.MusicHeard():
                return self._hear_music(event, now)
            case events.NotesHeard():
                self._score_runner.handle_notes(event)
                changes = self._reactions.handle_notes(event)
                self._motion.elements.gain = self._reactions.strength
                return changes
            case events.CurveMoved():
                changes = self._reactions.handle_curve(event)
                for signal in self._score_runner.handle_curve(event):
                    self._handle_request(signal, now)
                self._motion.elements.gain = self._reactions.strength
                return changes
        self._handle_request(event, now)
        return ()

    def _hear_music(self, event: events.MusicHeard, now: Now) -> Iterable[ControlEvent]:
        changes = self._reactions.handle_music(event)
        for signal in self._score_runner.handle_music(event):
            self._handle_request(signal, now)
        self._score_runner.schedule_reactions(now.danced_beats, now.time)
        self._motion.elements.gain = self._reactions.strength
        return changes

    def _handle_request(self, event: ControlEvent, now: Now) -> None:
        moved = self._score_runner.handle(event)
        self._score_runner.schedule_reactions(now.danced_beats, now.time)
        if moved:
            self._motion.withdraw(now.span.number + 1)
            if not self._scheduler.replan(now.span, now.timeline, now.time):
                self._score_runner.record_late_jump()
