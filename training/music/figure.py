"""What goes along with a melody or stands in for it: second voices, riffs."""

from dataclasses import dataclass, field
from random import Random

from training.music.form import Bar
from training.music.melody import Melody
from training.music.pattern import Pattern
from training.music.piece import Note


@dataclass(slots=True)
class Shadow:
    """Another voice of a melody: the same rhythm a third, sixth or octave away, in the scale."""

    of: Melody
    steps: int = -2
    level: float = 0.8
    name: str = "second"

    def play(self, bar: Bar) -> list[Note]:
        ladder = bar.key.ladder(20, 110)
        notes = []
        for note in self.of.play(bar):
            place = min(range(len(ladder)), key=lambda index: abs(ladder[index] - note.pitch))
            shifted = ladder[min(len(ladder) - 1, max(0, place + self.steps))]
            notes.append(note._replace(pitch=shifted, velocity=note.velocity * self.level))
        return notes


@dataclass(slots=True)
class Figure:
    """Riff: pitches and rhythm of a bar or two, again and again above the chord's root; `pool`: steps above it."""

    rng: Random
    pattern: Pattern
    pool: tuple[int, ...] = (0, 0, 0, 3, 5, 7, 10)
    low: int = 40
    bars: int = 1
    power: bool = False
    palm: float = 0.5
    level: float = 0.75
    name: str = "riff"
    _steps: list[int] = field(default_factory=list)

    def play(self, bar: Bar) -> list[Note]:
        if not self._steps:
            self._steps = [0 if at == 0 else self.rng.choice(self.pool) for at, _ in self.pattern]
        beats = bar.metre.beats
        start = (bar.place % self.bars) * beats
        notes = []
        for index, (at, level) in enumerate(self.pattern):
            if not start - 1e-6 <= at < start + beats - 1e-6:
                continue
            after = self.pattern[index + 1][0] if index + 1 < len(self.pattern) else float(beats * self.bars)
            root = self.low + ((bar.chord_at(at - start).root - self.low) % 12)
            length = min(after - at, 4.0) * (self.palm if level < 0.8 else 0.95)
            for shift in (0, 7, 12) if self.power else (0,):
                pitch = root + self._steps[index] + shift
                notes.append(Note(at - start, max(0.1, length), pitch, self.level * (0.6 + 0.4 * level)))
        return notes
