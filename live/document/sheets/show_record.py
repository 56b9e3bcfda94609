"""Record of a show for its sheets: where everybody is, what they dance, and what leads them, from a run of the show.

The show is simulated as it runs live, with its seed and without input. Where its score waits, `/dance/advance` is given
in the last measure of the waiting section's first pass.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from live.agents.evolutions.intention import Evolve, Hold, Segment, Trajectory
from live.base.arrays import Bool, Float32, Float64, Int32
from live.clock.ticks import TICK
from live.control.events import events
from live.document.sheets.score_course import ScoreCourse
from live.motion.editing.facing import heading_of
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_score import AtSection
from live.show.show import Show

TICKS_PER_SAMPLE: Final = 4
"""Ticks between two samples: 16 a second. There is also one for each measure line."""
AFTER_LINE: Final = 8
"""Ticks after a measure line at which segments that began with it are read: they are planned in pieces."""
SOURCE: Final = "sheets"
"""Source of the events that the sheets give."""


@dataclass(frozen=True, slots=True, eq=False)
class Led:
    """A segment, and whom it leads."""

    measure: int
    """The measure that it begins with, from 0."""
    end: float
    """The danced beat at which all have arrived."""
    words: str
    """What it is, as `to star`."""
    group: str
    """Whom the score names; empty for all."""
    dancers: Int32
    """Indices (D,)."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeMotion:
    """An element, and whom it moves."""

    begin: float
    """Danced beats."""
    end: float
    kind: str
    group: str
    dancers: Int32
    """Indices (D,), of those meant when it begins."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A signal, call or change of groups of the score at a danced beat."""

    beat: float
    words: str


@dataclass(frozen=True, slots=True, eq=False)
class ShowRecord:
    """M measures of a show of A dancers in S samples."""

    course: ScoreCourse
    beats: int
    """Beats of a measure."""
    danced: Float64
    """Danced beats at each sample, ascending, (S,)."""
    tick: Int32
    """Tick of each sample, (S,)."""
    lines: Int32
    """Sample at the line of each measure and at the end of the last one, (M + 1,)."""
    place: Float32
    """Places of the hips, (S, A, 2) [m]."""
    heading: Float32
    """Headings of the hips, (S, A) [rad]."""
    present: Bool
    """Who is on the stage or on the way in or out, (S, A)."""
    step: Int32
    """Step danced in each measure, (M, A); -1 for those who answer a leader."""
    steps: tuple[str, ...]
    """Names of the steps."""
    group: Int32
    """Group of each dancer in each measure, (M, A)."""
    partner: Int32
    """Partner of each dancer in each measure, -1 for none, (M, A)."""
    led: tuple[Led, ...]
    free: tuple[FreeMotion, ...]
    marks: tuple[Mark, ...]

    @property
    def measures(self) -> int:
        """Number of measures."""
        return len(self.lines) - 1

    @property
    def tempo(self) -> float:
        """Mean tempo of the run [bpm]."""
        seconds = float(self.tick[self.lines[-1]] - self.tick[self.lines[0]]) * TICK
        return 60.0 * float(self.danced[self.lines[-1]] - self.danced[self.lines[0]]) / seconds

    def rows(self, first: int, end: int) -> slice:
        """Return the samples from the line of measure `first` to that of `end`, both included."""
        return slice(int(self.lines[first]), int(self.lines[end]) + 1)


def record_show(show: Show, course: ScoreCourse, progress: Callable[[int], None] = lambda measure: None) -> ShowRecord:
    """Run a fresh show, which is used up, over its course. `progress` is told each measure (from 0) that begins."""
    recorder = ShowRecorder(show, course)
    told = -1
    for measure in recorder.run():
        if told < measure < len(course.measures):
            told = measure
            progress(measure)
    return recorder.record()


