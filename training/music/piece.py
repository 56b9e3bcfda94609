"""The words of the composer: metre, note, part, piece; and the performance of a piece in seconds."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from random import Random
from typing import NamedTuple

from training.music.tempo import Clock

DRUMS = -1
"""The program of a part that plays on the drum channel with the standard kit; -1 - n is kit n."""


@dataclass(frozen=True, slots=True)
class Metre:
    """Beats per bar and parts per beat (2: simple, 3: compound). `groups`: beats of the strong pulses of odd bars."""

    beats: int
    div: int = 2
    groups: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        return f"{self.beats * 3}/8" if self.div == 3 else f"{self.beats}/4"

    def strength(self, position: float) -> int:
        """Metrical weight of a position in the bar, in beats: 4 the downbeat, 3 half bar, 2 beat, 1 half, 0 finer."""
        if abs(position) < 1e-6 or abs(position - self.beats) < 1e-6:
            return 4
        if abs(position - round(position)) < 1e-6:
            beat = round(position)
            halves = self.beats % 2 == 0 and self.beats >= 4 and beat == self.beats // 2
            return 3 if halves or beat in self.groups else 2
        parts = position * self.div
        return 1 if abs(parts - round(parts)) < 1e-6 else 0


COMMON = Metre(4)
THREE = Metre(3)
TWO = Metre(2)
JIG = Metre(2, 3)
TWELVE = Metre(4, 3)


class Note(NamedTuple):
    """One note: start and length in beats (start from the bar's beginning while composing), MIDI pitch, velocity."""

    start: float
    length: float
    pitch: int
    velocity: float


@dataclass(slots=True)
class Feel:
    """How a player plays: swing (0.5 none .. 0.7) of halves and quarters of a beat, push and jitter in seconds."""

    swing: float = 0.5
    swing_fine: float = 0.5
    push: float = 0.0
    jitter: float = 0.004
    touch: float = 0.08  # spread of the velocities, as a share

    def warp(self, beat: float) -> float:
        """A position in beats with the swing in it."""
        if self.swing == 0.5 and self.swing_fine == 0.5:
            return beat
        whole = beat // 1
        part = beat - whole
        if self.swing_fine != 0.5:
            half = 0.5 * (part // 0.5)
            part = half + 0.5 * _bend((part - half) * 2, self.swing_fine)
        return whole + _bend(part, self.swing)


def _bend(part: float, swing: float) -> float:
    return part * 2 * swing if part < 0.5 else swing + (part - 0.5) * 2 * (1 - swing)


@dataclass(slots=True)
class Part:
    """What one player plays in the whole piece; note starts in beats from the piece's beginning."""

    name: str
    program: int
    notes: list[Note]
    feel: Feel
    volume: float = 1.0

    @property
    def drums(self) -> bool:
        return self.program < 0


class Sounding(NamedTuple):
    """A note as performed: seconds, seconds, MIDI channel, pitch, velocity 1..127."""

    time: float
    duration: float
    channel: int
    pitch: int
    velocity: int


@dataclass(slots=True)
class Piece:
    """A whole piece: parts in beats, metre, the clock that performs it. `ignore`: spans in which nobody could know."""

    style: str
    metre: Metre
    bpm: float
    bars: int
    parts: list[Part]
    clock: Clock
    has_downbeat: bool = True
    mutes: list[tuple[float, float]] = field(default_factory=list)  # spans of beats in which nobody plays

    def beats(self) -> list[tuple[float, int]]:
        """Seconds and place in the bar (1: the downbeat) of all beats."""
        times = self.clock.seconds([float(beat) for beat in range(self.bars * self.metre.beats)])
        return [(float(time), beat % self.metre.beats + 1) for beat, time in enumerate(times)]

    def programs(self) -> list[tuple[int, int]]:
        """MIDI channel and program of each part; kits are all on channel 9."""
        return [
            (_channel(index, part), max(0, -1 - part.program) if part.drums else part.program)
            for index, part in enumerate(self.parts)
        ]

    def perform(self, rng: Random) -> list[Sounding]:
        """All notes in seconds, in order of time, with each player's feel."""
        found: list[Sounding] = []
        for index, part in enumerate(self.parts):
            found.extend(self._part(part, _channel(index, part), rng))
        found.sort()
        return found

    def _part(self, part: Part, channel: int, rng: Random) -> Iterable[Sounding]:
        notes = [note for note in sorted(part.notes) if not _within(note.start, self.mutes)]
        starts = self.clock.seconds([part.feel.warp(note.start) for note in notes])
        periods = self.clock.periods([note.start for note in notes])
        stops = sorted(self.clock.stops())
        last, shift = -1.0, 0.0
        for note, start, period in zip(notes, starts, periods, strict=True):
            if note.start - last > 0.03:
                shift = rng.gauss(0.0, part.feel.jitter)
                last = note.start
            own = rng.gauss(0.0, part.feel.jitter * 0.4)
            time = max(0.0, float(start) + part.feel.push + shift + own)
            end = time + max(0.03, note.length * float(period))
            for stop in stops:
                if time < stop < end:
                    end = stop
                    break
            loud = note.velocity * part.volume * (1 + rng.gauss(0.0, part.feel.touch))
            yield Sounding(
                time, max(0.02, end - time), channel, min(127, max(0, note.pitch)), min(127, max(1, round(loud * 127)))
            )


def _within(beat: float, spans: list[tuple[float, float]]) -> bool:
    return any(start - 0.01 <= beat < end - 0.01 for start, end in spans)


def _channel(index: int, part: Part) -> int:
    if part.drums:
        return 9
    return index % 15 if index % 15 < 9 else index % 15 + 1
