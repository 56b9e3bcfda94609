"""TimelineFollower: beat estimates, taps and losses in, a Timeline out that never jumps and never stands still."""

import math
from dataclasses import replace
from typing import Final

from live.clock.consensus import Consensus, Heard, Preference
from live.clock.grid import Grid
from live.clock.tap import TapTempo
from live.clock.timeline import TEMPO_MAX_BPM, TEMPO_MIN_BPM, Timeline

CORRECTION_TIME: Final = 0.8
"""Time constant with which a phase error is run in [s]."""

SLEW_LOCKED: Final = 0.12
SLEW_UNLOCKED: Final = 0.20
"""How much faster or slower than the music the beats may run to catch up with it."""

TAPS_RULE: Final = 8.0
"""Seconds after the last tap, or tempo set by hand, in which the ear is not asked."""

NOTHING_HEARD: Final = 3.0
"""Seconds (at least three beats) without an estimate after which the held tempo runs on alone."""

CHALLENGE: Final = 1.3
"""A grid that contradicts the present one needs this much more support, from ..."""

CHALLENGE_SPAN: Final = 2.0
"""... at least three estimates over at least these seconds: one decision of a tracker may sound like several."""

ONE_WITHIN: Final = 30.0
"""How long after the known first downbeat [s] a first lock may still count measures back to it."""

PLAUSIBLE: Final = 60.0
"""An event's time lies at most this far from now [s]; ..."""

START_PLAUSIBLE: Final = 1e7
"""... before the first tick it is at most this [s]."""

HAND_OCTAVES: Final = 0.15
KNOWN_OCTAVES: Final = 0.12
"""How narrowly a tempo that somebody tapped, typed or wrote down rules the choice of octave."""


