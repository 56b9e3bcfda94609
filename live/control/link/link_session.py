"""LinkSession: the show as a participant of an Ableton Link session, followed or led, in a thread of its own.

LinkClock: which second of the show belongs to which microsecond of Ableton Link's clock.
"""

import math
import queue
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Final, Literal

from live.base.event_queue import Inbox
from live.base.fault_isolation import keep_running
from live.clock.time_source import Clock
from live.clock.timeline import Timeline, next_phase_match
from live.control.events.events import ControlEvent
from live.control.link.link_sync import LinkChange, LinkLead, LinkReading, LinkReports, fold_of, peers_in_words

WINDOW: Final = 16
"""Readings kept for the rate: with one each quarter of a second, four seconds."""

TRIES: Final = 5
GOOD: Final = 5e-6
"""A reading is tried again, five times at most, until it is bracketed within 5 µs."""

WIDE: Final = 200e-6
"""A reading that was interrupted for longer is not taken while a good one is younger than ..."""

OLD: Final = 2.0
"""... these seconds."""

COUNTED: Final = 1e-6
"""Link counts whole microseconds: two readings may be this much nearer or farther apart than they say [s]."""

RATE_LIMIT: Final = 2e-3
"""The two clocks run apart by at most 500 ppm (what NTP may slew) and two crystals; more is a mistake."""


class LinkClock:
    """Link counts CLOCK_MONOTONIC_RAW, the show the slewed CLOCK_MONOTONIC: they drift apart, and NTP bends the drift.

    A reading is Link's clock between two looks at the show's, so its error is known: at most half of what lies
    between the two. The newest good reading is therefore taken as it is, and the readings before it give only the
    rate at which to go on from there. (A line fitted through all of them would be late where NTP changes the rate.)
    Thread: one at a time.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float, float]] = deque(maxlen=WINDOW)  # Link's seconds, offset, half width
        self._rate = 0.0

    @property
    def error(self) -> float:
        """Bound on the error [s] of the newest reading; infinite before the first."""
        return self._readings[-1][2] if self._readings else math.inf

    @property
    def rate(self) -> float:
        """How much faster the show's clock runs than Link's: 1e-6 is one ppm."""
        return self._rate

    def read(self, micros: Callable[[], int], now: Callable[[], float]) -> None:
        """Read both clocks, as narrowly as may be."""
        best: tuple[float, int, float] | None = None
        for _ in range(TRIES):
            before = now()
            ticks = micros()
            after = now()
            if best is None or after - before < best[2] - best[0]:
                best = (before, ticks, after)
            if after - before <= GOOD:
                break
        assert best is not None
        self.observe(*best)

    def observe(self, before: float, micros: int, after: float) -> None:
        """Link's clock showed `micros` between `before` and `after` [s of the show]."""
        link, half = micros * 1e-6, 0.5 * (after - before)
        if half > WIDE and self._readings and link - self._readings[-1][0] < OLD and self.error < half:
            return
        self._readings.append((link, 0.5 * (before + after) - link, half))
        if len(self._readings) > 1:
            first = self._readings[0]
            span = link - first[0]
            slack = first[2] + half + COUNTED  # a slope that brackets and counting could have made alone is none
            rise = self._readings[-1][1] - first[1]
            rise = math.copysign(max(abs(rise) - slack, 0.0), rise)
            self._rate = min(max(rise / span, -RATE_LIMIT), RATE_LIMIT) if span > 0.0 else 0.0

    def time_of(self, micros: float) -> float:
        """Seconds of the show at which Link's clock shows `micros`."""
        link, offset, _ = self._readings[-1]
        at = micros * 1e-6
        return at + offset + self._rate * (at - link)


Mode = Literal["follow", "lead"]
"""follow: the session is a clock source. lead: it is told the show's tempo and beat, and never followed."""

POLL: Final = 0.02
"""Seconds between two looks at the session (each costs about 10 µs). Polled, for Link's own callbacks come from its
network thread and would wait there for the interpreter."""

