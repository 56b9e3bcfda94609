"""Melodies: rhythmic motifs that repeat and vary in phrases, chord tones on strong beats, pickups, long last notes."""

from dataclasses import dataclass, field
from random import Random

from training.music.form import Bar
from training.music.harmony import nearest
from training.music.pattern import Pattern
from training.music.piece import Metre, Note

Rhythm = list[tuple[float, float]]
"""Position and length of each note of a bar, in beats."""


def rhythm(rng: Random, metre: Metre, pace: float = 0.5, sync: float = 0.1, rest: float = 0.12) -> Rhythm:
    """One bar: long notes on strong places, short ones between; `pace` 0 (long) .. 1 (running), `sync` off the beat."""
    unit = 1.0 / metre.div
    found: Rhythm = []
    at = 0.0
    while at < metre.beats - 1e-6:
        strong = metre.strength(at)
        room = metre.beats - at
        choices = [(unit, 0.3 + 1.5 * pace), (2 * unit, 0.5), (1.0, 1.0 if strong >= 2 else 0.15), (3 * unit, 0.25)]
        choices += [(2.0, 0.7 * (1 - pace) * (strong >= 3)), (float(metre.beats), 0.3 * (1 - pace) * (strong == 4))]
        if metre.div == 2 and pace > 0.4:
            choices.append((0.25, 0.8 * pace * (1 - 0.5 * (strong >= 2))))
            choices.append((0.75, 0.25 * (strong >= 2)))
        if metre.div == 2 and rng.random() < 0.03 and strong >= 2:
            found += [(at + step / 3, 1 / 3) for step in range(3)]
            at += 1.0
            continue
        fits = [(length, weight) for length, weight in choices if length <= room + 1e-6 and weight > 0]
        length = rng.choices([choice[0] for choice in fits], [choice[1] for choice in fits])[0] if fits else room
        beyond = (at // 1) + 1
        if at % 1 and at + length > beyond + 1e-6 and rng.random() > sync:
            length = beyond - at
        if at == 0 or rng.random() > rest:
            found.append((round(at, 6), length))
        at = round(at + length, 6)
    if rng.random() < sync * 0.6:
        found = [(max(0.0, start - unit) if rng.random() < 0.3 and start else start, length) for start, length in found]
    return found


@dataclass(slots=True)
class Melody:
    """One voice. A section's melody is made once per label: motifs a, b in the order of a drawn plan of bars."""

    rng: Random
    low: int = 60
    high: int = 84
    pace: float = 0.5
    sync: float = 0.12
    rest: float = 0.12
    pickup: float = 0.4
    leap: float = 0.2
    legato: float = 0.92
    level: float = 0.75
    repeat: float = 0.75
    silence: float = 0.1  # chance that a phrase of four bars stays empty
    name: str = "lead"
    given: Pattern | None = None  # a rhythm to play in every bar
    ornaments: float = 0.0  # chance of a grace note, turn or trill on a note
    _plans: dict[str, list[list[Note]]] = field(default_factory=dict)

    def play(self, bar: Bar) -> list[Note]:
        key = f"{bar.section.label}{bar.section.bars}"
        plan = self._plans.setdefault(key, [])
        while len(plan) <= bar.place:
            plan.append([])
            self._bar(bar, plan, len(plan) - 1)
        return plan[bar.place]

    def _bar(self, bar: Bar, plan: list[list[Note]], place: int) -> None:
        """Composes the bar `place`; later bars take up the rhythm of the first two of their phrase."""
        rng, metre = self.rng, bar.metre
        within = place % 4
        if within == 0:
            self._motifs = [rhythm(rng, metre, self.pace, self.sync, self.rest) for _ in range(2)]
            if place and rng.random() < self.repeat and plan[0]:
                self._motifs = self._first
            if place == 0:
                self._first = self._motifs
            self._empty = rng.random() < self.silence
            self._order = rng.choice(
                [(0, 1, 0, 2), (0, 0, 0, 2), (0, 0, 1, 2), (0, 1, 0, 1), (0, 0, 1, 1), (0, 1, 1, 2)]
            )
        if self._empty:
            return
        which = self._order[within]
        line = (
            rhythm(rng, metre, self.pace, self.sync, self.rest)
            if rng.random() > self.repeat
            else (self._motifs[min(which, 1)])
        )
        if which == 2:  # a phrase closes on a long note
            line = [(start, length) for start, length in line if start < metre.beats / 2 - 1e-6 and start < 2] or line[
                :1
            ]
            start = line[-1][0] if rng.random() < 0.7 or len(line) > 2 else 0.0
            line = [*line[:-1], (start, (metre.beats - start) * rng.uniform(0.5, 0.95))]
        if self.given is not None:
            starts = [at for at, _ in self.given]
            line = [(at, after - at) for at, after in zip(starts, [*starts[1:], float(metre.beats)], strict=True)]
        plan[place] = self._pitches(bar, line, closing=which == 2)
        if within == 0 and rng.random() < self.pickup:
            plan[place] = self._before(bar, plan[place]) + plan[place]

    _last: int = 0
    _motifs: list[Rhythm] = field(default_factory=list)
    _first: list[Rhythm] = field(default_factory=list)
    _order: tuple[int, ...] = (0, 1, 0, 2)
    _empty: bool = False

    def _pitches(self, bar: Bar, line: Rhythm, closing: bool) -> list[Note]:
        rng, metre = self.rng, bar.metre
        ladder = bar.key.ladder(self.low, self.high)
        notes = []
        last = self._last or rng.choice(ladder)
        direction = rng.choice([-1, 1])
        for at, length in line:
            strength = metre.strength(at)
            chord = bar.chord_at(at)
            step = rng.choice([1, 1, 1, 2, 0]) if rng.random() > self.leap else rng.randint(2, 5)
            if rng.random() < 0.3:
                direction = -direction
            place = min(range(len(ladder)), key=lambda index: abs(ladder[index] - last))
            place = place + direction * step
            if not 0 <= place < len(ladder):
                direction = -direction
                place = min(len(ladder) - 1, max(0, place + 2 * direction * step))
            pitch = ladder[place]
            if strength >= 3 or (length >= 1 and rng.random() < 0.8) or (closing and (at, length) == line[-1]):
                options = [nearest(name, pitch) for name in chord.classes]
                pitch = min(options, key=lambda option: abs(option - pitch))
            last = pitch
            note = Note(at, max(0.1, length * self.legato), pitch, self.level * (0.82 + 0.05 * strength))
            notes += self._adorn(note, ladder) if rng.random() < self.ornaments else [note]
        self._last = last
        return notes

    def _adorn(self, note: Note, ladder: list[int]) -> list[Note]:
        """The note with a grace note before it, or (where it is long) as a turn or a trill with its upper neighbour."""
        above = next((pitch for pitch in ladder if pitch > note.pitch), note.pitch + 2)
        if note.length < 0.7 or self.rng.random() < 0.4:
            early = self.rng.choice([0.06, 0.1])
            return [Note(note.start - early if note.start else 0.0, 0.08, above, note.velocity * 0.8), note]
        step = self.rng.choice([0.125, 1 / 6])
        count = int(min(note.length, self.rng.choice([0.5, 1.0, note.length])) / step)
        shaken = [
            note._replace(
                start=note.start + turn * step,
                length=step,
                pitch=above if turn % 2 else note.pitch,
                velocity=note.velocity * (1.0 if turn == 0 else 0.75),
            )
            for turn in range(count)
        ]
        rest = note.length - count * step
        return [
            *shaken,
            note._replace(start=note.start + count * step, length=max(0.1, rest), velocity=note.velocity * 0.8),
        ]

    def _before(self, bar: Bar, notes: list[Note]) -> list[Note]:
        """A pickup: one to three notes that lead into the first."""
        count = self.rng.choice([1, 1, 2, 3])
        unit = self.rng.choice([1.0 / bar.metre.div, 1.0 / bar.metre.div, 1.0])
        first = notes[0].pitch if notes else self.low
        ladder = bar.key.ladder(self.low - 5, self.high + 5)
        place = min(range(len(ladder)), key=lambda index: abs(ladder[index] - first))
        side = self.rng.choice([-1, -1, 1])
        if bar.first:
            return []
        return [
            Note(
                -unit * (count - index),
                unit * 0.9,
                ladder[min(len(ladder) - 1, max(0, place + side * (count - index)))],
                self.level * 0.78,
            )
            for index in range(count)
        ]
