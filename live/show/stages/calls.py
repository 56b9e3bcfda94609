"""Events that the show itself issues: calls of the score, of cues and launches at their beats, reactions, votes."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

from live.control.events.event import ControlEvent
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.desk.launcher import Launcher
    from live.show.desk.light_desk import LightDesk
    from live.show.score.beat_scheduler import BeatScheduler
    from live.show.stages.event_router import EventRouter

MAX_CALL_DEPTH: Final = 4
"""Maximum depth of signals that trigger signals in one tick; the rest waits for the next tick."""


class Calls:
    """The calls of one show; stages SCORE and DESK, and a circuit breaker for each event type. Thread: the show's."""

    def __init__(
        self,
        breakers: CircuitBreakers,
        router: "EventRouter",
        beat_scheduler: "BeatScheduler",
        desk: "LightDesk",
        launcher: "Launcher",
    ) -> None:
        self._breakers, self._router, self._beat_scheduler, self._desk = breakers, router, beat_scheduler, desk
        self._launcher = launcher

    def fire(self, now: Now, line: float | None = None) -> None:
        """Issue everything scheduled up to the danced beat `line` (None: now), and what that triggers at once."""
        if self._breakers.closed(Stage.DESK) and not self._desk.held:
            self._launcher.fire(now, now.danced_beats if line is None else line, self.issue)
        for _ in range(MAX_CALL_DEPTH):
            due: list[ControlEvent] = []
            if self._breakers.closed(Stage.SCORE):
                due += self._beat_scheduler.fire(now.danced_beats if line is None else line)
            if self._breakers.closed(Stage.DESK):
                due += self._desk.fire(now.danced_beats if line is None else line, now.time)
            if not due:
                return
            self.issue(due)

    def issue(self, calls: Iterable[ControlEvent]) -> None:
        """Pass these events to their parts."""
        for event in calls:
            if self._breakers.may_issue(type(event).__name__):
                self._router.handle(event)
