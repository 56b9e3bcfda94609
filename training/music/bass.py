"""The bass player: roots on the strong places, walks, octaves, pedals, random grammars."""

from dataclasses import dataclass, field
from random import Random

from training.music.form import Bar
from training.music.harmony import Chord, nearest
from training.music.pattern import Pattern, bar_of, parse, weave
from training.music.piece import Note


@dataclass(slots=True)
class Bass:
    """A pattern of hits (chosen per section) with pitches by rule: `root`, `fifth`, `octave`, `arpeggio`, `scale`."""

    rng: Random
    lines: list[str]  # patterns of steps for one bar each
    manner: str = "root"
    low: int = 33
    legato: float = 0.9
    bars: int = 1
    grain: int = 2  # of a drawn pattern: steps per part of the beat
    name: str = "bass"
    _kept: dict[str, Pattern] = field(default_factory=dict)

    def play(self, bar: Bar) -> list[Note]:
        rng, beats = self.rng, bar.metre.beats
        pattern = self._kept.get(bar.section.label)
        if pattern is None:
            line = rng.choice(self.lines) if self.lines else ""
            pattern = parse(line, beats * self.bars) if line else weave(rng, bar.metre, 0.55, self.grain)
            self._kept[bar.section.label] = pattern
        hits = bar_of(pattern, bar.place, self.bars, beats)
        notes = []
        for index, (at, level) in enumerate(hits):
            end = hits[index + 1][0] if index + 1 < len(hits) else float(beats)
            chord = bar.chord_at(at)
            pitch = self._pitch(bar, chord, index, at, end)
            length = max(0.1, (end - at) * self.legato)
            notes.append(Note(at, length, pitch, 0.55 + 0.35 * level))
        for start, _, chord in bar.spans()[1:]:
            if not any(abs(at - start) < 0.3 for at, _ in hits):
                notes.append(Note(start, 0.8, self._root(chord), 0.8))
        return notes

    def _root(self, chord: Chord) -> int:
        return nearest(chord.bass, self.low + 5)

    def _pitch(self, bar: Bar, chord: Chord, index: int, at: float, end: float) -> int:
        rng, root = self.rng, self._root(chord)
        strong = bar.metre.strength(at) == 4 or any(abs(at - start) < 0.01 for start, _ in bar.chords)
        if strong or self.manner == "root":
            return root if rng.random() < 0.97 else root + 12
        if self.manner == "fifth":
            return root + rng.choice([7, -5]) if bar.metre.strength(at) >= 2 else root
        if self.manner == "octave":
            return root + 12 * (index % 2)
        if self.manner == "arpeggio":
            return nearest(rng.choice(chord.classes), root + 5)
        if end >= bar.metre.beats - 1e-6 and rng.random() < 0.5:  # lead to the next root
            return self._root(bar.following) + rng.choice([-1, 1, -2, 2])
        ladder = bar.key.ladder(root - 5, root + 12)
        return rng.choice(ladder)


@dataclass(slots=True)
class Walk:
    """A walking bass: one note per beat, chord tones on the strong beats, a step into the next root."""

    rng: Random
    low: int = 33
    skips: float = 0.12
    name: str = "bass"
    _last: int = 40

    def play(self, bar: Bar) -> list[Note]:
        rng, notes = self.rng, []
        for beat in range(bar.metre.beats):
            chord = bar.chord_at(beat)
            if any(abs(beat - start) < 0.01 for start, _ in bar.chords):
                pitch = nearest(chord.bass, self.low + 7)
            elif beat == bar.metre.beats - 1:
                pitch = nearest(bar.following.bass, self._last) + rng.choice([-1, 1, 1, -2, 2])
            else:
                step = rng.choice([-4, -3, -2, -1, 1, 2, 3, 4, 5])
                pitch = nearest(rng.choice(chord.classes), self._last + step)
            pitch = min(self.low + 24, max(self.low - 5, pitch))
            self._last = pitch
            notes.append(Note(beat, 0.92, pitch, 0.8 if beat % 2 == 0 else 0.74))
            if rng.random() < self.skips:
                notes.append(Note(beat + 2 / 3, 0.3, pitch, 0.55))
        return notes