class TimelineFollower:
    """Runs a Timeline after what is heard and tapped; pure: all times [s] are given, none is read.

    The grid is what the estimates say together (Consensus); the Timeline runs after it by going up to 12 % (20 % while
    not locked) faster or slower, so its beat is continuous and strictly increasing whatever comes in. Estimates,
    taps and times that are not finite, or absurd, are counted in `rejected` and change nothing.
    """

    def __init__(
        self,
        *,
        tempo: float = 120.0,
        beats_per_measure: int = 4,
        one_at: float | None = None,
        known_tempo: float | None = None,
    ) -> None:
        """Start on the internal clock at `tempo` [bpm], with a downbeat at `one_at` [s] (0 if not given).

        `known_tempo` [bpm] is what the music's score says: it is run from the start and settles the octave.
        """
        begin = 0.0 if one_at is None else one_at
        self._timeline = Timeline(
            tempo=tempo if known_tempo is None else known_tempo, time_origin=begin, beats_per_measure=beats_per_measure
        )
        self._grid = Grid(begin, 60.0 / self._timeline.tempo)
        self._prefer = Preference() if known_tempo is None else Preference(known_tempo, KNOWN_OCTAVES)
        self._one_at = one_at
        self._consensus = Consensus()
        self._taps = TapTempo()
        self._now = -math.inf
        self._hand_until = -math.inf
        self._heard_at = -math.inf
        self._silent_since: float | None = None
        self._share = 0.0
        self.state = "internal"
        """internal | following (heard, not yet sure) | locked | freewheel (nothing heard) | held (by hand)."""
        self.source = "internal"
        """What the beats come from: internal | audio | tap."""
        self.rejected = 0
        """Inputs refused because they cannot be true, since the start."""

    @property
    def timeline(self) -> Timeline:
        """The timeline in force."""
        return self._timeline

    @property
    def tempo(self) -> float:
        """The music's tempo [bpm], without the passing corrections that the timeline's carries."""
        return self._grid.tempo

    @property
    def confidence(self) -> float:
        """The share of what was lately heard that agrees with the beats, 0 to 1; it fades in freewheel."""
        return self._share

    def heard(self, beat_time: float, period: float, confidence: float, now: float) -> None:
        """A tracker's estimate, received at `now`: a beat at `beat_time`, `period` [s] to the next."""
        if not (
            all(map(math.isfinite, (beat_time, period, confidence, now)))
            and 0.15 <= period <= 4.0
            and -5.0 <= beat_time - now <= 2.0
        ):
            self.rejected += 1
            return
        if self._silent_since is not None:
            if beat_time <= self._silent_since:  # on its way when the silence was noticed
                return
            self.found(now)
        self._heard_at = max(self._heard_at, now)
        self._consensus.add(Heard(beat_time, period, 0.3 + 0.7 * min(max(confidence, 0.0), 1.0)), now)
        if now < self._hand_until:
            return
        self._decide(now)

    def tap(self, time: float) -> None:
        """A tap; from the third on tempo and phase are the taps', and which half beat is the beat stays theirs."""
        if not self._plausible(time):
            return
        grid = self._taps.tap(time)
        if grid is None or not TEMPO_MIN_BPM <= grid.tempo <= TEMPO_MAX_BPM:
            return
        self._take_by_hand(grid.numbered_like(self._timeline.beat_at(time), time), time)
        self._consensus.half_beats = True
        self.source = "tap"
        self.state = "held"

    def one(self, time: float) -> None:
        """The beat nearest to `time` is the first of a measure.

        Said before the beats are sure, it is counted back to when they are.
        """
        if not self._plausible(time):
            return
        self._timeline = self._timeline.with_one_at(time)
        self._one_at = time if self.state in ("internal", "following") else None

    def set_tempo(self, bpm: float, time: float) -> None:
        """Run at `bpm` from `time` on, with no step in the beat."""
        if not self._plausible(time):
            return
        if not TEMPO_MIN_BPM <= bpm <= TEMPO_MAX_BPM:
            self.rejected += 1
            return
        now = self._now if math.isfinite(self._now) else time
        beat = self._timeline.beat_at(now)
        number = math.floor(beat)
        self._take_by_hand(Grid(now - (beat - number) * 60.0 / bpm, 60.0 / bpm, number), now)
        self._timeline = self._timeline.with_tempo(bpm, now)
        self.state = "internal" if self.source == "internal" else "held"

    def silent(self, time: float) -> None:
        """Nothing is played any more: the tempo is kept, the beats run on."""
        if not self._plausible(time):
            return
        self._silent_since = time if self._silent_since is None else self._silent_since
        self._consensus.clear()
        if self.source == "audio":
            self.state = "freewheel"

    def lost(self, time: float) -> None:
        """The input went away: as in silence."""
        self.silent(time)

    def found(self, time: float) -> None:
        """There is something to hear again: what comes now is judged afresh, the beats run on until it is sure."""
        if not self._plausible(time):
            return
        self._silent_since = None
        self._consensus.clear()

    def advance(self, now: float) -> Timeline:
        """The timeline from `now` [s] on; called each tick. A time before the last one changes nothing."""
        if not math.isfinite(now) or now < self._now:
            return self._timeline
        elapsed, self._now = now - self._now, now
        self._watch(now, elapsed if math.isfinite(elapsed) else 0.0)
        self._timeline = self._timeline.with_tempo(self._running_tempo(now), now)
        return self._timeline

    def _plausible(self, time: float) -> bool:
        """Whether a time may be that of an event of now; counts it as rejected if not."""
        good = abs(time - self._now) <= PLAUSIBLE if math.isfinite(self._now) else abs(time) <= START_PLAUSIBLE
        self.rejected += not good
        return good

    def _take_by_hand(self, grid: Grid, now: float) -> None:
        self._grid = grid
        self._prefer = Preference(grid.tempo, HAND_OCTAVES)
        self._consensus.clear()
        self._hand_until = now + TAPS_RULE
        self._share = 1.0

    def _decide(self, now: float) -> None:
        """Keep the grid and refine it, or take another that several estimates agree on."""
        support, share = self._consensus.support(self._grid, now)
        support *= self._prefer.of(self._grid.period)
        best, best_support = self._grid, support
        for grid in self._consensus.candidates():
            value = self._consensus.support(grid, now)[0] * self._prefer.of(grid.period)
            if value > best_support:
                best, best_support = grid, value
        first = self.source == "internal"
        if not self._same(best) and self._convinces(best, best_support, support, first):
            self._grid = best.numbered_like(self._timeline.beat_at(now), now)
            self._consensus.half_beats = self._consensus.half_beats and abs(math.log(self.tempo / best.tempo)) < 0.15
            self.source, self.state = "audio", "following"
        elif len(self._consensus.witnesses(self._grid)) >= (3 if first else 2):
            self._refine(now)
            self.state = self.state if self.source == "audio" and self.state == "locked" else "following"
            self.source = "audio"
        self._share = self._consensus.support(self._grid, now)[1] if self.source == "audio" else share

    def _same(self, grid: Grid) -> bool:
        tempo = abs(math.log(grid.period / self._grid.period)) < 0.04
        return tempo and abs(self._grid.residual(grid.time)) < 0.15

    def _convinces(self, grid: Grid, value: float, present: float, first: bool) -> bool:
        witnesses = self._consensus.witnesses(grid)
        if len(witnesses) < 3 or value < CHALLENGE * present:
            return False
        return first or witnesses[-1].time - witnesses[0].time >= CHALLENGE_SPAN

    def _refine(self, now: float) -> None:
        fitted = self._consensus.fitted(self._grid, now)
        number = math.floor(fitted.beat_at(now))
        anchored = Grid(fitted.time + (number - fitted.number) * fitted.period, fitted.period, number)
        # The numbers stay those that are being run after, unless another whole beat has become much nearer.
        if abs(anchored.beat_at(now) - self._timeline.beat_at(now)) > 0.6:
            anchored = anchored.numbered_like(self._timeline.beat_at(now), now)
        self._grid = anchored

    def _watch(self, now: float, elapsed: float) -> None:
        """Follow the state: nothing heard for long, the hand's rule over, phase reached or lost."""
        if self.state == "held" and now >= self._hand_until and self.source == "audio":
            self.state = "freewheel"
        if self.state in ("following", "locked") and now - self._heard_at > max(NOTHING_HEARD, 3.0 * self._grid.period):
            self.state = "freewheel"
        if self.state == "freewheel":
            self._share *= math.exp(-elapsed / 8.0)
            return
        error = abs(self._grid.beat_at(now) - self._timeline.beat_at(now))
        if self.state == "following" and self._share >= 0.5 and error < 0.1 and len(self._consensus) >= 4:
            self.state = "locked"
            self._count_from_one(now)
        elif self.state == "locked" and (self._share < 0.3 or error > 0.25):
            self.state = "following"

    def _count_from_one(self, now: float) -> None:
        """At the first lock: the measures begin where the music's known first downbeat was."""
        if self._one_at is None:
            return
        if 0.0 <= now - self._one_at <= ONE_WITHIN:
            grid, timeline = self._grid, self._timeline
            straight = replace(timeline, tempo=grid.tempo, beat_origin=float(grid.number), time_origin=grid.time)
            origin = straight.with_one_at(self._one_at).measure_origin
            self._timeline = replace(timeline, measure_origin=origin)
        self._one_at = None

    def _running_tempo(self, now: float) -> float:
        """The grid's tempo, faster or slower by what the phase error asks for; in freewheel the tempo alone."""
        if self.state in ("freewheel", "internal"):
            return min(max(self._grid.tempo, TEMPO_MIN_BPM), TEMPO_MAX_BPM)
        error = self._grid.beat_at(now) - self._timeline.beat_at(now)
        limit = SLEW_LOCKED if self.state == "locked" else SLEW_UNLOCKED
        correction = min(max(error / (CORRECTION_TIME * self._grid.tempo / 60.0), -limit), limit)
        return min(max(self._grid.tempo * (1.0 + correction), TEMPO_MIN_BPM), TEMPO_MAX_BPM)
