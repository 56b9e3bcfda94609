"""Link synchronization without I/O: readings of a session, changes to lead it, and events for the show."""

import math
from dataclasses import dataclass
from typing import Final

from live.clock.timeline import TEMPO_MAX_BPM, Timeline
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged


@dataclass(frozen=True, slots=True)
class LinkReading:
    """A session's tempo, beat and transport at `time`.

    Link allows up to 999 bpm. Above a Timeline's maximum, every second beat (or every fourth …) counts as the beat, as
    in Ableton's test plan (TEMPO-4); `fold` is the number of Link beats per beat.
    """

    time: float
    """Seconds of the show."""
    peers: int
    """Number of other participants of the session."""
    tempo: float
    """Folded beats per minute."""
    beat: float
    """Folded beats; modulo `beats_per_measure` shared by all participants, the count of measures is local."""
    beats_per_measure: int
    fold: int = 1
    playing: bool = False
    """The session's transport; meaningful only if start/stop is shared."""
    since: float = 0.0
    """When the transport was last started or stopped [s]; may be in the future."""

    @property
    def period(self) -> float:
        """Seconds per beat."""
        return 60.0 / self.tempo

    @property
    def phase(self) -> float:
        """Beats into the measure, in [0, beats_per_measure)."""
        return self.beat % self.beats_per_measure


def fold_factor(tempo: float) -> int:
    """Return the number of Link beats per danced beat at a Link tempo [bpm]: 1, 2, 4 …"""
    fold = 1
    while tempo / fold > TEMPO_MAX_BPM:
        fold *= 2
    return fold


def phase_difference(phase: float, other: float, quantum: float) -> float:
    """Return by how many beats `phase` is ahead of `other`, wrapped to [-quantum / 2, quantum / 2)."""
    return (phase - other + 0.5 * quantum) % quantum - 0.5 * quantum


ALONE_INTERVAL: Final = 0.25
"""Minimum interval between changes of a session without peers [s]."""

ALONE_ERROR: Final = 0.002
LED_ERROR: Final = 0.001
"""Phase errors [s] that are not corrected: without peers, and with peers."""

SAME_LEAD_TEMPO: Final = 2e-5
"""Relative change of tempo below which nothing is sent (0.0024 bpm at 120)."""

MAX_BEND: Final = 0.03
"""Maximum relative tempo change to correct the phase: half a semitone."""

BEND_TIME: Final = 2.0
"""Seconds in which a small phase error is corrected."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A change to be committed to the session."""

    tempo: float
    """Beats per minute from now on."""
    phase: float | None = None
    """The new position in the measure [beats]; None: the session's beat continues."""
    force: bool = False
    """Whether the peers' beat jumps, too; only on a person's request."""


