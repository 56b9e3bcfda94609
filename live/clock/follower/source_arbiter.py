"""Ruling: which source is followed, when another takes over, and what is run after while none can be."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import Measures
from live.clock.follower.clock_source import Source
from live.clock.follower.external_source import DirectSource, HandSource
from live.clock.follower.phase_correction import Run, wholes_off
from live.clock.timeline import Grid

PRIORITY: Final = ("link", "midi", "mtc", "audio", "tap", "internal")
"""Who is followed first, unless the patch or the operator says otherwise."""

GRACE: Final = 2.0
"""After the loss of a source its tempo runs on alone for so long [s] before one of lower rank takes over."""

NEW_SONG_SILENCE: Final = 2.0
NEW_SONG_TEMPO: Final = 0.04
"""After so much silence [s] a tempo that differs by so much (natural logarithm) is another song's."""

ANOTHER_BEAT: Final = 0.6
"""A source whose beat is this far off [beats] is nearer to another of ours: it is counted anew, none is skipped."""


class Ruling:
    """Chooses among sources and keeps `run.goal` at what the one that rules says."""

    def __init__(
        self, sources: Mapping[str, Source], run: Run, measures: Measures, *,
        priority: Sequence[str] = PRIORITY, tempo_range: tuple[float, float] = (40.0, 240.0),
    ) -> None:  # fmt: skip
        """`priority`: names, first rank first, those left out are never followed; `tempo_range` [bpm]: sources that
        are outside are halved or doubled into it."""
        self._sources, self._run, self._measures = sources, run, measures
        self._priority, self._range = tuple(priority), tempo_range
        self.choice = "auto"
        self.name = "internal"
        """Who rules."""
        self.free = False
        """Whether who rules has nothing to say: the tempo runs on alone."""
        self.held = False
        """Whether the hand holds the tempo."""
        self._free_since = -math.inf
        self._tempo_lost = 0.0
        self.shift = 0
        """What is added to the source's numbers of beats to have the Timeline's."""

    @property
    def source(self) -> Source:
        """Who rules."""
        return self._sources[self.name]

    @property
    def exact(self) -> bool:
        """Whether a clock rules that no hand may contradict."""
        return isinstance(self.source, DirectSource) and not self.free

    def update(self, now: float, *, crossed: bool) -> None:
        """Notice loss and return, hand over where that is due (`crossed`: a measure line lies just behind)."""
        if self.held:
            return
        if not self.source.ready and not self.free:
            self.free, self._free_since, self._tempo_lost = True, now, self._run.goal.tempo
            self._run.freeze(now)
        wanted = self._wanted(now)
        if wanted == self.name:
            if self.free and self.source.ready:
                self.take(wanted, now)
        elif crossed or self.name == "internal":
            self.take(wanted, now)
        self._aim(now)

    def take(self, name: str, now: float) -> None:
        """`name` rules from now on; the beat goes on where it is and is run to the new one's."""
        run, before, was_free = self._run, self.name, self.free
        self.name, self.free = name, False
        source = self.source
        if isinstance(source, AudioSource) and before == "tap":
            source.agree_with(run.goal, now)
        if isinstance(source, DirectSource):
            source.lean(run.beat(now), now)
        self._fold()
        grid = source.grid()
        if grid is None:
            return
        self.shift = math.floor(run.beat(now) - grid.beat_at(now) + 0.5)
        if name != before:
            self._measures.hand_over()
        new_song = was_free and now - self._free_since >= NEW_SONG_SILENCE
        if new_song and abs(math.log(grid.tempo / self._tempo_lost)) > NEW_SONG_TEMPO:
            run.leap_soon("new song")
            self._measures.unpin()

    def _wanted(self, now: float) -> str:
        """Who should rule."""
        if self.choice != "auto":
            return self.choice if self._available(self.choice, now) else self.name
        if self.name == "tap" and self._rules(self.source, now):
            return self.name
        for name in self._priority:
            if name == self.name and (self.source.ready or name in ("tap", "internal")):
                return name
            if name in ("tap", "internal") or not self._available(name, now):
                continue
            lower = self.free and self._rank(name) > self._rank(self.name)
            if not lower or now - self._free_since >= GRACE:
                return name
        return self.name

    def _available(self, name: str, now: float) -> bool:
        source = self._sources[name]
        if isinstance(source, AudioSource):
            return source.ready and now >= source.rest_until
        return source.ready if name == self.name else source.state == "locked" or isinstance(source, HandSource)

    def _rank(self, name: str) -> int:
        return self._priority.index(name) if name in self._priority else len(self._priority)

    def _rules(self, source: Source, now: float) -> bool:
        return isinstance(source, HandSource) and now < source.rules_until

    def _fold(self) -> None:
        source = self.source
        if isinstance(source, AudioSource | DirectSource):
            raw = source.raw()
            if raw is not None:
                source.level.fold(raw.tempo, *self._range)

    def _aim(self, now: float) -> None:
        """Set the goal to what the source says; a jump of the source is taken at once."""
        run, source = self._run, self.source
        if self.free:
            return
        grid = source.grid()
        if grid is None:
            return
        if source.jumped:
            source.jumped = False
            run.leap_soon("start")
            self._measures.unpin()
        off = grid.beat_at(now) + self.shift - run.beat(now)
        if run.leaping:
            self.shift -= wholes_off(off)
        elif abs(off) > ANOTHER_BEAT:
            self.shift -= math.floor(off + 0.5)
        run.goal = Grid(grid.time, grid.period, grid.number + self.shift) if self.shift else grid
        lines = source.lines()
        if lines is not None:
            self._measures.follow(run, lines, self.shift, now)
