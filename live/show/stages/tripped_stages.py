"""Stages out of service: the events that trip and reset their circuit breakers, and the work they leave unfinished."""

from typing import TYPE_CHECKING

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.circuit_breakers import CircuitBreakers, Stage, describe_tripped
from live.show.desk.refusals import Refusals
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.group.evolutions import Evolutions
    from live.show.selection.scheduler import Scheduler
    from live.show.stages.hot_swap import HotSwap


class TrippedStages:
    """Handles the events for the circuit breakers of one show. Thread: the show's."""

    EVENTS = (events.BreakerTripped, events.ResetBreaker)

    def __init__(
        self,
        breakers: CircuitBreakers,
        refusals: Refusals,
        scheduler: "Scheduler",
        evolutions: "Evolutions",
        hot_swap: "HotSwap",
    ) -> None:
        self._breakers, self._refusals = breakers, refusals
        self._scheduler, self._evolutions, self._hot_swap = scheduler, evolutions, hot_swap

    def handle(self, event: ControlEvent, now: Now) -> None:
        """Handle an event of `EVENTS`; raises PersonError for an unknown breaker."""
        try:
            match event:
                case events.BreakerTripped():
                    self._breakers.trip(event.name, event.why)
                    self._refusals.add(describe_tripped(event.name, event.why))
                    self.drop_unfinished()
                case events.ResetBreaker():
                    self._breakers.reset(event.name)
        except ValueError as error:
            raise PersonError(str(error)) from None

    def drop_unfinished(self) -> None:
        """Drop the unfinished work of stages out of service. Nothing would finish it, and it would block snapshots.
        Called at each measure line, because events can begin new work."""
        tripped = self._breakers.trip_count
        stands = tripped(Stage.TICK)
        if stands or tripped(Stage.SELECTION):
            self._scheduler.drop_plan()
        if stands or tripped(Stage.STEERING):
            self._evolutions.drop_incomplete()
        if stands or tripped(Stage.EDITS):
            self._hot_swap.discard()
