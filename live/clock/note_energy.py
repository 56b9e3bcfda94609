"""Energy, density, chord size and pitch of played MIDI notes.

Pure: messages come with their times [s]. Decay is counted in beats, so that the same music at another tempo gives
the same figures.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

ENERGY_HALF_LIFE: Final = 1.0
"""Half-life of a stroke's energy [beats]."""
DENSITY_WINDOW: Final = 4.0
"""Window of the stroke density [beats]: a stroke's weight falls to 1/e within it."""
CHORD_SPAN: Final = 0.03
"""Strokes within this time [s] are one chord and count once."""
REPORT_INTERVAL: Final = 1.0 / 16.0
"""Minimum time between two reports [s]."""
LOWEST_KEY, HIGHEST_KEY = 21, 108
"""Range of a piano."""
MIN_CHANGE: Final = 0.01
"""Smaller changes are not reported, except a decay to 0."""
NOTE_OFF, NOTE_ON, CONTROLLER = 0x8, 0x9, 0xB
PEDAL: Final = 64
NOTES_OFF_CONTROLLERS: Final = (120, 123, 124, 125, 126, 127)
"""Controllers that end all notes of their channel."""
RESET: Final = 0xFF


@dataclass(frozen=True, slots=True)
class NoteFigures:
    """Figures of the music played, at `time` [s]."""

    time: float
    beats: float
    """Beats since the last report."""
    energy: float
    """0 to 1: the strongest stroke after its decay."""
    density: float
    """Strokes per beat; a chord counts once."""
    chord: int
    """Number of sounding notes: keys that are down, and notes held by a pedal."""
    pitch: float
    """0 to 1 over the piano's keys: the mean of the sounding notes, or of the last ones."""


class NoteEnergy:
    """Tracks the notes of one port. Thread: one at a time."""

    def __init__(self, *, tempo: float = 120.0) -> None:
        """`tempo` [bpm] may be set at any time."""
        self.tempo = tempo
        self._energy = 0.0
        self._density = 0.0
        self._pitch = 0.5
        self._down: set[tuple[int, int]] = set()  # (channel, key)
        self._held: set[tuple[int, int]] = set()  # released while the pedal was down
        self._pedals: set[int] = set()
        self._last_stroke_at = -math.inf
        self._at = 0.0
        self._reported_at = -math.inf
        self._beats = 0.0
        self._reported = (0.0, 0.0, 0, 0.5)

    def receive(self, message: Sequence[int], time: float) -> None:
        """Handle a message that arrived at `time` [s]; messages other than notes, pedals and resets change nothing."""
        if len(message) == 1 and message[0] == RESET:
            self.silence()
        if len(message) != 3 or not 0x80 <= message[0] < 0xC0 or max(message[1:]) > 127:
            return
        status, channel, key = message[0] >> 4, message[0] & 15, message[1]
        if status == CONTROLLER:
            self._controller(channel, key, message[2])
        elif status == NOTE_ON and message[2] > 0:
            self._strike(channel, key, message[2] / 127.0, time)
        elif status in (NOTE_OFF, NOTE_ON) and (channel, key) in self._down:
            self._down.discard((channel, key))
            if channel in self._pedals:
                self._held.add((channel, key))

    def silence(self) -> None:
        """End all notes: the port has gone, or has sent a reset."""
        self._down.clear()
        self._held.clear()
        self._pedals.clear()

    def advance(self, now: float) -> NoteFigures | None:
        """Return the figures at `now` [s]; None if they have not changed or were reported just now."""
        self._age(now)
        if now - self._reported_at < REPORT_INTERVAL:
            return None
        sounding = self._down | self._held
        if sounding:
            mean = sum(key for _, key in sounding) / len(sounding)
            self._pitch = min(max((mean - LOWEST_KEY) / (HIGHEST_KEY - LOWEST_KEY), 0.0), 1.0)
        energy = self._energy if self._energy >= MIN_CHANGE else 0.0
        density = self._density if self._density >= MIN_CHANGE else 0.0
        new = (energy, density, len(sounding), self._pitch)
        if new[2] == self._reported[2] and not any(_differs(a, b) for a, b in zip(new, self._reported, strict=True)):
            return None
        beats, self._beats = self._beats, 0.0
        self._reported, self._reported_at = new, now
        return NoteFigures(now, beats, *new)

    def _age(self, now: float) -> None:
        beats = max(now - self._at, 0.0) * self.tempo / 60.0
        self._at = max(now, self._at)
        self._beats += beats
        self._energy *= 2.0 ** (-beats / ENERGY_HALF_LIFE)
        self._density *= math.exp(-beats / DENSITY_WINDOW)

    def _strike(self, channel: int, key: int, velocity: float, time: float) -> None:
        self._age(time)
        self._energy = max(self._energy, velocity)
        if time - self._last_stroke_at > CHORD_SPAN:
            self._last_stroke_at = time
            self._density += 1.0 / DENSITY_WINDOW
        self._down.add((channel, key))
        self._held.discard((channel, key))

    def _controller(self, channel: int, number: int, value: int) -> None:
        if number == PEDAL:
            if value >= 64:
                self._pedals.add(channel)
            else:
                self._pedals.discard(channel)
                self._held = {note for note in self._held if note[0] != channel}
        elif number in NOTES_OFF_CONTROLLERS:
            self._down = {note for note in self._down if note[0] != channel}
            self._held = {note for note in self._held if note[0] != channel}


def _differs(now: float, before: float) -> bool:
    return abs(now - before) >= MIN_CHANGE or (now == 0.0) != (before == 0.0)
