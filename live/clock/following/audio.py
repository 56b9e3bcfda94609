"""AudioSource: what is heard in the room, through either kind of tracker."""

import math
from typing import Final

from live.clock.following.consensus_ear import ConsensusEar
from live.clock.following.pointer_ear import PointerEar
from live.clock.following.said import Said
from live.clock.following.source import HeardSource, Lines
from live.clock.grid import Grid

NOTHING_HEARD: Final = 3.0
"""Seconds (at least three beats) without a statement after which the tempo runs on alone."""

SAME_TEMPO: Final = 0.12
"""Tempi within this (natural logarithm) are at the same level."""

OFF_BEAT: Final = 0.17
"""Beats within this of half a beat of the tracker's away are the off-beat."""


class AudioSource(HeardSource):
    """A tracker that names beats of the measure is believed; one that only hears beats is asked for a consensus."""

    def __init__(self, grid: Grid, known_tempo: float | None = None) -> None:
        """`grid` is what is run while nothing is heard; `known_tempo` [bpm]: what the music's score says."""
        super().__init__("audio")
        self.consensus = ConsensusEar(grid, known_tempo)
        self.pointer = PointerEar()
        self._pointing = False
        self._restarts = 0
        self.rest_until = -math.inf
        """Until then the hand rules, and nothing is decided [s]."""

    def raw(self) -> Grid | None:
        """The tracker's beats."""
        return self.pointer.grid if self._pointing else self.consensus.grid

    def own_lines(self) -> Lines | None:
        """The tracker's measures."""
        return self.pointer.lines() if self._pointing else None

    def heard(self, said: Said, now: float) -> None:
        """One estimate of the tracker."""
        if self.silent_since is not None:
            if self.too_late(said):
                return
            self.found(now)
        self.heard_at = max(self.heard_at, now)
        if said.beat >= 0 or said.beats_per_measure > 0:
            self._pointing = True
        if self._pointing:
            self._point(said)
        else:
            self.consensus.heard(said, now, decide=now >= self.rest_until)
            self._judge(self.consensus.believed, self.consensus.sure, self.consensus.share)

    def _point(self, said: Said) -> None:
        before = self.grid()
        self.pointer.heard(said)
        raw = self.raw()
        if self.pointer.restarts != self._restarts and before is not None and raw is not None:
            self._restarts = self.pointer.restarts
            obeyed = abs(math.log(raw.tempo / before.tempo)) < SAME_TEMPO
            if self.level.factor == 1.0 or obeyed:
                self.level.reset(raw.beat_at(said.time), before.beat_at(said.time))
        self._judge(self.pointer.believed, self.pointer.sure, self.pointer.share)

    def _judge(self, believed: bool, sure: bool, share: float) -> None:
        """The state from what the ear says; a lock once made holds until most of what is said contradicts."""
        self.confidence = min(max(share, 0.0), 1.0)
        if not believed:
            self.state = "listening"
        elif sure or (self.state == "locked" and share >= 0.3):
            self.state = "locked"
        else:
            self.state = "following"

    def silent(self, now: float) -> None:
        """Nothing is played any more."""
        super().silent(now)
        self._forget()

    def found(self, now: float) -> None:
        """There is something to hear again."""
        super().found(now)
        self._forget()

    def _forget(self) -> None:
        self.consensus.clear()
        self.pointer.clear()
        self.state = "absent" if self.state == "absent" else "listening"

    def watch(self, now: float) -> None:
        """Notice that nothing comes any more."""
        raw = self.raw()
        if self.ready and raw is not None and now - self.heard_at > max(NOTHING_HEARD, 3.0 * raw.period):
            self.state = "listening"
            self.pointer.clear()

    def take(self, grid: Grid, until: float) -> None:
        """The hand says what the beat is, and rules until then [s]."""
        self.consensus.take(grid)
        self.rest_until = until

    def agree_with(self, hand: Grid, now: float) -> None:
        """Dance the tracker's beats at the hand's level, and on the hand's side of the beat."""
        raw = self.raw()
        if not self._pointing or raw is None:
            return
        self.level.reset(raw.beat_at(now), hand.beat_at(now))
        ratio = math.log2(hand.tempo / raw.tempo)
        if round(ratio) in (-1, 1) and abs(ratio - round(ratio)) * math.log(2.0) < SAME_TEMPO:
            danced = self.level.danced(math.floor(raw.beat_at(now)))
            self.level.scale(2.0 ** round(ratio), danced)
        grid = self.grid()
        if grid is None:
            return
        off = grid.beat_at(now) - hand.beat_at(now)
        unit = 0.5 * min(self.level.factor, 1.0)  # half a beat of the tracker's
        side = math.floor(off / unit + 0.5) * unit
        if side % 1.0 and abs(off - side) < OFF_BEAT:
            self.level.shift(side % 1.0)
