"""From a style's plan (form, players) to a piece: every player plays every bar; the clock; swing; stops and jumps."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Protocol

from training.music.form import Bar, Compose, bars_of, lay_out, song
from training.music.harmony import Key
from training.music.piece import COMMON, Feel, Metre, Note, Part, Piece
from training.music.tempo import Clock, change, expressive, human, steady


class Player(Protocol):
    """One who plays a bar at a time, in order. Notes start in beats from the bar's beginning."""

    def play(self, bar: Bar) -> list[Note]:
        """The notes of this bar (some may start before it: pickups)."""


def either(rng: Random, *players: Player) -> Player:
    """One of these players."""
    return rng.choice(players)


@dataclass(slots=True)
class Varied:
    """One who plays otherwise in other sections: one of these players for each label."""

    rng: Random
    players: Sequence[Player]
    name: str = "varied"
    _chosen: dict[str, Player] = field(default_factory=dict)

    def play(self, bar: Bar) -> list[Note]:
        label = bar.section.label
        if label not in self._chosen:
            unused = [player for player in self.players if player not in self._chosen.values()]
            self._chosen[label] = self.rng.choice(unused or list(self.players))
        return self._chosen[label].play(bar)


@dataclass(slots=True)
class Seat:
    """A player with a role in the form, an instrument and a feel."""

    role: str
    player: Player
    program: int
    volume: float = 1.0
    feel: Feel | None = None
    octave: int = 0


@dataclass(slots=True)
class Plan:
    """All that a style decides. `timing`: machine, human, expressive; `drift`: its size."""

    bpm: float
    seats: list[Seat]
    harmony: Compose
    key: Key
    metre: Metre = COMMON
    form: str = "song"
    sections: Sequence[tuple[str, float, Collection[str] | None]] = ()
    lengths: tuple[int, ...] = (4, 8, 8, 8, 16)
    timing: str = "human"
    drift: float = 0.012
    swing: float = 0.5
    swing_fine: float = 0.5
    tight: float = 1.0  # times the usual jitter of the players
    has_downbeat: bool = True
    steady_form: bool = False  # no stops, no jumps
    extras: list[Callable[[Piece, list[Bar]], None]] = field(default_factory=list)


def build(rng: Random, style: str, plan: Plan, seconds: float) -> Piece:
    """The piece, long enough for so many seconds and some bars."""
    metre = plan.metre
    wanted = int(seconds * plan.bpm / 60 / metre.beats * 1.25) + 6
    roles = {seat.role for seat in plan.seats}
    sections = plan.sections or song(rng, roles)
    laid = lay_out(rng, list(sections), wanted, plan.harmony, plan.lengths)
    bars = bars_of(laid, metre, plan.key)[: wanted + 2]
    parts = [_part(rng, seat, bars, plan, index) for index, seat in enumerate(plan.seats)]
    clock = _clock(rng, plan, len(bars))
    piece = Piece(style, metre, plan.bpm, len(bars), [part for part in parts if part.notes], clock, plan.has_downbeat)
    if {"drums", "comp", "bass"} <= roles and rng.random() < 0.15:
        _push(rng, piece)
    if not plan.steady_form:
        _surprise(rng, piece, bars)
    for extra in plan.extras:
        extra(piece, bars)
    return piece


def _part(rng: Random, seat: Seat, bars: list[Bar], plan: Plan, index: int) -> Part:
    notes: list[Note] = []
    for bar in bars:
        roles = bar.section.roles
        played = seat.player.play(bar)
        if roles is not None and seat.role not in roles and seat.role != "always":
            continue
        start = bar.index * bar.metre.beats
        loud = 0.75 + 0.3 * bar.energy
        notes += [
            Note(start + note.start, note.length, note.pitch + 12 * seat.octave, note.velocity * loud)
            for note in played
            if start + note.start > -0.01
        ]
    feel = seat.feel or feel_of(rng, plan, seat.role)
    return Part(seat.role + str(index), seat.program, notes, feel, seat.volume * rng.uniform(0.8, 1.1))


