"""Measures: when the Timeline's measure lines and metre follow a source, and when the hand's word stands."""

import math
from typing import Final

from live.clock.follower.clock_source import Lines
from live.clock.follower.phase_correction import Run

VOTES: Final = 1.0
"""A source's measure line is taken over when it was the same for so many measures running ..."""

VOTES_AGAINST_HAND: Final = 4.0
"""... or so many, after the hand had set it and the source had agreed."""

VOTES_METRE: Final = 2.0
"""So many measures of another metre, where metres are followed."""

METRE_MIN: Final = 2
METRE_MAX: Final = 12


class Measures:
    """Watches the lines of the source that rules."""

    def __init__(self, *, follow_metre: bool = False) -> None:
        """`follow_metre`: whether a source may change how many beats a measure has."""
        self.follow_metre = follow_metre
        self.coming: int | None = None
        """The beats of a measure from the next line on; None: as now."""
        self._pinned = False
        self._agreed = False
        self._fresh = True

    def pin(self) -> None:
        """The hand has set the line: a source that says otherwise is not believed."""
        self._pinned, self._agreed = True, False

    def unpin(self) -> None:
        """Something new begins: the source's next word on the measure is taken."""
        self._pinned, self._fresh = False, True

    def hand_over(self) -> None:
        """Another source rules: its line is taken as soon as it names one, unless the hand has set it."""
        self._fresh = True

    def set_metre(self, beats: int) -> None:
        """Measures of so many beats from the next line on, whatever a source says."""
        self.coming, self.follow_metre = beats, False

    def cross(self, run: Run, now: float) -> None:
        """A measure line lies just behind: a new metre begins with it."""
        if self.coming is not None:
            timeline = run.timeline
            line = timeline.beat_at(now) - timeline.phase_at(now)
            line = timeline.measure_origin + timeline.beats_per_measure * round(
                (line - timeline.measure_origin) / timeline.beats_per_measure
            )
            run.line(line, now, "hand", beats_per_measure=self.coming)
            self.coming = None

    def follow(self, run: Run, lines: Lines, shift: int, now: float) -> None:
        """Take over the source's measure lines if they are other than ours and said often enough."""
        size, beat, spacing = run.timeline.beats_per_measure, lines.beat + shift, round(lines.spacing)
        common = spacing if size % spacing == 0 else size if spacing % size == 0 else 0
        if not common:
            if self.follow_metre and lines.votes >= VOTES_METRE * spacing and METRE_MIN <= spacing <= METRE_MAX:
                run.line(beat, now, "lines", beats_per_measure=spacing)
            return
        off = (beat - run.timeline.measure_origin) % common
        if off == 0.0:
            self._agreed, self._fresh = True, False
            self._pinned = self._pinned and math.isfinite(lines.votes)
            return
        if self._pinned:
            needed = VOTES_AGAINST_HAND * spacing if self._agreed else math.inf
            enough = lines.votes >= needed and math.isfinite(lines.votes)
        else:
            enough = lines.votes >= (1.0 if self._fresh else VOTES * spacing)
        if enough:
            off = off if off <= common / 2 else off - common
            run.line(run.timeline.measure_origin + off, now, "lines")
            self._pinned, self._fresh = False, False
