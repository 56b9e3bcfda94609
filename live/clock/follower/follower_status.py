"""Seen: what a follower shows of itself: the Timeline, who rules, how sure that is, what jumped."""

import math

from live.clock.follower.clock_source import Source
from live.clock.follower.count_in import CountingIn
from live.clock.follower.external_source import DirectSource
from live.clock.follower.phase_correction import Jump, Run
from live.clock.follower.source_arbiter import Ruling
from live.clock.timeline import Timeline


class Seen:
    """The part of the follower that is read."""

    _sources: dict[str, Source]
    _run: Run
    _ruling: Ruling
    _counting: CountingIn
    _now: float
    _locked: bool
    _share: float

    @property
    def timeline(self) -> Timeline:
        """The timeline in force."""
        return self._run.timeline

    @property
    def tempo(self) -> float:
        """The music's tempo [bpm], without the passing corrections that the timeline's carries."""
        return self._run.goal.tempo

    @property
    def confidence(self) -> float:
        """How sure the source in force is, 0 to 1; it fades in freewheel."""
        return self._share

    @property
    def source(self) -> str:
        """Who rules: link | midi | mtc | audio | tap | internal."""
        return self._ruling.name

    @property
    def choice(self) -> str:
        """What the operator chose: auto, or a source's name."""
        return self._ruling.choice

    @property
    def held(self) -> bool:
        """Whether the hand holds the tempo."""
        return self._ruling.held

    @property
    def state(self) -> str:
        """internal | following (heard, not yet sure) | locked | freewheel (nothing heard) | held (by hand)."""
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
        """How often the beat or the measure lines did not simply go on, since the start."""
        return self._run.jumps

    @property
    def last_jump(self) -> Jump | None:
        """The last of them."""
        return self._run.last_jump

    @property
    def counting_in(self) -> int:
        """Beats that are still counted before the one; 0: none."""
        return self._counting.left(self._run.beat(self._now)) if math.isfinite(self._now) else 0

    @property
    def source_measure(self) -> int:
        """The number of the measure as the source in force counts, from 0; -1: it counts none."""
        source = self._ruling.source
        return source.measure if isinstance(source, DirectSource) else -1
