"""Test harness: music with known beats, players that report them, and a follower run tick by tick."""

import random
from bisect import bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.ticks import TICK


class Music:
    """Beats 0, 1, 2 … at known times, `metre` in a measure."""

    def __init__(self, parts: Iterable[tuple[float, float]], *, start: float = 0.0, metre: int = 4) -> None:
        """`parts`: (bpm, beats) one after the other."""
        self.times = [start]
        for bpm, beats in parts:
            self.times += [self.times[-1] + 60.0 / bpm * (k + 1) for k in range(round(beats))]
        self.metre = metre

    def beat_at(self, time: float) -> float:
        k = min(max(bisect_right(self.times, time) - 1, 0), len(self.times) - 2)
        return k + (time - self.times[k]) / (self.times[k + 1] - self.times[k])

    def period(self, beat: int) -> float:
        k = min(beat, len(self.times) - 2)
        return self.times[k + 1] - self.times[k]


@dataclass
class Player:
    """Reports every beat of `music` as the source `name`: `lead` [s] ahead, with `jitter` [s]; `rate` of its clock.
    `wild` gives (factor of the period, error [s]) for single beats.
    """

    music: Music
    name: str = "audio"
    lead: float = 0.08
    jitter: float = 0.0
    seed: int = 1
    rate: float = 1.0
    knows: bool = True
    late: int = 0
    """Beats after a tempo change that are still reported at the old tempo (a slow tracker)."""
    per_beat: int = 1
    jump_at: int = -1
    wild: Callable[[int], tuple[float, float]] = lambda beat: (1.0, 0.0)
    on: bool = True
    _next: int = 0
    _random: random.Random = field(default_factory=random.Random)

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)

    def play(self, follower: TimelineFollower, now: float) -> None:
        times, lead = self.music.times, self.lead
        while self._next < (len(times) - 1) * self.per_beat:
            beat, part = divmod(self._next, self.per_beat)
            said_at = times[beat] - lead + part / self.per_beat * self.music.period(max(beat - 1, 0))
            if said_at > now:
                return
            self._next += 1
            if not self.on or now - said_at > 1.0:
                continue
            factor, error = self.wild(beat)
            period = self.music.period(beat) * factor
            time = times[beat] + error + self._random.gauss(0.0, self.jitter)
            if part:
                period = self.music.period(max(beat - 1, 0))
            follower.observe(
                time, period * self.rate, 0.8, now, source=self.name,
                beat=beat % self.music.metre if self.knows else -1, beats_per_measure=self.music.metre * self.knows,
                measure=beat // self.music.metre if self.name != "audio" else -1,
                jump=beat == self.jump_at and not part,
            )  # fmt: skip


class Hall:
    """Runs a follower tick by tick and records its output."""

    def __init__(self, follower: TimelineFollower | None = None, *players: Player) -> None:
        self.follower = follower or TimelineFollower()
        self.players = list(players)
        self.ticks = 0
        self.rows: list[tuple[float, float, float, str, str, int]] = []
        self.follower.advance(0.0)

    @property
    def now(self) -> float:
        return self.ticks * TICK

    def until(self, end: float, *script: tuple[float, Callable[[TimelineFollower], None]]) -> "Hall":
        """Run to `end` [s]; `script`: (time, action) pairs."""
        waiting = sorted(script, key=lambda row: row[0])
        while self.now < end:
            self.ticks += 1
            for player in self.players:
                player.play(self.follower, self.now)
            while waiting and waiting[0][0] <= self.now:
                waiting.pop(0)[1](self.follower)
            timeline = self.follower.advance(self.now)
            self.rows.append((
                self.now, timeline.beat_at(self.now), self.follower.tempo, self.follower.state, self.follower.source,
                timeline.measure_at(self.now),
            ))  # fmt: skip
        return self

    def off(self, music: Music, start: float, end: float, *, whole: float = 1.0) -> "np.ndarray":
        """Error of the Timeline between two times [s], wrapped to half a beat (`whole`: to half that many beats)."""
        rows = [(time, beat) for time, beat, *_ in self.rows if start <= time < end]
        phase = np.array([beat - self.follower.timeline.measure_origin - music.beat_at(t) for t, beat in rows])
        phase = (phase + 0.5 * whole) % whole - 0.5 * whole
        return phase * np.array([music.period(int(music.beat_at(t))) for t, _ in rows])

    def states(self, start: float, end: float) -> set[str]:
        return {state for time, _, _, state, *_ in self.rows if start <= time < end}

    def beats(self) -> list[int]:
        """The whole beats in order of occurrence."""
        found: list[int] = []
        for (_, before, *_), (_, after, *_) in zip(self.rows, self.rows[1:], strict=False):
            found += range(int(np.floor(before)) + 1, int(np.floor(after)) + 1)
        return found
