"""Alignment of the timeline's measure lines and metre with those of a source, with priority for manual settings."""

import math
from typing import Final

from live.clock.follower.clock_source import Lines
from live.clock.follower.phase_correction import SlewedTimeline
from live.clock.timeline import METRE_MAX, METRE_MIN

VOTES: Final = 1.0
"""A source's measure line is adopted after this many equal measures in a row ..."""

VOTES_AGAINST_MANUAL: Final = 4.0
"""... or this many, if it was set by hand and the source had agreed."""

VOTES_METRE: Final = 2.0
"""Number of measures of another metre after which it is adopted, if metres are followed."""


class BarAlignment:
    """Follows the measure lines of the active source."""

    def __init__(self, *, follow_metre: bool = False) -> None:
        """`follow_metre`: whether a source may change the number of beats in a measure."""
        self.follow_metre = follow_metre
        self.pending_metre: int | None = None
        """Beats in a measure from the next line on; None: unchanged."""
        self._pinned = False
        self._agreed = False
        self._fresh = True

    def pin(self) -> None:
        """Keep the line as set by hand, against the source."""
        self._pinned, self._agreed = True, False

    def unpin(self) -> None:
        """Adopt the source's next measure line."""
        self._pinned, self._fresh = False, True

    def handle_source_change(self) -> None:
        """Adopt the line of a new source as soon as it reports one, unless the line was set by hand."""
        self._fresh = True

    def set_metre(self, beats: int) -> None:
        """Set the beats in a measure from the next line on, whatever a source reports."""
        self.pending_metre, self.follow_metre = beats, False

    def apply_pending_metre(self, run: SlewedTimeline, now: float) -> None:
        """Apply a new metre at a measure line that was just crossed."""
        if self.pending_metre is not None:
            timeline = run.timeline
            line = timeline.beat_at(now) - timeline.phase_at(now)
            line = timeline.measure_origin + timeline.beats_per_measure * round(
                (line - timeline.measure_origin) / timeline.beats_per_measure
            )
            run.set_measure_line(line, now, "hand", beats_per_measure=self.pending_metre)
            self.pending_metre = None

    def follow(self, run: SlewedTimeline, lines: Lines, shift: int, now: float) -> None:
        """Adopt the source's measure lines if they differ from ours and were reported often enough."""
        size, beat, spacing = run.timeline.beats_per_measure, lines.beat + shift, round(lines.spacing)
        common = spacing if size % spacing == 0 else size if spacing % size == 0 else 0
        if not common:
            if self.follow_metre and lines.votes >= VOTES_METRE * spacing and METRE_MIN <= spacing <= METRE_MAX:
                run.set_measure_line(beat, now, "lines", beats_per_measure=spacing)
            return
        off = (beat - run.timeline.measure_origin) % common
        if off == 0.0:
            self._agreed, self._fresh = True, False
            self._pinned = self._pinned and math.isfinite(lines.votes)
            return
        if self._pinned:
            needed = VOTES_AGAINST_MANUAL * spacing if self._agreed else math.inf
            enough = lines.votes >= needed and math.isfinite(lines.votes)
        else:
            enough = lines.votes >= (1.0 if self._fresh else VOTES * spacing)
        if enough:
            off = off if off <= common / 2 else off - common
            run.set_measure_line(run.timeline.measure_origin + off, now, "lines")
            self._pinned, self._fresh = False, False
