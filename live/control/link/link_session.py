"""Participant of an Ableton Link session in its own thread, and the conversion from Link's clock to the show's."""

import math
import queue
from collections import deque
from collections.abc import Callable
from typing import Any, Final, Literal

from live.base.event_queue import EventQueue
from live.clock.time_source import Clock
from live.clock.timeline import Timeline, next_phase_match
from live.control.events.events import ControlEvent
from live.control.link.link_sync import LinkChange, LinkLeader, LinkReading, LinkReporter, fold_factor, peers_text
from live.control.worker_thread import WorkerThread

WINDOW: Final = 16
"""Number of readings kept for the rate; at four readings per second, they span four seconds."""

TRIES: Final = 5
GOOD_BRACKET: Final = 5e-6
"""A reading is repeated, up to `TRIES` times, until it is bracketed within 5 µs."""

WIDE_BRACKET: Final = 200e-6
"""A reading interrupted for longer than this [s] is ignored while a better one is younger than ..."""

MAX_READING_AGE: Final = 2.0
"""... these seconds."""

CLOCK_RESOLUTION: Final = 1e-6
"""Link counts whole microseconds, so the interval between two readings has this error [s]."""

RATE_LIMIT: Final = 2e-3
"""Limit for the rate difference: 500 ppm (NTP's slew limit) plus the tolerance of two crystals, with margin."""


class LinkClock:
    """Converts Link's time (CLOCK_MONOTONIC_RAW) to the show's (CLOCK_MONOTONIC, slewed by NTP), despite drift.

    Link's clock is read between two readings of the show's clock, so the error is at most half of their distance. The
    newest good reading gives the offset; the earlier ones give only the rate for extrapolation. (A line fitted through
    all of them would lag when NTP changes the rate.) Use from one thread at a time.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)  # Link's seconds, offset, half width
        self._rate = 0.0

    @property
    def error(self) -> float:
        """Upper bound of the error [s] of the newest reading; infinite before the first."""
        return self._readings[-1][2] if self._readings else math.inf

    @property
    def rate(self) -> float:
        """Relative rate of the show's clock to Link's: 1e-6 is one ppm faster."""
        return self._rate

    def read(self, micros: Callable[[], int], now: Callable[[], float]) -> None:
        """Read both clocks, with the narrowest bracket of several tries."""
        best: tuple[float, int, float] | None = None
        for _ in range(TRIES):
            before = now()
            ticks = micros()
            after = now()
            if best is None or after - before < best[2] - best[0]:
                best = (before, ticks, after)
            if after - before <= GOOD_BRACKET:
                break
        assert best is not None
        self.observe(*best)

    def observe(self, before: float, micros: int, after: float) -> None:
        """Add a reading: Link's clock showed `micros` between `before` and `after` [s of the show]."""
        link, half = micros * 1e-6, 0.5 * (after - before)
        if (
            half > WIDE_BRACKET
            and self._readings
            and link - self._readings[-1][0] < MAX_READING_AGE
            and self.error < half
        ):
            return
        self._readings.append((link, 0.5 * (before + after) - link, half))
        if len(self._readings) > 1:
            first = self._readings[0]
            span = link - first[0]
            slack = first[2] + half + CLOCK_RESOLUTION  # a slope within the measurement error counts as 0
            rise = self._readings[-1][1] - first[1]
            rise = math.copysign(max(abs(rise) - slack, 0.0), rise)
            self._rate = min(max(rise / span, -RATE_LIMIT), RATE_LIMIT) if span > 0.0 else 0.0

    def time_of(self, micros: float) -> float:
        """Return the show's time [s] at which Link's clock shows `micros`."""
        link, offset, _ = self._readings[-1]
        at = micros * 1e-6
        return at + offset + self._rate * (at - link)


Mode = Literal["follow", "lead"]
"""follow: the session is a clock source. lead: the show sets the session's tempo and beat and never follows it."""

POLL_INTERVAL: Final = 0.02
"""Interval between polls of the session [s]; each costs about 10 µs. Link's callbacks are not used, because they come
from its network thread and would wait there for the interpreter."""

