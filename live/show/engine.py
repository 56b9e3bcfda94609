"""Engine: the body of the frame loop. Live and offline runs differ only in the clock and in the caller of `frame`."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from live.base.event_queue import EventQueue
from live.base.fault_isolation import Bulkhead, callback_name
from live.base.processing_budget import ProcessingBudget
from live.base.stage_snapshot import StageView
from live.clock.ticks import STALL, TICK, TickCounter
from live.clock.time_source import Clock
from live.control.events.event_json import is_finite
from live.control.events.events import (
    AudienceHeard,
    BeatHeard,
    ControlEvent,
    MocapFrame,
    MusicHeard,
    NotesHeard,
    SourceChanged,
    TicksSkipped,
    TrackerMoved,
)
from live.show.circuit_breakers import Stage
from live.show.patch.patch import Patch
from live.show.show import Show, apply_safely
from live.show.view.debug_overlay import draw_guides

if TYPE_CHECKING:
    from live.show.journal.journal import JournalWriter
    from live.show.view.status import Status


EVENTS_PER_FRAME = 512
"""Maximum number of events taken from the inbox in one frame."""
EVENT_BATCH = 8
EVENT_TIME_LIMIT = 0.003
"""Time limit for taking events in a frame [s], so that a flood waits and does not stall the frame."""

MAX_UNDRAWN = 30
"""After this many failed frames in a row the driver counts as lost."""

AUTOMATIC_EVENTS = (
    TicksSkipped,
    BeatHeard,
    SourceChanged,
    MusicHeard,
    NotesHeard,
    MocapFrame,
    TrackerMoved,
    AudienceHeard,
)
"""Events from automatic sources; they do not count as accepted."""
_MEASURED = (BeatHeard, MusicHeard, NotesHeard, MocapFrame, TrackerMoved)
"""Events with values measured by a device; these may be NaN or infinite."""
_SUPERSEDED = (MocapFrame, TrackerMoved, AudienceHeard)
"""Measurements that are old soon: dropped instead of held."""
_NOT_HELD = ("clock", "output", "system", "audio")
"""Modules of events that take effect even while others are held: music, tempo, blackout, faders of the picture."""
HELD_EVENTS = 4096
"""Most events that are held; one more, and all take effect."""

Result = TypeVar("Result")
DrawFunction = Callable[[StageView], None]
"""Function that draws a snapshot: the renderer on its target, or a stub."""


def _no_mark(part: str) -> None:
    """Default mark: does nothing."""


class Progress(Protocol):
    """Progress of the engine, for a watchdog in another process (a page of shared memory)."""

    def begin_tick(self, tick: int) -> None:
        """Record that this tick is about to run."""
        ...


class Engine:
    """Frame loop body: applies events, runs the due ticks and draws the frame.

    Thread: the main thread only; other threads put events into the inbox.
    """

    def __init__(
        self,
        show: Show,
        *,
        clock: Clock,
        inbox: EventQueue[ControlEvent],
        status: "Status",
        journal: "JournalWriter | None" = None,
        lead: float = TICK,
        stall: float = STALL,
    ) -> None:
        """`lead` [s]: how far the picture is ahead of the clock, to compensate for display latency.

        `stall` [s]: ticks are skipped after a longer gap; infinite offline, where every tick runs.
        """
        self.show = show
        self._clock = clock
        self._inbox = inbox
        self._allowance = ProcessingBudget()
        self._status = status
        self.journal = journal
        """Journal for events and measures; None: no journal."""
        self.lead = lead
        """How far the picture is ahead of the clock [s]; may change while the show runs."""
        self.event_listeners: list[Callable[[ControlEvent], None]] = []
        """Called with every event after the show has handled it: for devices."""
        self.event_sources: list[Callable[[float], Iterable[ControlEvent]]] = []
        """Called before each tick with its time [s]; they return the events until then. For events known in advance,
        such as the notes of a file, which must not depend on frame times."""
        self.patch_listeners: list[Callable[[Patch], None]] = []
        """Called with the patch when it was swapped: for devices that depend on it."""
        self._patch = show.patch
        self.ticks = TickCounter(stall=stall)
        self.view = show.view()
        self.overlay = False
        """Whether the operator's overlay is shown."""
        self.blanked = False
        """Whether the picture is black because another machine leads."""
        self.guides = False
        """Whether the operator's guides are drawn: agents, predictions, locked feet."""
        self.refuse_failing = False
        """Whether an event that raises is refused, as in a replay and in a standby; else the error is raised."""
        self.bulkhead: Bulkhead | None = None
        """Isolates the show from errors in callbacks of devices; None (in tests and offline): errors are raised."""
        self.failed_events = 0
        """Events that raised an error, since the start."""
        self.progress: Progress | None = None
        """Notified of each tick before it runs."""
        self.mark: Callable[[str], None] = _no_mark
        """Called with the part of the frame just done, for profiling: "events", "simulation", "poses"."""
        self.on_error: Callable[[Exception], None] | None = None
        """Called once when drawing fails; the show continues. None (in tests and offline): the error is raised."""
        self.raise_when_undrawn = False
        """Whether the error is raised after MAX_UNDRAWN failed frames, so that another engine takes over."""
        self._undrawn = 0
        self.holding: Callable[[], bool] | None = None
        """Whether input that acts on dancers still has to wait; None: never (again)."""
        self._held: list[ControlEvent] = []

    def frame(self, draw: DrawFunction, *, at: float | None = None) -> None:
        """Run one frame: events, due ticks, drawing.

        `at` [s]: start of the frame for the simulation, close to the clock's time, on the regular grid of the display.
        """
        now = self._clock.now()
        if self.holding is not None and not self.holding():
            self._release()
        for _ in range(0, EVENTS_PER_FRAME, EVENT_BATCH):
            values = self._allowance.remaining(now, self._inbox.received_count)
            events = self._inbox.drain_keyed(EVENT_BATCH, now, values)
            self._allowance.spend(sum(key is not None for key, _ in events))
            for _, event in events:
                self._take(event)
            if len(events) < EVENT_BATCH or self._clock.now() - now > EVENT_TIME_LIMIT:
                break
        self._status.dropped_events, self._status.outranked = self._inbox.dropped, self._inbox.outranked
        self.mark("events")
        target = (now if at is None else at) + self.lead
        self._run_ticks(now, target)
        if self.show.patch is not self._patch:
            self._patch = self.show.patch
            for tell in self.patch_listeners:
                self._call(tell, self._patch)
        self.mark("simulation")
        self._fill(max(target, self.ticks.time), now)
        self.mark("poses")
        self._status.frames += 1
        self._draw(draw)

    def _take(self, event: ControlEvent) -> None:
        """Apply an event from the inbox, or hold it: nothing is lost and the order stays."""
        if self.holding is None or type(event).__module__.rpartition(".")[2] in _NOT_HELD:
            self.apply(event)
        elif not isinstance(event, _SUPERSEDED):
            self._held.append(event)
            if len(self._held) >= HELD_EVENTS:  # a flood: rather a late frame than a lost event
                self._release()

    def _release(self) -> None:
        self.holding = None
        held, self._held = self._held, []
        for event in held:
            self.apply(event)

    def _fill(self, time: float, now: float) -> None:
        """Fill the view for `time` [s]; on an error it keeps the last picture."""
        try:
            self.show.fill(self.view, time)
            self.view.guide_count = 0
            if self.guides:
                self._call(draw_guides, self.show, self.view)
            self.view.overlay = (self._call(self._status.overlay, now) or ()) if self.overlay else ()
        except Exception as error:
            self._fail(error)
        if self.blanked:
            self.view.brightness = 0.0

    def _draw(self, draw: DrawFunction) -> None:
        self.show.breakers.enter(Stage.DRAWING)
        try:
            draw(self.view)
        except Exception as error:
            self._fail(error)
            self._undrawn += 1
            if self.raise_when_undrawn and self._undrawn >= MAX_UNDRAWN:
                raise
        else:
            self._undrawn = 0
        self.show.breakers.leave()

    def _fail(self, error: Exception) -> None:
        """Count a faulty frame; the show continues."""
        if self.on_error is None:
            raise error
        if not self._status.faults:
            self.on_error(error)
        self._status.faults += 1

    def apply(self, event: ControlEvent) -> None:
        """Write an event to the journal and apply it from the next tick on; the show counts refused events.

        A measurement with NaN or infinity is counted and dropped: it would make the journal unreadable.
        """
        if isinstance(event, _MEASURED) and not is_finite(event):
            self._status.invalid += 1
            return
        if self.journal is not None:
            self.journal.record_event(self.ticks.index, event)
        acted = apply_safely(self.show, event) if self.refuse_failing else self.show.apply(event)
        self.failed_events += acted is None
        if acted and not isinstance(event, AUTOMATIC_EVENTS):
            self._status.events_accepted += 1
        for told in self.event_listeners:
            self._call(told, event)

    def _call(self, act: Callable[..., Result], *arguments: Any) -> Result | None:
        """Call a callback outside the show."""
        return act(*arguments) if self.bulkhead is None else self.bulkhead.call(callback_name(act), act, *arguments)

    def _run_ticks(self, now: float, target: float) -> None:
        lost = self.ticks.stalled(target)
        if lost:
            self.apply(TicksSkipped(time=now, source="engine", count=lost))
            self.ticks.skip(lost)
            self._status.skipped_ticks = self.ticks.skipped
        self.run_to(target)

    def run_to(self, target: float) -> None:
        """Run every tick up to `target` [s], without a limit."""
        while self.ticks.is_due(target):
            for tell in self.event_sources:
                for event in self._call(_all_of, tell, self.ticks.time + TICK) or ():
                    self.apply(event)
            time = self.ticks.advance()
            if self.progress is not None:
                self.progress.begin_tick(self.ticks.index)
            crossed = self.show.tick(time)
            self._status.ticks += 1
            if self.journal is not None:
                if crossed:
                    self.journal.record_measure(self.ticks.index, self.show.span.number + 1, self.show.state_hash())
                self.journal.take_snapshot(self.show, self.ticks.index, begins=crossed)


def _all_of(source: Callable[[float], Iterable[ControlEvent]], until: float) -> list[ControlEvent]:
    return list(source(until))