CLOCKS_EVERY: Final = 0.25
"""Seconds between two readings of both clocks."""

LINK_MIN_BPM: Final = 20.0
LINK_MAX_BPM: Final = 999.0


class LinkUnavailable(Exception):
    """Link's package is not there, or does not work here; the message says how to get it."""


def make_link(tempo: float) -> Any:
    """A participant, not yet on the network, that begins at `tempo` [bpm]; raises LinkUnavailable."""
    try:
        import link
    except ImportError as error:
        if "libatomic" in str(error):
            raise LinkUnavailable("Ableton Link: libatomic.so.1 is missing (apt install libatomic1)") from None
        why = "is not installed" if isinstance(error, ModuleNotFoundError) else f"cannot be loaded: {error}"
        raise LinkUnavailable(f"Ableton Link {why} (make play, or pip install LinkPython-extern)") from None
    return link.Link(tempo)


class LinkSession:
    """Joins the Link session on the local network, and puts BeatHeard and SourceChanged events into an inbox.

    Joining changes nobody's tempo or beat: with others there, only `set_tempo`, `set_playing`, `resync` and the mode
    "lead" tell the session anything. Alone, the session is kept at the show's own tempo and beat, unheard, so that
    nothing jumps when somebody joins. Link itself looks for network interfaces every few seconds, so they may come
    and go; somebody who vanishes without a goodbye counts as there for about five seconds.
    Thread: all methods from one; properties from any.
    """

    def __init__(
        self,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        tempo: float,
        beats_per_measure: int = 4,
        mode: Mode = "follow",
        start_stop: bool = False,
        source: str = "link",
        make: Callable[[float], Any] = make_link,
    ) -> None:
        """Ready, but not on the network; `tempo` [bpm] is what it begins with where nobody else is.

        `start_stop`: share starts and stops, too. Raises LinkUnavailable.
        """
        self.mode: Mode = mode
        self.faults = 0
        """Looks at the session that failed ..."""
        self.fault = ""
        """... and the last fault in words."""
        self._link = make(min(max(tempo, LINK_MIN_BPM), LINK_MAX_BPM))
        self._link.startStopSyncEnabled = start_stop
        self._micros: Callable[[], int] = self._link.clock().micros
        self._inbox = inbox
        self._clock = clock
        self._line = LinkClock()
        self._read_clocks_at = -CLOCKS_EVERY
        self._reports = LinkReports(start_stop=start_stop, source=source)
        self._lead = LinkLead()
        if mode == "lead":
            self._lead.resync()  # to choose it is to ask for it
        self._wishes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._shown: tuple[Timeline, float] | None = None
        self._beats_per_measure = beats_per_measure
        self._last: LinkReading | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    # -- what is known, from any thread ------------------------------------------------------------------------

    @property
    def peers(self) -> int:
        """How many others are in the session."""
        last = self._last
        return 0 if last is None else last.peers

    @property
    def reading(self) -> LinkReading | None:
        """What the session said last; None before the start."""
        return self._last

    @property
    def summary(self) -> str:
        """For people: "off", "alone", "2 peers", "leads 2 peers"."""
        last = self._last
        if last is None or self._thread is None:
            return "off"
        if not last.peers:
            return "alone"
        return ("leads " if self.mode == "lead" else "") + peers_in_words(last.peers)

    # -- what the show says ------------------------------------------------------------------------------------

    def start(self) -> None:
        """Join."""
        if self._thread is None:
            self._stop.clear()
            self._thread = threading.Thread(target=self._run, name="Ableton Link", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Leave; the source is "lost", if it was there."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def show(self, timeline: Timeline, tempo: float) -> None:
        """How the show runs now, `tempo` [bpm] being the music's; to be called each frame, costs nothing.

        The session's measure takes the timeline's number of beats. Where nobody else is, or when leading, the session
        runs after it.
        """
        self._shown = (timeline, tempo)

    def set_tempo(self, tempo: float) -> None:
        """A musician's hand sets everybody's tempo [bpm]; the beat goes on without a step."""
        self._wishes.put(lambda: self._commit_tempo(tempo))

    def set_playing(self, playing: bool) -> None:
        """Start the session's transport at its next measure line, or stop it now (shared only with `start_stop`)."""
        self._wishes.put(lambda: self._commit_playing(playing))

    def resync(self) -> None:
        """When leading: a person wants everybody on the show's beat at once ("this is the one")."""
        self._wishes.put(self._lead.resync)

    # -- the thread --------------------------------------------------------------------------------------------

    def _run(self) -> None:
        keep_running("Ableton Link", self._take_part, self._stop.wait)

    def _take_part(self) -> None:
        self._link.enabled = True
        try:
            while not self._stop.wait(POLL):
                try:
                    self.poll()
                except Exception as error:  # a library that fails in the middle of a show must not end its clock
                    self.faults += 1
                    self.fault = f"{type(error).__name__}: {error}"
        finally:
            self._put(self._reports.end(self._clock.now(), "left the session"))
            self._link.enabled = False

    def poll(self) -> None:
        """One look at the session. Thread: Link's own, or in tests the only one."""
        now = self._clock.now()
        if now - self._read_clocks_at >= CLOCKS_EVERY:
            self._read_clocks_at = now
            self._line.read(self._micros, self._clock.now)
        while not self._wishes.empty():
            self._wishes.get()()
        shown = self._shown
        if shown is not None:
            self._beats_per_measure = shown[0].beats_per_measure
        reading = self._last = self._read()
        if shown is not None and (self.mode == "lead" or not reading.peers):
            change = self._lead.change(reading, *shown)
            if change is not None:
                self._commit(change, reading)
        if self.mode == "follow":
            self._put(self._reports.read(reading))

    def _read(self) -> LinkReading:
        peers = int(self._link.numPeers())  # first: who is counted has been heard, the beat below is theirs too
        state, micros = self._link.captureSessionState(), self._micros()
        tempo = float(state.tempo())
        fold = fold_of(tempo)
        return LinkReading(
            time=self._line.time_of(micros),
            peers=peers,
            tempo=tempo / fold,
            beat=state.beatAtTime(micros, float(self._beats_per_measure * fold)) / fold,
            beats_per_measure=self._beats_per_measure,
            fold=fold,
            playing=bool(state.isPlaying()),
            since=self._line.time_of(state.timeForIsPlaying()),
        )

    def _commit(self, change: LinkChange, reading: LinkReading) -> None:
        state, micros = self._link.captureSessionState(), self._micros()
        state.setTempo(change.tempo, micros)
        if change.phase is not None:
            place = state.forceBeatAtTime if change.force else state.requestBeatAtTime
            on = change.phase + (self._line.time_of(micros) - reading.time) * change.tempo / 60.0
            place(on, micros, float(reading.beats_per_measure))
        if change.force or self.mode == "lead" or not self._link.numPeers():  # nobody came in between
            self._link.commitSessionState(state)

    def _commit_tempo(self, tempo: float) -> None:
        state = self._link.captureSessionState()
        state.setTempo(min(max(tempo, LINK_MIN_BPM), LINK_MAX_BPM), self._micros())
        self._link.commitSessionState(state)

    def _commit_playing(self, playing: bool) -> None:
        state, at = self._link.captureSessionState(), self._micros()
        if playing:
            quantum = float(self._beats_per_measure * fold_of(state.tempo()))
            at = state.timeAtBeat(next_phase_match(state.beatAtTime(at, quantum), 0.0, quantum), quantum)
        state.setIsPlaying(playing, at)
        self._link.commitSessionState(state)

    def _put(self, events: list[ControlEvent]) -> None:
        for event in events:
            self._inbox.put(event)
