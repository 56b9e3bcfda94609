"""Engine: the frame loop's body. Live and offline differ only in the clock and in who calls `frame`."""

from collections.abc import Callable, Iterable
from typing import Any, Protocol, TypeVar

from live.base.event_queue import Inbox
from live.base.fault_isolation import Bulkhead, name_of
from live.base.processing_budget import Allowance
from live.base.stage_snapshot import StageView
from live.clock.ticks import STALL, TICK, Ticks
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
from live.show.journal.journal import JournalWriter
from live.show.patch.patch import Patch
from live.show.show import Show, act
from live.show.status import Status
from live.show.view.debug_overlay import draw_guides

EVENTS_PER_FRAME = 512
"""Events taken from the inbox in one frame at most ..."""
EVENTS_AT_ONCE = 8
EVENT_SECONDS = 0.003
"""... and no more once so much time has gone by: a flood waits, it does not stall a frame."""

UNDRAWN = 30
"""Frames in a row that could not be drawn: the driver is lost."""

FROM_SOURCES = (TicksSkipped, BeatHeard, SourceChanged, MusicHeard, NotesHeard, MocapFrame, TrackerMoved, AudienceHeard)
"""Events that nobody's hand makes: they do not count as accepted."""
_MEASURED = (BeatHeard, MusicHeard, NotesHeard, MocapFrame, TrackerMoved)
"""Events whose numbers a device has measured, or not."""

Result = TypeVar("Result")
Picture = Callable[[StageView], None]
"""Whatever draws a snapshot: the renderer on its target, or nothing at all."""


def _nobody(part: str) -> None:
    """Nobody measures."""


class Progress(Protocol):
    """Who has to know what is run, should it never end: a page of memory that another process reads."""

    def begin_tick(self, tick: int) -> None:
        """This tick is run now."""
        ...


