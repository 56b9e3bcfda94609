"""Percussionists and samplers: lanes played over and over, loops cut from a drummer."""

from dataclasses import dataclass, field
from random import Random
from typing import Protocol

from training.music.drums import KIT, Groove
from training.music.form import Bar
from training.music.pattern import bar_of
from training.music.piece import Note


@dataclass(slots=True)
class Percussion:
    """Lanes played over and over with a chance to leave out hits; percussion, loops, clicks."""

    rng: Random
    groove: Groove
    drop: float = 0.04
    name: str = "percussion"
    tuned: dict[str, int] = field(default_factory=dict)  # pitches of lanes on instruments that are no drum kit

    def play(self, bar: Bar) -> list[Note]:
        beats = bar.metre.beats
        return [
            Note(at, 0.4, self.tuned.get(drum, KIT.get(drum, 60)), level)
            for drum, pattern in self.groove.hits(beats).items()
            for at, level in bar_of(pattern, bar.place, self.groove.bars, beats)
            if self.rng.random() > self.drop
        ]


class Loopable(Protocol):
    """Any player."""

    def play(self, bar: Bar) -> list[Note]:
        """The notes of a bar."""


@dataclass(slots=True)
class Loop:
    """A loop as a sampler plays it: what a player played in its first bars, mistakes and all, again and again."""

    rng: Random
    player: Loopable
    bars: int = 2
    loose: float = 0.012  # of a beat
    name: str = "drums"
    _kept: list[list[Note]] = field(default_factory=list)

    def play(self, bar: Bar) -> list[Note]:
        if len(self._kept) < self.bars:
            notes = [
                note._replace(start=max(0.0, note.start + self.rng.gauss(0, self.loose)) if note.start else 0.0)
                for note in self.player.play(bar)
            ]
            self._kept.append(notes)
            return notes
        return self._kept[bar.index % self.bars]
