"""What is measured while a scene is danced: on the joints that are drawn, not on what the engine thinks of them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, QhullError

from bench._locomotion_beats import DrawnBeats
from live.base.stage_snapshot import StageView
from live.graph.select.candidates import turn_vectors
from live.graph.step_library import StepLibrary
from live.show.journal.motion_report import MotionReport
from live.show.show import Show

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

NEAR = 0.5
"""Hips nearer than this [m] are bodies that overlap: twice the radius of the usual dancer."""


@dataclass(eq=False)
class Figures:
    """All that was found in one run or, joined, in several."""

    slide: list[Float64] = field(default_factory=list)
    """Speeds [m/s] of feet that the clips have on the floor, heel or ball, the stiller."""
    skating: list[float] = field(default_factory=list)
    join: list[float] = field(default_factory=list)
    beats: list[Float64] = field(default_factory=list)
    """Clips' annotated beats as they are shown against the Timeline's [s]."""
    drawn_beats: list[Float64] = field(default_factory=list)
    """The same, found by where the drawn body comes nearest to the clip's pose of the beat [s]."""
    predicted: list[Float64] = field(default_factory=list)
    """Hips as drawn at measure ends to where the engine sent them, a beat before the measure began [m]."""
    predicted_last: list[Float64] = field(default_factory=list)
    """The same, with what agents have strayed within the measure [m]."""
    within_reach: list[Float64] = field(default_factory=list)
    """To where steering alone would be, cut off where the step's own ways end [m]."""
    free: list[Float64] = field(default_factory=list)
    """To where steering alone would be, however far [m]."""
    agents: list[Float64] = field(default_factory=list)
    """To the agent at that moment [m]."""
    between: list[Float64] = field(default_factory=list)
    """To the agent in all pictures [m]."""
    between_free: list[Float64] = field(default_factory=list)
    """In all pictures, to the even way from one place that steering foresaw to the next [m]."""
    reports: list[dict[str, Any]] = field(default_factory=list)
    """The motion report of each run."""
    overlaps: int = 0
    """Times that a pair came nearer than NEAR."""
    overlapping: list[float] = field(default_factory=list)
    """Share of the pictures in which some pair is."""
    nearest: float = np.inf
    outside: float = 0.0
    """How far hips were beyond the stage's edge at most [m]."""

    def join_with(self, other: "Figures") -> "Figures":
        """Both together."""
        both = Figures(overlaps=self.overlaps + other.overlaps, nearest=min(self.nearest, other.nearest))
        both.outside = max(self.outside, other.outside)
        for name, value in vars(both).items():
            if isinstance(value, list):
                value += getattr(self, name) + getattr(other, name)
        return both


