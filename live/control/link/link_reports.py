"""LinkReports: readings of a Link session in, events for the show out."""

import math
from typing import Final

from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.control.link.link_reading import LinkReading, apart

LONGEST: Final = 0.5
"""A beat is named at least so often [s], and twice in every beat ..."""

SHORTEST: Final = 0.05
"""... but not more often than this [s]."""

JUMP_SECONDS: Final = 0.015
JUMP_BEATS: Final = 0.02
"""A session whose beat is farther than this from where its tempo takes it has jumped."""

SAME_TEMPO: Final = 1e-6
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
        abs(reading.tempo - last.tempo) > SAME_TEMPO * last.tempo
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