class ShowRecorder:
    """Runs a fresh show, which is used up, over its course, tick by tick."""

    def __init__(self, show: Show, course: ScoreCourse) -> None:
        self._show, self._course, self._count = show, course, len(course.measures)
        self._beats = show.desk.beats
        self._samples: list[tuple[float, int, Float32, Float32, Bool]] = []
        self._lines: list[int] = []
        self._steps: list[Int32] = []
        self._groups: list[Int32] = []
        self._partners: list[Int32] = []
        self._led: dict[int, Led] = {}
        self._seen: list[Segment] = []  # keeps them, so that their ids stay theirs
        self._free: list[FreeMotion] = []
        self._marks: list[Mark] = []

    @property
    def measures(self) -> int:
        """Number of measures that have begun."""
        return len(self._lines)

    def run(self) -> Iterator[int]:
        """Run the show to the end of its course; yield the measure (from 0, -1 before the first) after each tick."""
        show, tick, measure, line_tick = self._show, 0, -1, 0
        while True:
            tick += 1
            show.tick(tick * TICK)
            if show.span.number > measure:
                measure, line_tick = show.span.number, tick
                self._sample(tick, line=True)
                if measure >= self._count:
                    return
                self._begin(measure, tick * TICK)
            elif tick % TICKS_PER_SAMPLE == 0 and measure >= 0:
                self._sample(tick)
            if measure >= 0 and tick == line_tick + AFTER_LINE:
                self._read_segments()
            if len(self._steps) <= measure and self._fraction() >= 0.5:
                self._read_steps()
            yield measure

    def _fraction(self) -> float:
        return self._show.danced_beats / self._beats - self._show.span.number

    def _sample(self, tick: int, *, line: bool = False) -> None:
        show, dancers = self._show, self._show.dancers
        if line:
            self._lines.append(len(self._samples))
        count = len(show.group)
        heading = heading_of(dancers.leg_rotation[:count, 0]).astype(np.float32)
        there = show.motion.group_states()[:count] != 0
        self._samples.append((show.danced_beats, tick, dancers.drawn_hips[:count].copy(), heading, there))

    def _begin(self, measure: int, time: float) -> None:
        """Read what the score begins with this measure, and let it go on where it waits."""
        show, score = self._show, self._show.score_runner.score
        line = float(measure * self._beats)
        place = show.state.position
        for element in score.elements(measure):
            begin = line + (element.measure % 1.0) * self._beats
            self._free.append(self._element(element, begin, show.casting.select(element.group, place)))
        for regroup in score.regroups(measure):
            self._marks.append(Mark(line, f"{regroup.dancers} change to {regroup.group}"))
        for signal in score.signals(measure):
            self._marks.append(Mark(line + signal.beat - 1.0, f"signal {signal.name}"))
        for call in score.calls(measure):
            self._marks.append(Mark(line + call.beat - 1.0, call_words(call)))
        if self._course.measures[measure].waits:
            show.apply(events.Advance(time=time, source=SOURCE))

    def _element(self, element: ElementSection, begin: float, who: Bool) -> FreeMotion:
        end = begin + element.measures * self._beats
        return FreeMotion(begin, end, element.kind, group_words(element.group), np.flatnonzero(who).astype(np.int32))

    def _read_segments(self) -> None:
        for segment, dancers in self._show.motion.evolutions.begun():
            if id(segment) not in self._led:
                end = float(segment.end_beat(self._beats))
                self._seen.append(segment)
                self._led[id(segment)] = Led(segment.start, end, segment_words(segment), segment.group, dancers)

    def _read_steps(self) -> None:
        show = self._show
        step = np.asarray(show.graph.library.node_step)[show.dancers.node].astype(np.int32)
        answers = show.dancers.partner_response
        partner = show.motion.partners.partner.astype(np.int32)
        if answers is not None:
            step[answers.path.following] = -1
            for pair in answers.pairs:
                if pair.leader != pair.follower:
                    partner[pair.follower], partner[pair.leader] = pair.leader, pair.follower
        self._steps.append(step)
        self._groups.append(show.group.copy())
        self._partners.append(partner)

    def record(self) -> ShowRecord:
        """Return the record of a run that is over."""
        danced, ticks, place, heading, present = zip(*self._samples, strict=True)
        return ShowRecord(
            self._course, self._beats, np.array(danced, np.float64), np.array(ticks, np.int32),
            np.array(self._lines, np.int32), np.array(place, np.float32), np.array(heading, np.float32),
            np.array(present, np.bool_), np.array(self._steps, np.int32), tuple(self._show.graph.library.steps),
            np.array(self._groups, np.int32), np.array(self._partners, np.int32), tuple(self._led.values()),
            tuple(self._free), tuple(self._marks),
        )  # fmt: skip


def segment_words(segment: Segment) -> str:
    """Return what a segment is."""
    match segment.intention:
        case Hold():
            return f"hold {segment.intention.formation}"
        case Evolve():
            return f"to {segment.intention.formation}"
        case Trajectory():
            return "travel along a line"
    return "stay in place"


def group_words(group: str) -> str:
    """Return the words that select dancers; empty for all."""
    return "" if group.strip() in ("", "*") else group.strip()


def call_words(call: AtSection) -> str:
    """Return what an `[[at]]` does."""
    if call.signal is not None:
        return f"signal {call.signal}"
    said = call.call or f"scene {call.scene}"
    return " ".join([said.removeprefix("/dance/"), *(_value(value) for value in call.values)])


def _value(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
