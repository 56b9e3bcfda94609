"""Routing of events to the parts of a show, by one table from event type to handlers."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol

from live.base.errors import PersonError
from live.control.events.event import ControlEvent
from live.show.desk.refusals import Refusals
from live.show.stages.now import Now
from live.show.stages.show_clock import ShowClock

if TYPE_CHECKING:
    from live.show.desk.undo_history import UndoHistory
    from live.show.group.group_motion import GroupMotion

Handler = Callable[[Any, Now], Iterable[ControlEvent] | None]
"""Handles an event; returns the events that it triggers. Raises PersonError for what is unknown or impossible."""


class EventPart(Protocol):
    """A part of the show that handles events."""

    EVENTS: tuple[type[ControlEvent], ...]
    """The event types that `handle` accepts."""

    handle: Handler


class EventRouter:
    """Passes events to the parts that declare them: `apply` for events from outside, `handle` for the show's own.

    Thread: the show's.
    """

    def __init__(
        self,
        parts: tuple[Any, ...],
        clock: ShowClock,
        motion: "GroupMotion",
        undo_history: "UndoHistory",
        refusals: Refusals,
    ) -> None:
        """`parts` are of `EventPart`. An event that several of them declare goes to all of these, in their order."""
        self._parts: tuple[EventPart, ...] = parts
        self._clock, self._motion, self._undo_history, self._refusals = clock, motion, undo_history, refusals
        self._handlers: dict[type[ControlEvent], tuple[Handler, ...]] = {}
        self.observers: list[Callable[[ControlEvent, Now], None]] = []
        """Called with every event that was handled, also with the show's own; they change nothing in the show."""
        self.build_table()

    def build_table(self) -> None:
        """Build the table from the parts: one dictionary look-up per event, which matters in a flood."""
        self._handlers = {}
        for part in self._parts:
            for kind in part.EVENTS:
                self._handlers[kind] = (*self._handlers.get(kind, ()), part.handle)

    def apply(self, event: ControlEvent) -> bool:
        """Apply an event, effective from the next tick. False, and counted, if it was refused, for example because it
        names something that does not exist."""
        before = self._refusals.count + self._clock.follower.rejected
        self._undo_history.begin_edit(event)
        self.handle(event)
        self._undo_history.end_edit(event)
        return self._refusals.count + self._clock.follower.rejected == before

    def handle(self, event: ControlEvent) -> None:
        """Pass an event to its parts, then the events that they trigger. What a part refuses is counted."""
        now = self._clock.now(self._motion.state.position)
        for handle in self._handlers.get(type(event), ()):
            try:
                triggered = handle(event, now)
            except PersonError as error:
                self._refusals.add(f"{event.source}: {error}")
                return
            for each in triggered or ():
                self.handle(each)
        for observe in self.observers:
            observe(event, now)