class Watch:
    """Watches one show: feed it every drawn picture, then ask for `figures`."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._report = MotionReport(show)
        self._drawn = DrawnBeats(show)
        self._figures = Figures()
        self._near: Bool | None = None
        self._before: tuple[float, Float64] | None = None
        self._measure = show.span.number
        self._line = show.span.end
        self._asked: list[Float64] = []
        self._last = np.zeros((len(show.group), 2))
        self._sent: (
            tuple[Float64 | None, Float64 | None, Float64, npt.NDArray[np.int32], Float64, Float64 | None] | None
        ) = None
        self._reach = Reach(show.graph.library, show.graph.node_facing_start)
        self._pictures = 0
        self._crowded = 0
        self._half = np.array([show.patch.stage.width, show.patch.stage.depth]) / 2
        ahead = show.motion.predicted_ends

        def listen() -> tuple[Float64, Bool, Float64]:
            answer = ahead()
            self._asked.append(answer[0].copy())
            return answer

        show.motion.predicted_ends = listen  # type: ignore[method-assign]  # what steering alone foresees, before all cutting

    def picture(self, view: StageView) -> None:
        """One picture, right after it was filled; 60 a second."""
        self._report.frame(view)
        self._drawn.picture(view)
        hips = view.joint_position[:, 0][:, (0, 2)].astype(np.float64)
        self._distances(hips[view.present])
        self._figures.between.append(np.hypot(*(hips - self._show.state.position).T))
        if self._sent is not None and self._sent[1] is not None and self._sent[5] is not None:
            even = self._sent[5] + self._show.span.fraction(view.beat) * (self._sent[1] - self._sent[5])
            self._figures.between_free.append(np.hypot(*(hips - even).T))
        self._figures.outside = max(self._figures.outside, float((np.abs(hips[view.present]) - self._half).max()))
        if self._show.span.number != self._measure:
            self._cross_line(view, hips)
        self._line = self._show.span.end
        self._last = self._show.scheduler.root_correction.predicted.copy()
        self._before = (view.beat, hips)

    def _distances(self, hips: Float64) -> None:
        apart = np.hypot(*(hips[:, None] - hips[None]).transpose(2, 0, 1))
        np.fill_diagonal(apart, np.inf)
        near = apart < NEAR
        if self._near is not None and self._near.shape == near.shape:
            self._figures.overlaps += int((near & ~self._near).sum()) // 2
        self._near = near
        self._pictures += 1
        self._crowded += bool(near.any())
        self._figures.nearest = min(self._figures.nearest, float(apart.min()))

    def _cross_line(self, view: StageView, hips: Float64) -> None:
        """A measure has ended between the last picture and this one: who is where?"""
        if self._before is None:
            return
        beat, before = self._before
        share = np.clip((self._line - beat) / max(view.beat - beat, 1e-9), 0.0, 1.0)
        at_line = before + share * (hips - before)
        show, found = self._show, self._figures
        if self._sent is not None:
            sent, free, start, node, heading, _ = self._sent
            if sent is not None:
                found.predicted.append(np.hypot(*(at_line - sent).T))
                found.predicted_last.append(np.hypot(*(at_line - self._last).T))
            if free is not None:
                found.free.append(np.hypot(*(at_line - free).T))
                found.within_reach.append(np.hypot(*(at_line - self._reach.cut(start, free, node, heading)).T))
            found.agents.append(np.hypot(*(at_line - show.state.position).T))
        target = show.scheduler.last_target
        self._sent = (
            None if target is None else np.array(target, np.float64),
            self._asked[-1] if self._asked else None,
            at_line,
            show.dancers.present.node.copy(),
            show.dancers.present.begin_heading().copy(),
            None if self._sent is None else self._sent[1],
        )
        self._measure = show.span.number

    def figures(self) -> Figures:
        """What was found."""
        found, result = self._figures, self._report.result()
        found.reports.append(result)
        found.slide.append(self._report.slide)
        if result["skating_ratio"] is not None:
            found.skating.append(result["skating_ratio"])
        if result["join_velocity_ratio"] is not None:
            found.join.append(result["join_velocity_ratio"])
        found.beats.append(np.abs(self._report.beat_offsets))
        found.drawn_beats += [np.abs(each) for each in self._drawn.offsets]
        found.overlapping.append(self._crowded / max(self._pictures, 1))
        return found


class Reach:
    """How far a step's own ways go in any direction: the hull of where its nodes end, a mixture of takes included."""

    def __init__(self, library: StepLibrary, facing: Float64) -> None:
        ways = turn_vectors(library.node_travel, -facing)
        self._step = library.node_step
        self._planes: list[Float64 | float] = []
        for step in range(len(library.steps)):
            own = np.concatenate([ways[library.node_step == step], np.zeros((1, 2))])
            try:
                self._planes.append(ConvexHull(own).equations)
            except QhullError:  # all on one line
                self._planes.append(float(np.hypot(*own.T).max()))

    def cut(self, start: Float64, target: Float64, node: npt.NDArray[np.int32], heading: Float64) -> Float64:
        """`target` (A, 2) no farther from `start` (A, 2) than the steps of `node` go that begin facing `heading`."""
        way = turn_vectors(target - start, -heading)
        share = np.ones(len(way))
        for dancer, step in enumerate(self._step[node]):
            planes = self._planes[step]
            if isinstance(planes, float):
                share[dancer] = planes / max(float(np.hypot(*way[dancer])), 1e-9)
                continue
            along = planes[:, :2] @ way[dancer]
            beyond = along > 1e-9
            if beyond.any():
                share[dancer] = float((-planes[beyond, 2] / along[beyond]).min())
        return np.asarray(start + np.clip(share, 0.0, 1.0)[:, None] * (target - start))
