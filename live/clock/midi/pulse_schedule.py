"""Generation of MIDI clock messages for a `Timeline`, with their times.

The song begins at the first measure line. Pulses follow slow changes of the timeline. When it jumps (a new song, a
tap on the downbeat), the song is stopped, located and continued at the next sixteenth, the resolution of the song
position.
"""

import math
from dataclasses import dataclass
from typing import Final

from live.clock.midi.midi_clock import (
    CLOCK,
    CONTINUE,
    PULSES_PER_BEAT,
    PULSES_PER_SIXTEENTH,
    SONG_POSITION,
    START,
    STOP,
)
from live.clock.timeline import Timeline

JUMP: Final = 3.0
"""Deviation of the timeline in pulses that counts as a jump."""

SIXTEENTHS: Final = 1 << 14
"""Number of song positions that a message can express."""


@dataclass(frozen=True, slots=True)
class PulseMessages:
    """Messages to be sent together at `time` [s]."""

    time: float
    messages: tuple[bytes, ...]


class PulseSchedule:
    """One song. Pure. Thread: one at a time."""

    def __init__(self) -> None:
        self._next: int | None = None
        self._begun_at = 0
        self._begun = False
        self._running = False
        self._stop = False
        self.jumps = 0

    def next_pulse(self, timeline: Timeline, now: float) -> PulseMessages:
        """Return the next pulse and the messages before it, at its time on the timeline; the same one until `mark_sent`
        is called."""
        here = (timeline.beat_at(now) - timeline.measure_origin) * PULSES_PER_BEAT
        if self._next is None:
            self._next = math.ceil(here)
        elif not -JUMP <= self._next - here <= JUMP + 1.0:
            self._next = math.ceil(here)
            self.jumps += 1
            self._stop, self._running = self._stop or self._running, False
        time = timeline.time_at(timeline.measure_origin + self._next / PULSES_PER_BEAT)
        stop = (bytes((STOP,)),) if self._stop else ()
        return PulseMessages(time, (*stop, *self._transport(timeline), bytes((CLOCK,))))

    def mark_sent(self, timeline: Timeline) -> None:
        """Confirm that the messages of `next_pulse` were sent."""
        assert self._next is not None  # `next_pulse` came first
        if self._transport(timeline):
            if self._starts(timeline):
                self._begun_at, self._begun = self._next, True
            self._running = True
        self._stop = False
        self._next += 1

    def relocate(self) -> None:
        """Send the song position again, for a new receiver."""
        self._running = False

    def _starts(self, timeline: Timeline) -> bool:
        """Whether the song starts, or starts again, at the next pulse."""
        assert self._next is not None
        fresh = not self._begun or self._next < self._begun_at
        return fresh and self._next % (PULSES_PER_BEAT * timeline.beats_per_measure) == 0

    def _transport(self, timeline: Timeline) -> tuple[bytes, ...]:
        if self._running or self._next is None:
            return ()
        if self._starts(timeline):
            return (bytes((START,)),)
        position, rest = divmod(self._next - self._begun_at, PULSES_PER_SIXTEENTH)
        if not self._begun or rest or position < 0:
            return ()
        measure = 4 * timeline.beats_per_measure
        position %= SIXTEENTHS // measure * measure
        return bytes((SONG_POSITION, position & 127, position >> 7)), bytes((CONTINUE,))
