"""DirectSource: MIDI clock, Ableton Link, time code: they come filtered, and the newest word is the truth.

HandSource: a grid that a person made: the internal clock's tempo, or taps.
"""

import math
from typing import Final

from live.clock.follower.clock_source import HeardSource, Lines, Said, State
from live.clock.timeline import Grid

SILENCE: Final = 0.35
"""A source that says nothing for so much [s] longer than a beat is gone, should nobody have told."""

AGREES_BEATS: Final = 0.06
AGREES_TEMPO: Final = 0.03
"""A statement within this of the one before confirms it (beats; relative)."""

SURE: Final = 0.99
"""A statement of this confidence needs no second one."""


class DirectSource(HeardSource):
    """Keeps the last statement. Locked from the second that agrees with the one before, or the first that is sure."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._grid: Grid | None = None
        self._line: float | None = None
        self._beats = 0
        self._measure = -1
        self.anchored = True
        """False while its beats are even but their place is arbitrary: then only their drift is followed."""
        self._fresh = True

    def raw(self) -> Grid | None:
        """Its own beats."""
        return self._grid

    @property
    def measure(self) -> int:
        """The source's own number of the measure of its last statement, from 0; -1: unknown."""
        return self._measure

    def heard(self, said: Said, now: float) -> None:
        """Take over what is said."""
        if self.too_late(said) and not said.jump:
            return
        self.silent_since = None
        self.heard_at = max(self.heard_at, now)
        before = self._grid
        grid = self._numbered(said, before)
        agrees = before is not None and not said.jump and self._agrees(before, grid)
        self.jumped = self.jumped or said.jump
        if said.anchored and not self.anchored:
            self.level.straighten()
        elif self.anchored and not said.anchored and before is not None:
            # the beats go on where they were, whatever the count says
            self.level.shift((grid.beat_at(now) - before.beat_at(now)) * self.level.factor)
        self.anchored = said.anchored
        self._grid, self._measure = grid, said.measure
        self.confidence = min(max(said.confidence, 0.0), 1.0)
        known = said.anchored and said.beat >= 0 and said.beats_per_measure > 0
        self._line = float(grid.number - said.beat) if known else None
        self._beats = said.beats_per_measure
        if self.confidence >= SURE or agrees or said.jump:
            self.state = "locked"
        elif self.state != "locked":
            self.state = "following" if not self._fresh else "listening"
        self._fresh = False

    def lean(self, beat: float, now: float) -> None:
        """Where the place of the beats is arbitrary: the danced beat at `now` [s] is `beat` from here on."""
        raw = self.raw()
        if raw is not None and not self.anchored:
            at = self.level.danced(raw.beat_at(now - self.offset))
            self.level.shift(at - beat)

    def own_lines(self) -> Lines | None:
        """Its measure lines; they are certain where it knows them."""
        if self._line is None or self._beats < 1:
            return None
        return Lines(self._line, float(self._beats), math.inf)

    def silent(self, now: float) -> None:
        """It has stopped."""
        super().silent(now)
        self._fresh = True

    def watch(self, now: float) -> None:
        """Notice that nothing comes any more."""
        if self.ready and self._grid is not None and now - self.heard_at > self._grid.period + SILENCE:
            self.lost(now)

    def _numbered(self, said: Said, before: Grid | None) -> Grid:
        if said.anchored and said.beat >= 0 and said.measure >= 0 and said.beats_per_measure > 0:
            return Grid(said.time, said.period, said.measure * said.beats_per_measure + said.beat)
        if before is None:
            return Grid(said.time, said.period, max(said.beat, 0))
        return Grid(said.time, said.period, math.floor(before.beat_at(said.time) + 0.5))

    def _agrees(self, before: Grid, grid: Grid) -> bool:
        near = abs(before.residual(grid.time)) < AGREES_BEATS
        return near and abs(math.log(grid.period / before.period)) < AGREES_TEMPO


RULE: Final = 8.0
"""Seconds after the last tap, or tempo set by hand, in which the ear is not asked."""


class HandSource:
    """Keeps its grid until it is given another one."""

    def __init__(self, name: str, grid: Grid | None = None) -> None:
        self.name = name
        self.state: State = "absent" if grid is None else "locked"
        self.confidence = 0.0 if grid is None else 1.0
        self.jumped = False
        self._grid = grid
        self.rules_until = -math.inf
        """Until then the hand's word stands over what is heard [s]."""

    @property
    def ready(self) -> bool:
        """Whether it has a grid."""
        return self._grid is not None

    def grid(self) -> Grid | None:
        """Its beats."""
        return self._grid

    def lines(self) -> Lines | None:
        """A hand says where the measures begin by other means."""
        return None

    def watch(self, now: float) -> None:
        """A hand does not go away; when its rule is over it is no longer sure."""
        if self.name == "tap" and self.ready:
            self.state = "locked" if now < self.rules_until else "following"

    def take(self, grid: Grid, now: float) -> None:
        """These are the beats, and for the next seconds nothing heard contradicts them."""
        self._grid, self.confidence = grid, 1.0
        self.state = "locked"
        self.rules_until = now + RULE

    def keep(self, grid: Grid) -> None:
        """The same beats a little elsewhere; how long they rule stays as it was."""
        self._grid = grid
