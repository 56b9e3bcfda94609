"""LinkLead: what to tell a Link session so that it runs with the show, gently.

LinkReading: what a Link session says at one instant, in the show's seconds and in beats that dancers can dance.

LinkReports: readings of a Link session in, events for the show out.
"""

import math
from dataclasses import dataclass
from typing import Final

from live.clock.timeline import TEMPO_MAX_BPM, Timeline
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged


@dataclass(frozen=True, slots=True)
class LinkReading:
    """A session's tempo, beat and transport at `time`.

    Link allows up to 999 bpm. Beyond what a Timeline can run, every second beat (or every fourth …) is the beat, as
    Ableton's test plan asks (TEMPO-4); `fold` says how many of Link's beats one is.
    """

    time: float
    """Seconds of the show."""
    peers: int
    """Other participants of the session; 0: we are alone."""
    tempo: float
    """Folded beats per minute."""
    beat: float
    """Folded beats; modulo `beats_per_measure` it is what all participants share, the number of measures is our own."""
    beats_per_measure: int
    fold: int = 1
    playing: bool = False
    """The session's transport; it means something only where start/stop is shared."""
    since: float = 0.0
    """When the transport was last started or stopped [s]; it may lie ahead."""

    @property
    def period(self) -> float:
        """Seconds from beat to beat."""
        return 60.0 / self.tempo

    @property
    def phase(self) -> float:
        """Beats into the measure, in [0, beats_per_measure)."""
        return self.beat % self.beats_per_measure


def fold_of(tempo: float) -> int:
    """How many of Link's beats [bpm] one danced beat is: 1, 2 or 4."""
    fold = 1
    while tempo / fold > TEMPO_MAX_BPM:
        fold *= 2
    return fold


def apart(phase: float, other: float, quantum: float) -> float:
    """By how many beats `phase` is ahead of `other`, the short way round: in [-quantum / 2, quantum / 2)."""
    return (phase - other + 0.5 * quantum) % quantum - 0.5 * quantum


ALONE_PAUSE: Final = 0.25
"""Seconds between two changes of a session in which nobody else is."""

ALONE_ERROR: Final = 0.002
LED_ERROR: Final = 0.001
"""Seconds of phase that are left as they are: alone, and where others listen."""

SAME_LEAD_TEMPO: Final = 2e-5
"""Relative: smaller changes of tempo are not worth a message (0.0024 bpm at 120)."""

BEND: Final = 0.03
"""How much faster or slower than the show the session may run to meet its beat: half a semitone."""

BEND_TIME: Final = 2.0
"""Seconds in which a small phase error is run in."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """What is committed to the session."""

    tempo: float
    """Beats per minute from now on."""
    phase: float | None = None
    """Beats into the measure that now is; None: the session's beat goes on as it is."""
    force: bool = False
    """Whether the others' beat jumps, too: only where a person has asked for it."""