def feel_of(rng: Random, plan: Plan, role: str) -> Feel:
    """How a player of this role plays in this plan: a machine exactly, people with their habits."""
    if plan.timing == "machine":
        jitter = rng.choice([0.0, 0.0, 0.002])
        return Feel(plan.swing, plan.swing_fine, 0.0, jitter, rng.choice([0.01, 0.05, 0.1]))
    jitter = rng.uniform(0.002, 0.010) * plan.tight
    push = rng.gauss(0.0, 0.006 if role in ("drums", "bass") else 0.009) * plan.tight
    swing = plan.swing + (rng.gauss(0, 0.012) if plan.swing != 0.5 else 0.0)
    return Feel(swing, plan.swing_fine, max(-0.022, min(0.022, push)), jitter, rng.uniform(0.05, 0.14))


def _clock(rng: Random, plan: Plan, bars: int) -> Clock:
    beats = bars * plan.metre.beats
    if plan.timing == "machine":
        return steady(beats, plan.bpm)
    if plan.timing == "expressive":
        return expressive(rng, bars, plan.metre.beats, plan.bpm, plan.drift)
    return human(rng, beats, plan.bpm, plan.drift * rng.uniform(0.3, 1.6))


def _push(rng: Random, piece: Piece) -> None:
    """The band anticipates: at some bars of each phrase what belongs on one comes half a beat (or a quarter) before."""
    cycle = rng.choice([2, 2, 4, 4, 8])
    places = rng.sample(range(cycle), rng.choice([1, 1, cycle // 2]))
    early = 0.5 if piece.bpm > 84 or rng.random() < 0.5 else 0.25
    beats = piece.metre.beats
    for part in piece.parts:
        if part.drums and rng.random() < 0.3:
            continue
        for index, note in enumerate(part.notes):
            bar, rest = divmod(note.start, beats)
            pushed = not part.drums or note.pitch in (35, 36, 49, 57)
            if bar and rest < 0.01 and bar % cycle in places and pushed:
                part.notes[index] = note._replace(start=note.start - early, length=note.length + early)


def _surprise(rng: Random, piece: Piece, bars: list[Bar]) -> None:
    """Seldom: a jump or a ramp of the tempo, a stop, a silence on the grid; at the beginning of a section mostly."""
    starts = [bar.index for bar in bars if bar.place == 0 and bar.index] or [len(bars) // 2]
    beats = piece.metre.beats
    draw = rng.random()
    at = rng.choice(starts) * beats if rng.random() < 0.75 else rng.randrange(4, max(5, len(bars) * beats - 8))
    if draw < 0.08:
        step = rng.choice([rng.uniform(0.65, 0.85), rng.uniform(0.65, 0.85), rng.uniform(1.15, 1.35)])
        change(rng, piece.clock, at, rng.choice([step, step, 0.9, 1.1, rng.uniform(0.65, 1.5)]))
    elif draw < 0.13:
        change(rng, piece.clock, at, rng.uniform(0.75, 1.35), rng.choice([4, 8, 16, 32]))
    elif draw < 0.21:  # a stop, and on again when they like
        at -= at % beats
        piece.clock.gaps.append((float(at), rng.choice([rng.uniform(0.3, 2.0), rng.uniform(3.0, 16.0)])))
        if rng.random() < 0.4:
            piece.mutes.append((float(at - rng.choice([0.5, 1, 2, beats - 1])), float(at)))
    elif draw < 0.35:  # a rest through which the beat goes on in silence
        piece.mutes.append((float(at), float(at + _rest(rng, piece))))
    elif draw < 0.38:  # the tempo wanders off and comes back
        change(rng, piece.clock, at, rng.uniform(0.85, 1.18), 8)
        change(rng, piece.clock, at + 16, rng.uniform(0.85, 1.18), 8)


def _rest(rng: Random, piece: Piece) -> int:
    """Beats of a rest on the grid: a few beats, or whole bars, of 2 to 16 seconds."""
    beats = piece.metre.beats
    if rng.random() < 0.2:
        return rng.choice([1, 2, 2, beats])
    bars = rng.uniform(2.0, rng.choice([5.0, 9.0, 16.0])) * piece.bpm / 60 / beats
    return beats * max(1, round(bars))
