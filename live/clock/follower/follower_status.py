"""Read-only status of a follower: timeline, active source, confidence, jumps."""

import math

from live.clock.follower.clock_source import Source
from live.clock.follower.count_in import CountingIn
from live.clock.follower.external_source import DirectSource
from live.clock.follower.phase_correction import Jump, Run
from live.clock.follower.source_arbiter import Ruling
from live.clock.timeline import Timeline


class Seen:
    """Read-only properties of the follower."""

    _sources: dict[str, Source]
    _run: Run
    _ruling: Ruling
    _counting: CountingIn
    _now: float
    _locked: bool
    _share: float

    @property
    def timeline(self) -> Timeline:
        """The present timeline."""
        return self._run.timeline

    @property
    def tempo(self) -> float:
        """The music's tempo [bpm], without the timeline's temporary corrections."""
        return self._run.goal.tempo

    @property
    def confidence(self) -> float:
        """Confidence of the active source, 0 to 1; it fades in freewheel."""
        return self._share

    @property
    def source(self) -> str:
        """The active source: link | midi | mtc | audio | tap | internal."""
        return self._ruling.name

    @property
    def choice(self) -> str:
        """The operator's choice: auto, or a source's name."""
        return self._ruling.choice

    @property
    def held(self) -> bool:
        """Whether the tempo is held by hand."""
        return self._ruling.held

    @property
    def state(self) -> str:
        """internal | following (not yet sure) | locked | freewheel (no input) | held (by hand)."""
        if self._ruling.held:
            return "held"
        if self._ruling.free:
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
        return self._run.jumps

    @property
    def last_jump(self) -> Jump | None:
        """The last jump."""
        return self._run.last_jump

    @property
    def counting_in(self) -> int:
        """Beats still to be counted before the downbeat; 0: none."""
        return self._counting.left(self._run.beat(self._now)) if math.isfinite(self._now) else 0

    @property
    def source_measure(self) -> int:
        """The active source's own measure number, from 0; -1: unknown."""
        source = self._ruling.source
        return source.measure if isinstance(source, DirectSource) else -1
