"""Accompanists: chords struck in patterns, held pads, arpeggios, oom-pah, strums, alberti figures."""

from dataclasses import dataclass, field
from random import Random

from training.music.form import Bar
from training.music.harmony import voicing
from training.music.pattern import Pattern, bar_of, parse, weave
from training.music.piece import Note


@dataclass(slots=True)
class Comp:
    """Chords in a pattern of steps; with `strum` seconds-like spread in beats, up and down strokes by step."""

    rng: Random
    lines: list[str]
    centre: int = 60
    voices: int = 3
    legato: float = 0.8
    strum: float = 0.0
    bars: int = 1
    anticipate: float = 0.0  # chance that a chord comes half a beat before its bar
    level: float = 0.62
    grain: int = 2  # of a drawn pattern: steps per part of the beat
    name: str = "comp"
    _kept: dict[str, Pattern] = field(default_factory=dict)
    _voices: list[int] = field(default_factory=list)

    def play(self, bar: Bar) -> list[Note]:
        rng, beats = self.rng, bar.metre.beats
        label = bar.section.label
        if label not in self._kept:
            line = rng.choice(self.lines) if self.lines else ""
            self._kept[label] = (
                parse(line, beats * self.bars) if line else weave(rng, bar.metre, rng.uniform(0.2, 0.6), self.grain)
            )
        hits = bar_of(self._kept[label], bar.place, self.bars, beats)
        notes: list[Note] = []
        for index, (at, strength) in enumerate(hits):
            end = hits[index + 1][0] if index + 1 < len(hits) else float(beats)
            self._voices = voicing(bar.chord_at(at), self.centre, self.voices, self._voices)
            early = -0.5 if at == 0 and not bar.first and rng.random() < self.anticipate else 0.0
            pitches = self._voices if round(at * 4) % 4 != 2 else self._voices[::-1]
            for place, pitch in enumerate(pitches):
                length = max(0.08, (end - at) * self.legato)
                notes.append(
                    Note(at + early + place * self.strum, length - early, pitch, self.level * (0.6 + 0.5 * strength))
                )
        return notes


@dataclass(slots=True)
class Pad:
    """Chords held for as long as they last, struck again each so many bars, or at the chord's change only."""

    rng: Random
    centre: int = 60
    voices: int = 4
    level: float = 0.5
    again: bool = True
    late: float = 0.0
    name: str = "pad"
    _voices: list[int] = field(default_factory=list)
    _last: object = None

    def play(self, bar: Bar) -> list[Note]:
        notes = []
        for start, length, chord in bar.spans():
            if not self.again and chord == self._last and bar.place % 4:
                continue
            self._last = chord
            self._voices = voicing(chord, self.centre, self.voices, self._voices)
            hold = length if self.again else length * 2
            notes += [Note(start + self.late, hold, pitch, self.level) for pitch in self._voices]
        return notes


@dataclass(slots=True)
class Arpeggio:
    """The chord's notes one after the other in a shape that repeats with the chord or the bar.

    `shape`: indices into the voicing (octaves added past its end); None: drawn once. `rate`: notes per beat.
    """

    rng: Random
    rate: int = 2
    shape: tuple[int, ...] | None = None
    centre: int = 60
    voices: int = 3
    hold: float = 1.0
    level: float = 0.58
    accent: float = 0.18
    gaps: float = 0.0
    name: str = "arpeggio"
    _voices: list[int] = field(default_factory=list)

    def play(self, bar: Bar) -> list[Note]:
        rng = self.rng
        if self.shape is None:
            size = rng.choice([self.rate, self.rate * 2, bar.metre.beats * self.rate])
            self.shape = tuple([0] + [rng.randrange(0, self.voices + 2) for _ in range(size - 1)])
        notes = []
        for start, length, chord in bar.spans():
            self._voices = voicing(chord, self.centre, self.voices, self._voices)
            for step in range(round(length * self.rate)):
                if step and rng.random() < self.gaps:
                    continue
                index = self.shape[step % len(self.shape)]
                octave, place = divmod(index, len(self._voices))
                at = start + step / self.rate
                weight = bar.metre.strength(at) / 4
                notes.append(
                    Note(
                        at, self.hold / self.rate, self._voices[place] + 12 * octave, self.level + self.accent * weight
                    )
                )
        return notes


@dataclass(slots=True)
class Oompah:
    """Bass note on the strong beats, chord on the weak beats (or on the halves where there are two beats)."""

    rng: Random
    centre: int = 60
    low: int = 40
    halves: bool = False
    dry: float = 0.45
    chords: bool = True
    bass: bool = True
    name: str = "comp"
    _voices: list[int] = field(default_factory=list)

    def play(self, bar: Bar) -> list[Note]:
        notes: list[Note] = []
        beats = bar.metre.beats
        for beat in range(beats):
            chord = bar.chord_at(beat)
            self._voices = voicing(chord, self.centre, 3, self._voices)
            low = self.low + ((chord.bass - self.low) % 12)
            strong = beat == 0 or (self.halves or (beats == 4 and beat == 2))
            if strong and self.bass:
                fifth = beat > 0 or (beats == 3 and bar.place % 2 == 1)
                notes.append(Note(beat, 0.6, low + (7 if fifth and low < self.low + 5 else -5 if fifth else 0), 0.78))
            if not self.chords or (strong and not self.halves):
                continue
            at = beat + (0.5 if self.halves and bar.metre.div == 2 else 2 / 3 if self.halves else 0.0)
            notes += [Note(at, self.dry, pitch, 0.55) for pitch in self._voices]
        return notes
