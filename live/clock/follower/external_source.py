"""Clock sources without a tracker: MIDI clock, Ableton Link and others, and grids set by hand (tempo or taps)."""

import math
from typing import Final

from live.clock.follower.clock_source import BeatObservation, Lines, ObservedSource, State
from live.clock.timeline import Grid

SILENCE: Final = 0.35
"""A source without observations for this long [s] beyond a beat is lost, if nothing reported that."""

AGREES_BEATS: Final = 0.06
AGREES_TEMPO: Final = 0.03
"""An observation this near to the one before confirms it (beats; relative)."""

SURE: Final = 0.99
"""An observation of this confidence needs no confirmation."""


class ExternalSource(ObservedSource):
    """Keeps the last observation. Locked from the second one that agrees with the first, or from one that is sure."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._grid: Grid | None = None
        self._line: float | None = None
        self._beats = 0
        self._measure = -1
        self.anchored = True
        """False while the phase of its beats is arbitrary: then only their drift is followed."""
        self._fresh = True

    def raw(self) -> Grid | None:
        """Return its own beats."""
        return self._grid

    @property
    def measure(self) -> int:
        """The source's own measure number of its last observation, from 0; -1: unknown."""
        return self._measure

    def observe(self, said: BeatObservation, now: float) -> None:
        """Adopt an observation."""
        if self.precedes_silence(said) and not said.jump:
            return
        self.silent_since = None
        self.observed_at = max(self.observed_at, now)
        before = self._grid
        grid = self._numbered(said, before)
        agrees = before is not None and not said.jump and self._agrees(before, grid)
        self.jumped = self.jumped or said.jump
        if said.anchored and not self.anchored:
            self.level.align_to_beats()
        elif self.anchored and not said.anchored and before is not None:
            # keep the phase of the beats, whatever the count says
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

    def set_phase(self, beat: float, now: float) -> None:
        """If the phase is arbitrary, set the danced beat at `now` [s] to `beat`."""
        raw = self.raw()
        if raw is not None and not self.anchored:
            at = self.level.map_beat(raw.beat_at(now - self.offset))
            self.level.shift(at - beat)

    def own_lines(self) -> Lines | None:
        """Return its measure lines, which are certain if known."""
        if self._line is None or self._beats < 1:
            return None
        return Lines(self._line, float(self._beats), math.inf)

    def silent(self, now: float) -> None:
        """Handle a stop."""
        super().silent(now)
        self._fresh = True

    def check_timeout(self, now: float) -> None:
        """Detect missing observations."""
        if self.ready and self._grid is not None and now - self.observed_at > self._grid.period + SILENCE:
            self.lost(now)

    def _numbered(self, said: BeatObservation, before: Grid | None) -> Grid:
        if said.anchored and said.beat >= 0 and said.measure >= 0 and said.beats_per_measure > 0:
            return Grid(said.time, said.period, said.measure * said.beats_per_measure + said.beat)
        if before is None:
            return Grid(said.time, said.period, max(said.beat, 0))
        return Grid(said.time, said.period, math.floor(before.beat_at(said.time) + 0.5))

    def _agrees(self, before: Grid, grid: Grid) -> bool:
        near = abs(before.residual(grid.time)) < AGREES_BEATS
        return near and abs(math.log(grid.period / before.period)) < AGREES_TEMPO


PRIORITY_TIME: Final = 8.0
"""Seconds after the last tap, or manual tempo, in which audio is ignored."""


class ManualSource:
    """Keeps its grid until it gets another one."""

    def __init__(self, name: str, grid: Grid | None = None) -> None:
        self.name = name
        self.state: State = "absent" if grid is None else "locked"
        self.confidence = 0.0 if grid is None else 1.0
        self.jumped = False
        self._grid = grid
        self.priority_until = -math.inf
        """Until this time it has priority over audio [s]."""

    @property
    def ready(self) -> bool:
        """Whether it has a grid."""
        return self._grid is not None

    def grid(self) -> Grid | None:
        """Return its beats."""
        return self._grid

    def lines(self) -> Lines | None:
        """Return None: measure lines are set by hand through other calls."""
        return None

    def check_timeout(self, now: float) -> None:
        """Update the state: never lost, but no longer locked when its priority ends."""
        if self.name == "tap" and self.ready:
            self.state = "locked" if now < self.priority_until else "following"

    def set_grid(self, grid: Grid, now: float) -> None:
        """Set the beats, with priority over audio for the next seconds."""
        self._grid, self.confidence = grid, 1.0
        self.state = "locked"
        self.priority_until = now + PRIORITY_TIME

    def replace_grid(self, grid: Grid) -> None:
        """Replace the grid by a slightly corrected one; its priority does not change."""
        self._grid = grid