class LinkLeader:
    """Compares the session with the show's Timeline and decides on changes, at most one per beat.

    Without peers, the session takes the show's tempo and phase, so that nothing jumps when a peer joins (BEATTIME-2).
    With peers it is *led*: the tempo is sent, and a phase error is corrected by a tempo up to 3 % off. Only `resync`
    (a person chose to lead, or set the one) may move the beat of all at once, as Ableton's documentation of
    forceBeatAtTime asks. No I/O. Use from one thread at a time.
    """

    def __init__(self) -> None:
        self._next = 0.0
        self._force = False

    def resync(self) -> None:
        """Let the next change move the beat of all participants, on a person's request."""
        self._force = True

    def next_change(self, reading: LinkReading, timeline: Timeline, tempo: float) -> LinkChange | None:
        """Return the change to commit now, or None. `tempo` [bpm]: the music's; the timeline's includes corrections."""
        if reading.time < self._next:
            return None
        wanted = timeline.phase_at(reading.time)
        behind = (
            phase_difference(wanted, reading.phase, reading.beats_per_measure) * 60.0 / tempo
        )  # the session's lag [s]
        change = (self._led if reading.peers else self._alone)(reading, tempo, wanted, behind)
        if change is not None:
            self._next = reading.time + (60.0 / tempo if reading.peers else ALONE_INTERVAL)
        return change

    def _alone(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if abs(behind) > ALONE_ERROR or reading.fold != 1:
            return LinkChange(tempo, wanted)
        return LinkChange(tempo) if _differ(tempo, reading.tempo) else None

    def _led(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if self._force:
            self._force = False
            return LinkChange(tempo, wanted, force=True)
        if reading.fold != 1:  # tempo too fast: first return to one in which beats can be compared
            return LinkChange(tempo)
        bend = 0.0 if abs(behind) <= LED_ERROR else min(max(behind / BEND_TIME, -MAX_BEND), MAX_BEND)
        asked = tempo * (1.0 + bend)
        return LinkChange(asked) if _differ(asked, reading.tempo) else None


def _differ(tempo: float, other: float) -> bool:
    return abs(tempo - other) > SAME_LEAD_TEMPO * other


MAX_BEAT_INTERVAL: Final = 0.5
"""Maximum interval between BeatHeard events [s]; there are at least two per beat ..."""

MIN_BEAT_INTERVAL: Final = 0.05
"""... but this is the minimum interval [s]."""

JUMP_SECONDS: Final = 0.015
JUMP_BEATS: Final = 0.02
"""A session has jumped if its beat is farther than this from the beat predicted by its tempo."""

SAME_REPORTED_TEMPO: Final = 1e-6
"""Relative; Link's tempo is a whole number of microseconds per beat, so a new one differs by more."""


class LinkReporter:
    """Turns readings of a session into events: found and lost, next beat, jumps and transport.

    A session without peers is not a source, because the show would follow itself. With the first peer it is "found",
    without the last one "lost". No I/O: readings carry their times. Use from one thread at a time.
    """

    def __init__(self, *, start_stop: bool = False, source: str = "link") -> None:
        """`start_stop`: whether "started" and "stopped" are reported."""
        self._start_stop = start_stop
        self._source = source
        self._last: LinkReading | None = None
        self._due = -math.inf
        self._transport: tuple[bool, float] | None = None
        self._pending_transport: tuple[str, float] | None = None

    def update(self, reading: LinkReading) -> list[ControlEvent]:
        """Return the events that follow from this reading, oldest first."""
        if not reading.peers:
            return self.end(reading.time, "no peers left") + self._transport_events(reading)
        events: list[ControlEvent] = []
        last, self._last = self._last, reading
        jump = False
        if last is None:
            events.append(self._changed("found", reading.time, peers_text(reading.peers)))
        else:
            jump = _jumped(last, reading)
        if jump or last is None or reading.time >= self._due or _differs(last, reading):
            self._due = reading.time + min(max(0.5 * reading.period, MIN_BEAT_INTERVAL), MAX_BEAT_INTERVAL)
            events.append(self._beat(reading, jump))
        return events + self._transport_events(reading)

    def end(self, time: float, reason: str) -> list[ControlEvent]:
        """Report the session as "lost", if it was found, because we or all peers have left it."""
        if self._last is None:
            return []
        self._last = None
        return [self._changed("lost", time, reason)]

    def _beat(self, reading: LinkReading, jump: bool) -> BeatHeard:
        """Return an event for the next beat."""
        number = math.floor(reading.beat) + 1
        measure, beat = divmod(number, reading.beats_per_measure)
        return BeatHeard(
            time=reading.time,
            source=self._source,
            beat_time=reading.time + (number - reading.beat) * reading.period,
            period=reading.period,
            confidence=1.0,
            beat=beat,
            beats_per_measure=reading.beats_per_measure,
            measure=max(measure, -1),
            jump=jump,
        )

    def _transport_events(self, reading: LinkReading) -> list[ControlEvent]:
        """Report transport changes; a start at the measure line it waits for (STARTSTOPSTATE-1: "according to its
        quantization")."""
        if not self._start_stop:
            return []
        transport = (reading.playing, reading.since)
        if self._transport is None:  # the initial state is not a change
            self._transport = transport
        elif transport != self._transport:
            if reading.playing != self._transport[0]:
                at = _next_measure_line(reading, reading.since) if reading.playing else reading.since
                self._pending_transport = ("started" if reading.playing else "stopped", at)
            self._transport = transport
        if self._pending_transport is None or reading.time < self._pending_transport[1]:
            return []
        state, at = self._pending_transport
        self._pending_transport = None
        return [self._changed(state, at, "")]

    def _changed(self, state: str, time: float, detail: str) -> SourceChanged:
        return SourceChanged(time=time, source=self._source, state=state, detail=detail)


def peers_text(peers: int) -> str:
    """ "1 peer", "3 peers"."""
    return "1 peer" if peers == 1 else f"{peers} peers"


def _differs(last: LinkReading, reading: LinkReading) -> bool:
    return (
        abs(reading.tempo - last.tempo) > SAME_REPORTED_TEMPO * last.tempo
        or reading.beats_per_measure != last.beats_per_measure
        or reading.fold != last.fold
    )


def _jumped(last: LinkReading, reading: LinkReading) -> bool:
    """Whether the beat differs from the one predicted since the last reading by the old or the new tempo."""
    if reading.fold != last.fold or reading.beats_per_measure != last.beats_per_measure:
        return True
    elapsed = (reading.time - last.time) / 60.0
    ways = sorted((elapsed * last.tempo, elapsed * reading.tempo))
    middle, half = 0.5 * (ways[0] + ways[1]), 0.5 * (ways[1] - ways[0])
    off = phase_difference(reading.beat - middle, last.beat, reading.beats_per_measure)
    return abs(off) > half + max(JUMP_BEATS, JUMP_SECONDS * reading.tempo / 60.0)


def _next_measure_line(reading: LinkReading, time: float) -> float:
    """Return the time of the first measure line at or after `time` [s]."""
    beat = reading.beat + (time - reading.time) / reading.period
    measures = math.ceil(beat / reading.beats_per_measure - 1e-6)
    return time + (measures * reading.beats_per_measure - beat) * reading.period