class Engine:
    """Takes events, runs the ticks that are due, and has the frame drawn.

    Thread: the main thread only; other threads put events into the inbox.
    """

    def __init__(
        self,
        show: Show,
        *,
        clock: Clock,
        inbox: Inbox[ControlEvent],
        status: Status,
        journal: JournalWriter | None = None,
        lead: float = TICK,
        stall: float = STALL,
    ) -> None:
        """`lead` [s]: how far ahead of the clock the picture is, so that dancers land on the beat when it is seen.

        `stall` [s]: after a longer gap ticks are left out; infinite offline, where every tick is run.
        """
        self.show = show
        self._clock = clock
        self._inbox = inbox
        self._allowance = Allowance()
        self._status = status
        self.journal = journal
        """Where events and measures are noted; None: nowhere."""
        self.lead = lead
        """How far ahead of the clock the picture is [s]; it may be changed while the show runs."""
        self.outward: list[Callable[[ControlEvent], None]] = []
        """Told every event after the show: for what concerns devices and not the dance."""
        self.timed: list[Callable[[float], Iterable[ControlEvent]]] = []
        """Asked after each tick for what happens until the next one [s]: for what is known beforehand, as a file's
        notes, and must not depend on when frames are drawn."""
        self.patched: list[Callable[[Patch], None]] = []
        """Told the patch when the show has taken another one: for devices that do what it says."""
        self._patch = show.patch
        self.ticks = Ticks(stall=stall)
        self.view = show.view()
        self.overlay = False
        """Whether the operator's overlay is shown."""
        self.dark = False
        """Whether nothing is to be seen, for another machine leads."""
        self.guides = False
        """Whether the operator's guides are drawn: agents, predictions, held feet."""
        self.forgiving = False
        """Whether an event that ends in an error is refused, as by who replays or goes on; else the error is raised."""
        self.bulkhead: Bulkhead | None = None
        """Keeps errors of devices and others that are told or asked away from the show; None (in tests and offline):
        they are raised."""
        self.failed = 0
        """Events that ended in an error, since the start."""
        self.progress: Progress | None = None
        """Told each tick before it is run."""
        self.mark: Callable[[str], None] = _nobody
        """Told what has just been done in a frame, for whoever measures: "events", "simulation", "poses"."""
        self.on_error: Callable[[Exception], None] | None = None
        """Told once when drawing fails; the show goes on. None (in tests and offline): the error is raised."""
        self.gives_up = False
        """Whether the error is raised where nothing could be drawn for UNDRAWN frames: another engine draws then."""
        self._undrawn = 0

    def frame(self, picture: Picture, *, at: float | None = None) -> None:
        """One frame: events, ticks that are due, drawing.

        `at` [s]: when the frame begins for the dance, near the clock's time: on the even grid of the display.
        """
        now = self._clock.now()
        for _ in range(0, EVENTS_PER_FRAME, EVENTS_AT_ONCE):
            values = self._allowance.left(now, self._inbox.offered)
            events = self._inbox.drain_keyed(EVENTS_AT_ONCE, now, values)
            self._allowance.spend(sum(key is not None for key, _ in events))
            for _, event in events:
                self.apply(event)
            if len(events) < EVENTS_AT_ONCE or self._clock.now() - now > EVENT_SECONDS:
                break
        self._status.dropped_events, self._status.outranked = self._inbox.dropped, self._inbox.outranked
        self.mark("events")
        target = (now if at is None else at) + self.lead
        self._run_ticks(now, target)
        if self.show.patch is not self._patch:
            self._patch = self.show.patch
            for tell in self.patched:
                self._call(tell, self._patch)
        self.mark("simulation")
        self._fill(max(target, self.ticks.time), now)
        self.mark("poses")
        self._status.frames += 1
        self._draw(picture)

    def _fill(self, time: float, now: float) -> None:
        """What is seen at `time` [s]; if that cannot be worked out, what was seen last."""
        try:
            self.show.fill(self.view, time)
            self.view.guide_count = 0
            if self.guides:
                self._call(draw_guides, self.show, self.view)
            self.view.overlay = (self._call(self._status.overlay, now) or ()) if self.overlay else ()
        except Exception as error:
            self._fail(error)
        if self.dark:
            self.view.brightness = 0.0

    def _draw(self, picture: Picture) -> None:
        self.show.breakers.level(Stage.DRAWING)
        try:
            picture(self.view)
        except Exception as error:
            self._fail(error)
            self._undrawn += 1
            if self.gives_up and self._undrawn >= UNDRAWN:
                raise
        else:
            self._undrawn = 0
        self.show.breakers.leave()

    def _fail(self, error: Exception) -> None:
        """A frame is not as it should be; the show goes on."""
        if self.on_error is None:
            raise error
        if not self._status.faults:
            self.on_error(error)
        self._status.faults += 1

    def apply(self, event: ControlEvent) -> None:
        """Write an event to the journal and let it act from the next tick on; the show counts what it refuses.

        What a source says that is no number is counted, and goes nowhere: no journal could be read with it.
        """
        if isinstance(event, _MEASURED) and not is_finite(event):
            self._status.impossible += 1
            return
        if self.journal is not None:
            self.journal.event(self.ticks.index, event)
        acted = act(self.show, event) if self.forgiving else self.show.apply(event)
        self.failed += acted is None
        if acted and not isinstance(event, FROM_SOURCES):
            self._status.events_accepted += 1
        for told in self.outward:
            self._call(told, event)

    def _call(self, act: Callable[..., Result], *arguments: Any) -> Result | None:
        """Call what is beside the show."""
        return act(*arguments) if self.bulkhead is None else self.bulkhead.call(name_of(act), act, *arguments)

    def _run_ticks(self, now: float, target: float) -> None:
        lost = self.ticks.stalled(target)
        if lost:
            self.apply(TicksSkipped(time=now, source="engine", count=lost))
            self.ticks.skip(lost)
            self._status.skipped_ticks = self.ticks.skipped
        self.run_to(target)

    def run_to(self, target: float) -> None:
        """Run every tick up to `target` [s], however many there are."""
        for time in self.ticks.due(target):
            if self.progress is not None:
                self.progress.begin_tick(self.ticks.index)
            crossed = self.show.tick(time)
            self._status.ticks += 1
            if self.journal is not None:
                if crossed:
                    self.journal.measure(self.ticks.index, self.show.span.number + 1, self.show.state_hash())
                self.journal.keep(self.show, self.ticks.index, begins=crossed)
            for tell in self.timed:
                for event in self._call(_all_of, tell, time + TICK) or ():
                    self.apply(event)


def _all_of(tell: Callable[[float], Iterable[ControlEvent]], until: float) -> list[ControlEvent]:
    return list(tell(until))
