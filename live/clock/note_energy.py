"""NoteEnergy: what the notes that somebody plays are like: how hard, how dense, how many sound, where they lie.

Pure: messages come with their times [s], none is read. Time counts in beats, so that the same music at another tempo
is alike.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

HALF: Final = 1.0
"""Beats in which the energy of a stroke dies away to its half."""
WINDOW: Final = 4.0
"""Beats over which strokes are counted: the weight of one dies away to 1/e within them."""
TOGETHER: Final = 0.03
"""Seconds within which strokes are one chord, and count once."""
EVERY: Final = 1.0 / 16.0
"""Seconds from one telling to the next at least."""
LOWEST_KEY, HIGHEST_KEY = 21, 108
"""The piano's."""
SAME: Final = 0.01
"""Changes of less are not told, until all has died away."""
NOTE_OFF, NOTE_ON, CONTROLLER = 0x8, 0x9, 0xB
PEDAL: Final = 64
SILENT: Final = (120, 123, 124, 125, 126, 127)
"""Controllers that end all notes of their channel."""
RESET: Final = 0xFF


@dataclass(frozen=True, slots=True)
class NoteFigures:
    """What is played, as known at `time` [s]."""

    time: float
    beats: float
    """Beats since this was told last."""
    energy: float
    """0 to 1: the hardest of the strokes as they have died away."""
    density: float
    """Strokes per beat; those of a chord are one."""
    chord: int
    """Notes that sound: keys that are down, and those that a pedal holds."""
    pitch: float
    """0 to 1 over the piano's keys: the mean of what sounds, or last did."""


class NoteEnergy:
    """Listens to one port's notes. Thread: one at a time."""

    def __init__(self, *, tempo: float = 120.0) -> None:
        """`tempo` [bpm] may be set at any time."""
        self.tempo = tempo
        self._energy = 0.0
        self._density = 0.0
        self._pitch = 0.5
        self._down: set[tuple[int, int]] = set()  # (channel, key)
        self._held: set[tuple[int, int]] = set()  # let go while the pedal was down
        self._pedals: set[int] = set()
        self._struck_at = -math.inf
        self._at = 0.0
        self._told_at = -math.inf
        self._beats = 0.0
        self._told = (0.0, 0.0, 0, 0.5)

    def receive(self, message: Sequence[int], time: float) -> None:
        """A message that arrived at `time` [s]; those of no concern to notes change nothing."""
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
        """Nothing sounds any more: the port has gone, or says so."""
        self._down.clear()
        self._held.clear()
        self._pedals.clear()

    def advance(self, now: float) -> NoteFigures | None:
        """What is to be told at `now` [s]; None if that is what was told before, or was told just now."""
        self._age(now)
        if now - self._told_at < EVERY:
            return None
        sounding = self._down | self._held
        if sounding:
            mean = sum(key for _, key in sounding) / len(sounding)
            self._pitch = min(max((mean - LOWEST_KEY) / (HIGHEST_KEY - LOWEST_KEY), 0.0), 1.0)
        energy = self._energy if self._energy >= SAME else 0.0
        density = self._density if self._density >= SAME else 0.0
        new = (energy, density, len(sounding), self._pitch)
        if new[2] == self._told[2] and not any(_differs(a, b) for a, b in zip(new, self._told, strict=True)):
            return None
        beats, self._beats = self._beats, 0.0
        self._told, self._told_at = new, now
        return NoteFigures(now, beats, *new)

    def _age(self, now: float) -> None:
        beats = max(now - self._at, 0.0) * self.tempo / 60.0
        self._at = max(now, self._at)
        self._beats += beats
        self._energy *= 2.0 ** (-beats / HALF)
        self._density *= math.exp(-beats / WINDOW)

    def _strike(self, channel: int, key: int, velocity: float, time: float) -> None:
        self._age(time)
        self._energy = max(self._energy, velocity)
        if time - self._struck_at > TOGETHER:
            self._struck_at = time
            self._density += 1.0 / WINDOW
        self._down.add((channel, key))
        self._held.discard((channel, key))

    def _controller(self, channel: int, number: int, value: int) -> None:
        if number == PEDAL:
            if value >= 64:
                self._pedals.add(channel)
            else:
                self._pedals.discard(channel)
                self._held = {note for note in self._held if note[0] != channel}
        elif number in SILENT:
            self._down = {note for note in self._down if note[0] != channel}
            self._held = {note for note in self._held if note[0] != channel}


def _differs(now: float, before: float) -> bool:
    return abs(now - before) >= SAME or (now == 0.0) != (before == 0.0)
