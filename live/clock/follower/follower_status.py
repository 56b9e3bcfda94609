"""Read-only status of a follower: timeline, active source, confidence, jumps."""

import math

from live.clock.follower.bar_alignment import BarAlignment
from live.clock.follower.clock_source import Source
from live.clock.follower.count_in import CountIn
from live.clock.follower.external_source import ExternalSource
from live.clock.follower.phase_correction import Jump, SlewedTimeline
from live.clock.follower.source_arbiter import SourceArbiter
from live.clock.timeline import Timeline


class FollowerStatus:
    """Read-only properties of the follower."""

    _sources: dict[str, Source]
    _slewed: SlewedTimeline
    _arbiter: SourceArbiter
    _alignment: BarAlignment
    _counting: CountIn
    _now: float
    _locked: bool
    _confidence: float

    @property
    def timeline(self) -> Timeline:
        """The present timeline."""
        return self._slewed.timeline

    @property
    def tempo(self) -> float:
        """The music's tempo [bpm], without the timeline's temporary corrections."""
        return self._slewed.goal.tempo

    @property
    def confidence(self) -> float:
        """Confidence of the active source, 0 to 1; it fades in freewheel."""
        return self._confidence

    @property
    def source(self) -> str:
        """The name of the active source."""
        return self._arbiter.name

    @property
    def choice(self) -> str:
        """The operator's choice: auto, or a source's name."""
        return self._arbiter.choice

    @property
    def held(self) -> bool:
        """Whether the tempo is held by hand."""
        return self._arbiter.held

    @property
    def state(self) -> str:
        """internal | following (not yet sure) | locked | freewheel (no input) | held (by hand)."""
        if self._arbiter.held:
            return "held"
        if self._arbiter.free_running:
            return "freewheel"
        if self.source in ("internal", "tap"):
            return "internal" if self.source == "internal" else "held"
        return "locked" if self._locked else "following"

    @property
    def states(self) -> dict[str, str]:
        """The state of every source: absent | listening | following | locked."""
        return {name: source.state for name, source in self._sources.items()}

    @property
    def jumps(self) -> int:
        """Number of jumps of the beat or the measure lines since the start."""
        return self._slewed.jumps

    @property
    def last_jump(self) -> Jump | None:
        """The last jump."""
        return self._slewed.last_jump

    @property
    def runner_up(self) -> tuple[float, float]:
        """The most likely other measure line: by how many beats later, and its probability; 0 if there is none."""
        return self._alignment.runner_up

    @property
    def asks(self) -> bool:
        """Whether the music has spoken against a measure line set by hand for many measures; never while held."""
        if self.held or not math.isfinite(self._now):
            return False
        return self._alignment.asks(self._slewed.beat(self._now), self.timeline.beats_per_measure)

    @property
    def counting_in(self) -> int:
        """Beats still to be counted before the downbeat; 0: none."""
        return self._counting.remaining(self._slewed.beat(self._now)) if math.isfinite(self._now) else 0

    @property
    def source_measure(self) -> int:
        """The active source's own measure number, from 0; -1: unknown."""
        source = self._arbiter.source
        return source.measure if isinstance(source, ExternalSource) else -1