CLOCK_READ_INTERVAL: Final = 0.25
"""Interval between readings of both clocks [s]."""

LINK_MIN_BPM: Final = 20.0
LINK_MAX_BPM: Final = 999.0


class LinkUnavailable(Exception):
    """Link's package is missing or cannot be loaded; the message gives the remedy."""


def make_link(tempo: float) -> Any:
    """Return a participant with initial `tempo` [bpm], not yet on the network; raises LinkUnavailable."""
    try:
        import link
    except ImportError as error:
        if "libatomic" in str(error):
            raise LinkUnavailable("Ableton Link: libatomic.so.1 is missing (apt install libatomic1)") from None
        why = "is not installed" if isinstance(error, ModuleNotFoundError) else f"cannot be loaded: {error}"
        raise LinkUnavailable(f"Ableton Link {why} (make play, or pip install LinkPython-extern)") from None
    return link.Link(tempo)


class LinkSession:
    """Joins the Link session on the local network and puts BeatHeard and SourceChanged events into an inbox.

    Joining does not change the tempo or beat of others. With peers, only `set_tempo`, `set_playing`, `resync` and the
    mode "lead" change the session. Without peers the session is kept at the show's tempo and beat and is not a source,
    so that nothing jumps when a peer joins. Link checks the network interfaces every few seconds, so they may come and
    go. A peer that disappears without leaving still counts for about five seconds.
    Call all methods from one thread; read properties from any.
    """

    def __init__(
        self,
        inbox: EventQueue[ControlEvent],
        clock: Clock,
        *,
        tempo: float,
        beats_per_measure: int = 4,
        mode: Mode = "follow",
        start_stop: bool = False,
        source: str = "link",
        make: Callable[[float], Any] = make_link,
    ) -> None:
        """Prepare, without joining the network; `tempo` [bpm] is the initial tempo without peers.

        `start_stop`: share starts and stops, too. Raises LinkUnavailable.
        """
        self.mode: Mode = mode
        self.faults = 0
        """Number of polls that failed ..."""
        self.fault = ""
        """... and the last failure as text."""
        self._link = make(min(max(tempo, LINK_MIN_BPM), LINK_MAX_BPM))
        self._link.startStopSyncEnabled = start_stop
        self._micros: Callable[[], int] = self._link.clock().micros
        self._inbox = inbox
        self._clock = clock
        self._link_clock = LinkClock()
        self._read_clocks_at = -CLOCK_READ_INTERVAL
        self._reports = LinkReporter(start_stop=start_stop, source=source)
        self._lead = LinkLeader()
        if mode == "lead":
            self._lead.resync()  # choosing this mode implies a resync
        self._commands: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._timeline: tuple[Timeline, float] | None = None
        self._beats_per_measure = beats_per_measure
        self._last_reading: LinkReading | None = None
        self._worker = WorkerThread("Ableton Link", self._poll_loop)

    # -- state, readable from any thread -----------------------------------------------------------------------

    @property
    def peers(self) -> int:
        """Number of other participants in the session."""
        last = self._last_reading
        return 0 if last is None else last.peers

    @property
    def reading(self) -> LinkReading | None:
        """The last reading of the session; None before the start."""
        return self._last_reading

    @property
    def summary(self) -> str:
        """Text for the display: "off", "alone", "2 peers", "leads 2 peers"."""
        last = self._last_reading
        if last is None or not self._worker.started:
            return "off"
        if not last.peers:
            return "alone"
        return ("leads " if self.mode == "lead" else "") + peers_text(last.peers)

    # -- calls by the show -------------------------------------------------------------------------------------

    def start(self) -> None:
        """Join the session."""
        if not self._worker.started:
            self._worker.start()

    def stop(self) -> None:
        """Leave the session; reports the source as "lost" if it was found."""
        self._worker.stop()

    def set_timeline(self, timeline: Timeline, tempo: float) -> None:
        """Set the show's current timeline and the music's `tempo` [bpm]; call each frame, never blocks.

        The session uses the timeline's beats per measure. Without peers, or when leading, the session follows it.
        """
        self._timeline = (timeline, tempo)

    def set_tempo(self, tempo: float) -> None:
        """Set the session's tempo [bpm] for all participants; the beat continues without a jump."""
        self._commands.put(lambda: self._commit_tempo(tempo))

    def set_playing(self, playing: bool) -> None:
        """Start the session's transport at its next measure line, or stop it now (shared only with `start_stop`)."""
        self._commands.put(lambda: self._commit_playing(playing))

    def resync(self) -> None:
        """When leading: move all participants to the show's beat at once ("this is the one")."""
        self._commands.put(self._lead.resync)

    # -- the thread --------------------------------------------------------------------------------------------

    def _poll_loop(self) -> None:
        self._link.enabled = True
        try:
            while not self._worker.stopping.wait(POLL_INTERVAL):
                try:
                    self.poll()
                except Exception as error:  # a failure of the library must not end the thread
                    self.faults += 1
                    self.fault = f"{type(error).__name__}: {error}"
        finally:
            self._put(self._reports.end(self._clock.now(), "left the session"))
            self._link.enabled = False

    def poll(self) -> None:
        """Poll the session once. Called on this object's own thread, or directly in tests."""
        now = self._clock.now()
        if now - self._read_clocks_at >= CLOCK_READ_INTERVAL:
            self._read_clocks_at = now
            self._link_clock.read(self._micros, self._clock.now)
        while not self._commands.empty():
            self._commands.get()()
        shown = self._timeline
        if shown is not None:
            self._beats_per_measure = shown[0].beats_per_measure
        reading = self._last_reading = self._read()
        if shown is not None and (self.mode == "lead" or not reading.peers):
            change = self._lead.next_change(reading, *shown)
            if change is not None:
                self._commit(change, reading)
        if self.mode == "follow":
            self._put(self._reports.update(reading))

    def _read(self) -> LinkReading:
        peers = int(self._link.numPeers())  # read first, so that the state below includes these peers
        state, micros = self._link.captureSessionState(), self._micros()
        tempo = float(state.tempo())
        fold = fold_factor(tempo)
        return LinkReading(
            time=self._link_clock.time_of(micros),
            peers=peers,
            tempo=tempo / fold,
            beat=state.beatAtTime(micros, float(self._beats_per_measure * fold)) / fold,
            beats_per_measure=self._beats_per_measure,
            fold=fold,
            playing=bool(state.isPlaying()),
            since=self._link_clock.time_of(state.timeForIsPlaying()),
        )

    def _commit(self, change: LinkChange, reading: LinkReading) -> None:
        state, micros = self._link.captureSessionState(), self._micros()
        state.setTempo(change.tempo, micros)
        if change.phase is not None:
            place = state.forceBeatAtTime if change.force else state.requestBeatAtTime
            on = change.phase + (self._link_clock.time_of(micros) - reading.time) * change.tempo / 60.0
            place(on, micros, float(reading.beats_per_measure))
        if change.force or self.mode == "lead" or not self._link.numPeers():  # unless a peer joined in between
            self._link.commitSessionState(state)

    def _commit_tempo(self, tempo: float) -> None:
        state = self._link.captureSessionState()
        state.setTempo(min(max(tempo, LINK_MIN_BPM), LINK_MAX_BPM), self._micros())
        self._link.commitSessionState(state)

    def _commit_playing(self, playing: bool) -> None:
        state, at = self._link.captureSessionState(), self._micros()
        if playing:
            quantum = float(self._beats_per_measure * fold_factor(state.tempo()))
            at = state.timeAtBeat(next_phase_match(state.beatAtTime(at, quantum), 0.0, quantum), quantum)
        state.setIsPlaying(playing, at)
        self._link.commitSessionState(state)

    def _put(self, events: list[ControlEvent]) -> None:
        for event in events:
            self._inbox.put(event)
