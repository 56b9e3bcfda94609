"""Alignment of the timeline's measure lines and metre with those of a source, with priority for manual settings."""

import math
from typing import Final

from live.clock.follower.clock_source import Lines
from live.clock.follower.phase_correction import SlewedTimeline
from live.clock.timeline import METRE_MAX, METRE_MIN

VOTES: Final = 1.0
"""A source's measure line is adopted after this many equal measures in a row ..."""

VOTES_AFTER_END: Final = 4.0
"""... or this many, if ours was set by hand for music that has ended since."""

QUESTION_SHARE: Final = 0.9
QUESTION_MEASURES: Final = 8.0
"""The operator is asked about a line set by hand if another one has been this likely for so many measures."""

VOTES_METRE: Final = 2.0
"""Number of measures of another metre after which it is adopted, if metres are followed."""


class BarAlignment:
    """Follows the measure lines of the active source."""

    def __init__(self, *, follow_metre: bool = False) -> None:
        """`follow_metre`: whether a source may change the number of beats in a measure."""
        self.follow_metre = follow_metre
        self.pending_metre: int | None = None
        """Beats in a measure from the next line on; None: unchanged."""
        self.runner_up = (0.0, 0.0)
        """The most likely other line: by how many beats later measures would begin, and its probability; 0 if none."""
        self._pinned = False
        self._ended = False
        self._fresh = True
        self._likely_since = math.inf  # the beat since which the runner-up has been as likely as the question needs

    def pin(self) -> None:
        """Keep the line as set by hand, against the source."""
        self._pinned, self._ended = True, False
        self._forget_runner_up()

    def unpin(self) -> None:
        """Adopt the source's next measure line."""
        self._pinned, self._fresh = False, True
        self._forget_runner_up()

    def end_song(self) -> None:
        """The music has ended: the line set by hand holds, but other music may move it."""
        self._ended = True
        self._forget_runner_up()

    def asks(self, beat: float, size: int) -> bool:
        """Whether the operator should be asked at `beat`: another line has been likely for many measures of `size`
        beats."""
        return self._pinned and beat - self._likely_since >= QUESTION_MEASURES * size

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
        self._update_runner_up(lines, off, common, run.timeline.beat_at(now))
        if off == 0.0:
            self._fresh = False
            self._pinned = self._pinned and math.isfinite(lines.votes)
            return
        if self._pinned:
            enough = self._ended and VOTES_AFTER_END * spacing <= lines.votes < math.inf
        else:
            enough = lines.votes >= (1.0 if self._fresh else VOTES * spacing)
        if enough:
            off = off if off <= common / 2 else off - common
            run.set_measure_line(run.timeline.measure_origin + off, now, "lines")
            self._pinned, self._fresh = False, False

    def _update_runner_up(self, lines: Lines, off: float, common: int, beat: float) -> None:
        """Note the most likely other line: the source's own, if ours is `off` beats beside it, else the one that it
        names."""
        if off:
            share = min(lines.votes / (QUESTION_MEASURES * common), 1.0)
            self.runner_up = off, max(share, 1.0 - lines.runner_up_share if lines.runner_up_share else 0.0)
        else:
            self.runner_up = lines.runner_up % common, lines.runner_up_share if lines.runner_up % common else 0.0
        if self.runner_up[1] < QUESTION_SHARE:
            self._likely_since = math.inf
        elif not math.isfinite(self._likely_since):
            self._likely_since = beat

    def _forget_runner_up(self) -> None:
        self.runner_up, self._likely_since = (0.0, 0.0), math.inf