class LinkLead:
    """Compares the session with the show's Timeline and decides on changes: one a beat at most.

    Alone, the session simply takes the show's tempo and phase, so that nothing jumps when somebody joins it
    (BEATTIME-2). With others it is *led*: the tempo is sent, and a phase error is run in by a tempo that is up to 3 %
    off. Only at `resync` (somebody chose to lead, or set the one) may the beat of all be moved at once, as Ableton's
    documentation of forceBeatAtTime asks. Pure. Thread: one at a time.
    """

    def __init__(self) -> None:
        self._next = 0.0
        self._force = False

    def resync(self) -> None:
        """A person asks for it: the next change may move everybody's beat."""
        self._force = True

    def change(self, reading: LinkReading, timeline: Timeline, tempo: float) -> LinkChange | None:
        """What to commit now, if anything; `tempo` is the music's [bpm], the timeline's own carries corrections."""
        if reading.time < self._next:
            return None
        wanted = timeline.phase_at(reading.time)
        behind = apart(wanted, reading.phase, reading.beats_per_measure) * 60.0 / tempo  # seconds that the session is
        change = (self._led if reading.peers else self._alone)(reading, tempo, wanted, behind)
        if change is not None:
            self._next = reading.time + (60.0 / tempo if reading.peers else ALONE_PAUSE)
        return change

    def _alone(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if abs(behind) > ALONE_ERROR or reading.fold != 1:
            return LinkChange(tempo, wanted)
        return LinkChange(tempo) if _differ(tempo, reading.tempo) else None

    def _led(self, reading: LinkReading, tempo: float, wanted: float, behind: float) -> LinkChange | None:
        if self._force:
            self._force = False
            return LinkChange(tempo, wanted, force=True)
        if reading.fold != 1:  # somebody races: first back to a tempo in which beats can be compared
            return LinkChange(tempo)
        bend = 0.0 if abs(behind) <= LED_ERROR else min(max(behind / BEND_TIME, -BEND), BEND)
        asked = tempo * (1.0 + bend)
        return LinkChange(asked) if _differ(asked, reading.tempo) else None


def _differ(tempo: float, other: float) -> bool:
    return abs(tempo - other) > SAME_LEAD_TEMPO * other


LONGEST: Final = 0.5
"""A beat is named at least so often [s], and twice in every beat ..."""

SHORTEST: Final = 0.05
"""... but not more often than this [s]."""

JUMP_SECONDS: Final = 0.015
JUMP_BEATS: Final = 0.02
"""A session whose beat is farther than this from where its tempo takes it has jumped."""

SAME_REPORTED_TEMPO: Final = 1e-6
"""Relative; Link's tempo is a whole number of microseconds per beat, so a new one differs by more."""


class LinkReports:
    """Decides what the show must hear of a session: that it is there, its next beat, its jumps and its transport.

    A session without others is not a source: the show would hear itself. With at least one peer it is "found", with
    none left "lost". Pure: what is read comes as values with times. Thread: one at a time.
    """

    def __init__(self, *, start_stop: bool = False, source: str = "link") -> None:
        """`start_stop`: whether "started" and "stopped" are told."""
        self._start_stop = start_stop
        self._source = source
        self._last: LinkReading | None = None
        self._due = -math.inf
        self._transport: tuple[bool, float] | None = None
        self._announce: tuple[str, float] | None = None

    @property
    def heard(self) -> bool:
        """Whether the session is a source now."""
        return self._last is not None

    def read(self, reading: LinkReading) -> list[ControlEvent]:
        """Events that this reading gives cause for, oldest first."""
        if not reading.peers:
            return self.end(reading.time, "nobody else is there") + self._transport_of(reading)
        events: list[ControlEvent] = []
        last, self._last = self._last, reading
        jump = False
        if last is None:
            events.append(self._changed("found", reading.time, peers_in_words(reading.peers)))
        else:
            jump = _jumped(last, reading)
        if jump or last is None or reading.time >= self._due or _differs(last, reading):
            self._due = reading.time + min(max(0.5 * reading.period, SHORTEST), LONGEST)
            events.append(self._beat(reading, jump))
        return events + self._transport_of(reading)

    def end(self, time: float, why: str) -> list[ControlEvent]:
        """The session is left, or all others have left it: "lost", if it was there."""
        if self._last is None:
            return []
        self._last = None
        return [self._changed("lost", time, why)]

    def _beat(self, reading: LinkReading, jump: bool) -> BeatHeard:
        """The next beat."""
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

    def _transport_of(self, reading: LinkReading) -> list[ControlEvent]:
        """A start is told at the measure line it waits for (STARTSTOPSTATE-1: "according to its quantization")."""
        if not self._start_stop:
            return []
        transport = (reading.playing, reading.since)
        if self._transport is None:  # what was so when we came is nobody's command
            self._transport = transport
        elif transport != self._transport:
            if reading.playing != self._transport[0]:
                at = _line_after(reading, reading.since) if reading.playing else reading.since
                self._announce = ("started" if reading.playing else "stopped", at)
            self._transport = transport
        if self._announce is None or reading.time < self._announce[1]:
            return []
        state, at = self._announce
        self._announce = None
        return [self._changed(state, at, "")]

    def _changed(self, state: str, time: float, detail: str) -> SourceChanged:
        return SourceChanged(time=time, source=self._source, state=state, detail=detail)


def peers_in_words(peers: int) -> str:
    """ "1 peer", "3 peers"."""
    return "1 peer" if peers == 1 else f"{peers} peers"


def _differs(last: LinkReading, reading: LinkReading) -> bool:
    return (
        abs(reading.tempo - last.tempo) > SAME_REPORTED_TEMPO * last.tempo
        or reading.beats_per_measure != last.beats_per_measure
        or reading.fold != last.fold
    )


def _jumped(last: LinkReading, reading: LinkReading) -> bool:
    """Whether the beat is not where the tempo, old or new, would have taken it since the last reading."""
    if reading.fold != last.fold or reading.beats_per_measure != last.beats_per_measure:
        return True
    elapsed = (reading.time - last.time) / 60.0
    ways = sorted((elapsed * last.tempo, elapsed * reading.tempo))
    middle, half = 0.5 * (ways[0] + ways[1]), 0.5 * (ways[1] - ways[0])
    off = apart(reading.beat - middle, last.beat, reading.beats_per_measure)
    return abs(off) > half + max(JUMP_BEATS, JUMP_SECONDS * reading.tempo / 60.0)


def _line_after(reading: LinkReading, time: float) -> float:
    """When the first measure line at or after `time` falls [s]."""
    beat = reading.beat + (time - reading.time) / reading.period
    measures = math.ceil(beat / reading.beats_per_measure - 1e-6)
    return time + (measures * reading.beats_per_measure - beat) * reading.period
