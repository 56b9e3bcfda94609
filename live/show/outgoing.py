"""Outgoing: what of a running show others are told as it happens: Timeline, measures, steps, feet, places."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.base.stage_snapshot import StageView
from live.clock.timeline import Timeline
from live.show.core import Show
from live.show.dancers.footfalls import Footfalls

NEWS_AT_ONCE: Final = 64
"""Steps and feet of one frame that are told; a whole company that begins a step at once is told in the next frames."""
CLOSE: Final = 1e-6
"""Beats by which Timelines may differ and still say the same."""
ROWS_AT_ONCE: Final = 1000
_SIDES: Final = ("left", "right")

Told = tuple[str, Any]


class Outgoing:
    """Looks at one show after each frame and changes nothing. Thread: the show's."""

    def __init__(self, show: Show, *, positions: float = 10.0, feet: bool = True) -> None:
        """`positions`: how many times a second places are told, 0 for never."""
        self._show, self._positions = show, positions
        self._feet = Footfalls(show) if feet else None
        self._timeline: Timeline | None = None
        self._measure = (-1, 0.0)
        self._step: npt.NDArray[np.int32] = np.full(len(show.group), -1, np.int32)
        self._names: tuple[str, ...] = ()
        self._waiting: list[tuple[str, tuple[Any, ...]]] = []
        self._time = -1.0
        self._due = 0.0
        self._units = 0
        self.left_out = 0
        """Feet and steps that were too many to be told."""

    def anew(self) -> None:
        """Somebody else listens now, and knows nothing."""
        self._timeline = None
        self._measure = (-1, 0.0)

    def frame(self, view: StageView) -> list[Told]:
        """What there is to tell after the frame for which `view` was filled."""
        show = self._show
        told: list[Told] = []
        measure = (show.span.number, show.span.end)
        if measure != self._measure:
            self._measure = measure
            told.append(("measure", measure))
        timeline = show.timeline
        if self._timeline is None or not _alike(timeline, self._timeline, show.time):
            self._timeline = timeline
            told.append(("timeline", (timeline.tempo, timeline.beat_origin, timeline.time_origin,
                                      timeline.beats_per_measure, timeline.measure_origin)))  # fmt: skip
        self._note_steps(view)
        self._note_units()
        if self._feet is not None and view.filled and view.time > self._time:
            for fall in self._feet.frame(view):
                values = (fall.dancer + 1, _SIDES[fall.foot], *fall.place, fall.strength, fall.part)
                self._waiting.append(("foot", values))
        self._time = view.time
        if self._waiting:
            told.append(("news", self._waiting[:NEWS_AT_ONCE]))
            rest = self._waiting[NEWS_AT_ONCE:]
            self.left_out += max(len(rest) - ROWS_AT_ONCE, 0)
            self._waiting = rest[:ROWS_AT_ONCE]
        if self._positions and view.time >= self._due:
            self._due = view.time + 1.0 / self._positions
            told.append(("positions", places(view)))
        return told

    def _note_units(self) -> None:
        """What who answers a leader dances."""
        answering = self._show.dancers.answering
        if answering is None or answering.leaders.told == self._units:
            return
        for number, partner, label in answering.leaders.news:
            if number > self._units:
                self._waiting.append(("unit", (partner, label, label.rpartition("/")[0])))
        self._units = answering.leaders.told

    def _note_steps(self, view: StageView) -> None:
        """Who begins another step."""
        library = self._show.graph.library
        step = library.node_step[self._show.dancers.node]
        if library.steps != self._names:
            self._names = library.steps
        begun = np.flatnonzero((step != self._step) & view.present)
        if not len(begun):
            return
        self._step[begun] = step[begun]
        for dancer in begun.tolist():
            values = (dancer + 1, self._names[step[dancer]], self._show.patch.group[self._show.group[dancer]].name)
            self._waiting.append(("step", values))


def _alike(one: Timeline, other: Timeline, time: float) -> bool:
    """Whether two Timelines say the same from `time` [s] on, for whoever hears their beats."""
    same_lines = one.beats_per_measure == other.beats_per_measure and one.measure_origin == other.measure_origin
    return same_lines and one.tempo == other.tempo and abs(one.beat_at(time) - other.beat_at(time)) < CLOSE


def places(view: StageView) -> bytes:
    """Rows (number from 1, x, z [m], heading [rad]) of the dancers on the stage, as float32."""
    there = np.flatnonzero(view.present)[:ROWS_AT_ONCE]
    w, x, y, z = view.joint_rotation[there, 0].T
    hips = view.joint_position[there, 0]
    heading = np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (x * x + y * y))
    return np.column_stack((there + 1, hips[:, 0], hips[:, 2], heading)).astype(np.float32).tobytes()
