"""Source selection: the active source, hand-over between sources, and free running without one."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import BarAlignment
from live.clock.follower.clock_source import PRIORITY, Source
from live.clock.follower.external_source import ExternalSource, ManualSource
from live.clock.follower.phase_correction import SlewedTimeline, whole_beats_off
from live.clock.timeline import Grid

GRACE: Final = 2.0
"""After the loss of a source its tempo is held this long [s] before a source of lower priority takes over."""

NEW_SONG_SILENCE: Final = 2.0
NEW_SONG_TEMPO: Final = 0.04
"""After this much silence [s] a tempo that differs by this much (natural logarithm) is a new song's."""

RENUMBER_DISTANCE: Final = 0.6
"""A source whose beat is this far off [beats] is renumbered to our nearest beat; none is skipped."""


class SourceArbiter:
    """Selects a source and sets `run.goal` to its beats."""

    def __init__(
        self, sources: Mapping[str, Source], run: SlewedTimeline, measures: BarAlignment, *,
        priority: Sequence[str] = PRIORITY, tempo_range: tuple[float, float] = (40.0, 240.0),
    ) -> None:  # fmt: skip
        """`priority`: names, highest first; sources left out are never followed. `tempo_range` [bpm]: slower or faster
        sources
        are doubled or halved into it.
        """
        self._sources, self._run, self._measures = sources, run, measures
        self._priority, self._range = tuple(priority), tempo_range
        self.choice = "auto"
        self.name = "internal"
        """Name of the active source."""
        self.free_running = False
        """Whether the active source has no beats: the tempo is held."""
        self.held = False
        """Whether the tempo is held by hand."""
        self._free_since = -math.inf
        self._tempo_lost = 0.0
        self.beat_offset = 0
        """Offset from the source's beat numbers to the timeline's."""

    @property
    def source(self) -> Source:
        """The active source."""
        return self._sources[self.name]

    @property
    def exact(self) -> bool:
        """Whether the active source is a clock that manual input may not override."""
        return isinstance(self.source, ExternalSource) and not self.free_running

    def update(self, now: float, *, crossed: bool) -> None:
        """Detect loss and return, and change the source if due (`crossed`: a measure line was just crossed)."""
        if self.held:
            return
        if not self.source.ready and not self.free_running:
            self.free_running, self._free_since, self._tempo_lost = True, now, self._run.goal.tempo
            self._run.freeze(now)
        wanted = self._best_source(now)
        if wanted == self.name:
            if self.free_running and self.source.ready:
                self.activate(wanted, now)
        elif crossed or self.name == "internal":
            self.activate(wanted, now)
        self._update_goal(now)

    def activate(self, name: str, now: float) -> None:
        """Make `name` the active source; the beat continues and is slewed to the new one."""
        run, before, was_free = self._run, self.name, self.free_running
        self.name, self.free_running = name, False
        source = self.source
        if isinstance(source, AudioSource) and before == "tap":
            source.align_with(run.goal, now)
        if isinstance(source, ExternalSource):
            source.set_phase(run.beat(now), now)
        self._fold()
        grid = source.grid()
        if grid is None:
            return
        self.beat_offset = math.floor(run.beat(now) - grid.beat_at(now) + 0.5)
        if name != before:
            self._measures.handle_source_change()
        new_song = was_free and now - self._free_since >= NEW_SONG_SILENCE
        if new_song and abs(math.log(grid.tempo / self._tempo_lost)) > NEW_SONG_TEMPO:
            run.request_leap("new song")
            self._measures.unpin()

    def _best_source(self, now: float) -> str:
        """Return the source that should be active."""
        if self.choice != "auto":
            return self.choice if self._available(self.choice, now) else self.name
        if self.name == "tap" and self._has_priority(self.source, now):
            return self.name
        for name in self._priority:
            if name == self.name and (self.source.ready or name in ("tap", "internal")):
                return name
            if name in ("tap", "internal") or not self._available(name, now):
                continue
            lower = self.free_running and self._rank(name) > self._rank(self.name)
            if not lower or now - self._free_since >= GRACE:
                return name
        return self.name

    def _available(self, name: str, now: float) -> bool:
        source = self._sources[name]
        if isinstance(source, AudioSource):
            return source.ready and now >= source.manual_until
        return source.ready if name == self.name else source.state == "locked" or isinstance(source, ManualSource)

    def _rank(self, name: str) -> int:
        return self._priority.index(name) if name in self._priority else len(self._priority)

    def _has_priority(self, source: Source, now: float) -> bool:
        return isinstance(source, ManualSource) and now < source.priority_until

    def _fold(self) -> None:
        source = self.source
        if isinstance(source, AudioSource | ExternalSource):
            raw = source.raw()
            if raw is not None:
                source.level.fold(raw.tempo, *self._range)

    def _update_goal(self, now: float) -> None:
        """Set the goal to the source's grid; follow a jump of the source at once."""
        run, source = self._run, self.source
        if self.free_running:
            return
        grid = source.grid()
        if grid is None:
            return
        if source.jumped:
            source.jumped = False
            run.request_leap("start")
            self._measures.unpin()
        off = grid.beat_at(now) + self.beat_offset - run.beat(now)
        if run.leap_pending:
            self.beat_offset -= whole_beats_off(off)
        elif abs(off) > RENUMBER_DISTANCE:
            self.beat_offset -= math.floor(off + 0.5)
        run.goal = Grid(grid.time, grid.period, grid.number + self.beat_offset) if self.beat_offset else grid
        lines = source.lines()
        if lines is not None:
            self._measures.follow(run, lines, self.beat_offset, now)
