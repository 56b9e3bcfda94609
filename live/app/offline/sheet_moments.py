"""Selection of a contact sheet's moments while a show runs offline."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.app.session_audio import AudioChoice, make_map_clock, make_show_analysis
from live.base.arrays import Float64
from live.base.picture_parameters import BY_ADDRESS, STYLE_ADDRESS_PREFIX, group_parameter
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.control.audio.music_file import OfflineMusic
from live.show.journal.journal_reader import Journal
from live.show.journal.replay import Replayer
from live.show.loader import LoadedShow
from live.show.show import Show

MEASURE_POSITION: Final = 0.55
"""Position of a picture in its measure, as a share: there most steps are at their widest."""
TRACE_BEATS: Final = 2.0
"""Beats before a picture that are drawn as well if trails or ribbons are on."""


@dataclass(frozen=True, slots=True)
class SheetMoment:
    """Data of a picture."""

    measure: int
    """From 1, as is `beat`."""
    beat: int
    seconds: float
    tempo: float
    section: str | None
    cue: str | None
    """The last cue."""
    steps: tuple[tuple[tuple[float, float, float], str, str], ...]
    """Colour (linear RGB), name and most frequent step of each group on stage."""


class MomentSelector:
    """Decides at each tick whether a picture is taken, or only drawn for trails in a later one."""

    def __init__(self, show: Show, every: int, first: int) -> None:
        """Take measure `first` (from 0) and each `every` measures after it."""
        self.show, self._every, self._next = show, every, first
        self._view = show.view()

    def select(self, time: float) -> tuple[StageView, SheetMoment | None] | None:
        """Return the view to draw at `time` [s], after its tick, with its data if it is taken; None to draw nothing."""
        show, beats = self.show, self.show.desk.beats
        if show.span.number > self._next:
            self._next += self._every * math.ceil((show.span.number - self._next) / self._every)
        ahead = (self._next + MEASURE_POSITION) * beats - show.danced_beats
        if ahead > TRACE_BEATS:
            return None
        if ahead > 0.0 and (round(time / TICK) % 4 or not self._has_trails()):
            return None
        show.fill(self._view, time)
        if ahead > 0.0:
            return self._view, None
        self._next += self._every
        return self._view, self._describe(time)

    def _has_trails(self) -> bool:
        row = self._view.picture
        if row is None:
            return True
        styles = [
            group_parameter(STYLE_ADDRESS_PREFIX + name, group)
            for name in ("trails", "ribbons")
            for group in self._groups
        ]
        return bool(row[BY_ADDRESS["/dance/pass/trails"].first] > 0.0 or any(row[one.first] > 0.0 for one in styles))

    @property
    def _groups(self) -> range:
        return range(len(self.show.patch.group))

    def _describe(self, time: float) -> SheetMoment:
        show, row = self.show, self.show.desk.parameters.picture  # colours as such, in whatever light
        beats = show.timeline.beats_per_measure
        within = show.danced_beats - show.span.number * show.desk.beats
        section = show.score_runner.facts()["section"]
        return SheetMoment(
            show.span.number + 1, min(int(within * beats / show.desk.beats), beats - 1) + 1, time,
            float(show.follower.tempo), section if len(show.playhead.sections) > 1 else None,
            show.desk.facts(show.danced_beats)["cues"]["last"],
            tuple(
                (_colour(row, group), show.patch.group[group].name, step)
                for group in self._groups
                if (step := self._step(group)) is not None
            ),
        )  # fmt: skip

    def _step(self, group: int) -> str | None:
        """Return the most frequent step of a group, or its response to the leaders."""
        library, rows = self.show.graph.library, (self.show.group == group) & self._view.present
        nodes = self.show.dancers.node[rows]
        if len(nodes) == 0:
            return None
        return self._response(rows) or str(library.steps[int(np.bincount(library.node_step[nodes]).argmax())])

    def _response(self, rows: npt.NDArray[np.bool_]) -> str | None:
        """Return these dancers' present response to their leaders; None if most dance their own steps."""
        answering = self.show.dancers.partner_response
        if answering is None or 2 * np.count_nonzero(answering.path.answering & rows) <= np.count_nonzero(rows):
            return None
        partners = {answering.settings[pair.partner].name for pair in answering.pairs if rows[pair.follower]}
        labels = (label for _, partner, label in reversed(answering.leaders.recent_units) if partner in partners)
        return next(labels, None)


def _colour(row: Float64, group: int) -> tuple[float, float, float]:
    red, green, blue = row[group_parameter("/dance/group/colour", group).row_slice].tolist()
    return red, green, blue


def moments_of_patch(
    loaded: LoadedShow, show: Show, sound: AudioChoice, seconds: float, every: int
) -> Iterator[tuple[StageView, SheetMoment | None]]:
    """Yield the moments of a show from its beginning, `seconds` long."""
    music = None
    if sound.music is not None:
        one_at = loaded.patch.music.first_downbeat if sound.from_patch else None
        music = OfflineMusic(
            sound.music,
            one_at=one_at,
            analysis=make_show_analysis(sound, loaded, show, make_map_clock(sound, loaded.patch)),
        )
    taking = MomentSelector(show, every, 0)
    for tick in range(1, math.ceil(seconds / TICK) + 1):
        for event in [] if music is None else music.events_until(tick * TICK):
            show.apply(event)
        show.tick(tick * TICK)
        found = taking.select(tick * TICK)
        if found is not None:
            yield found


def moments_of_journal(running: Replayer, every: int) -> Iterator[tuple[StageView, SheetMoment | None]]:
    """Yield the moments of a journal from the replay's present tick."""
    taking = MomentSelector(running.show, every, running.show.span.number)
    while not running.ended and running.damaged is None:
        running.advance(running.tick + 1)
        found = taking.select(running.tick * TICK)
        if found is not None:
            yield found


def measure_count(journal: Journal) -> int:
    """Return the number of measures in the journal, including the last incomplete one."""
    return sum(line.measure is not None for line in journal.lines_with_damage()) + 1
