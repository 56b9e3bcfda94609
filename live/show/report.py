"""FrameReport: what a film's dancers really did, measured frame by frame in the form of the contracts."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.stage_view import StageView
from live.motion.skeleton import SKELETON
from live.show.core import Show

Float64 = npt.NDArray[np.float64]

FEET = tuple((SKELETON.index(f"{side}Foot"), SKELETON.index(f"{side}Toes")) for side in ("left", "right"))
SKATE_HEIGHT = 0.05
SKATE_SPEED = 0.5
"""Skating ratio as in the GMD code: a foot lower than 5 cm (over its rest height) that moves faster than 0.5 m/s."""


class FrameReport:
    """Feed it every frame of a film; `result` gives the figures. Frames must be evenly spaced in time."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._rest = SKELETON.rest_positions()
        self._slides: list[Float64] = []
        self._skating = 0
        self._foot_frames = 0
        self._previous: tuple[float, Float64] | None = None
        self._overlaps = 0
        self._nearest = np.inf
        self._beats: list[float] = []
        self._last_phase: tuple[int, float, float] | None = None
        self._measure = -1
        self._steps: list[dict[str, Any]] = []
        self._path_errors: list[float] = []
        self._heading_errors: list[float] = []

    def frame(self, view: StageView) -> None:
        """Take one frame, right after it was filled."""
        if self._show.span.number != self._measure:
            self._begin_measure()
        self._feet(view)
        self._distances(view)
        self._beat_times(view)

    def _begin_measure(self) -> None:
        """Note the steps danced, and where the dancers who crossed the line stand against where they should."""
        show = self._show
        dancers, library = show.dancers, show.graph.library
        self._measure = show.span.number
        for dancer, node in enumerate(dancers.node):
            self._steps.append(
                {
                    "dancer": dancer + 1,
                    "measure": self._measure + 1,
                    "step": library.steps[library.node_step[node]],
                    "clip": library.describe(int(node)),
                }
            )
        wanted, ends = show.scheduler.last_target, dancers.present.end_position()
        if wanted is not None:
            self._path_errors.append(float(np.hypot(*(wanted - ends).T).mean()))
            yaw = dancers.present.end_placement()[:, 2] + show.graph.node_facing[dancers.node]
            off = yaw - show.scheduler.last_heading
            self._heading_errors.append(float(np.degrees(np.abs(np.arctan2(np.sin(off), np.cos(off)))).mean()))

    def _feet(self, view: StageView) -> None:
        position = view.joint_position[:, [joint for pair in FEET for joint in pair]].astype(np.float64)
        contact = self._show.dancers.contact(self._show.span.fraction(view.beat))
        if self._previous is not None:
            time, before = self._previous
            dt = view.time - time
            if dt > 0:
                moved = np.hypot(*(position - before)[..., (0, 2)].transpose(2, 0, 1)) / dt
                speed = moved.reshape(len(position), 2, 2).min(axis=2)  # heel or ball, whichever stands stiller
                self._slides.append(speed[contact])
                height = position.reshape(len(position), 2, 2, 3)[..., 1] - np.array(
                    [[self._rest[j, 1] for j in pair] for pair in FEET]
                )
                skates = (height.min(axis=2) < SKATE_HEIGHT) & (speed > SKATE_SPEED)
                self._skating += int(skates.any(axis=1).sum())
                self._foot_frames += len(position)
        self._previous = (view.time, position)

    def _distances(self, view: StageView) -> None:
        hips = view.joint_position[:, 0][:, (0, 2)].astype(np.float64)
        if len(hips) < 2:
            return
        apart = np.hypot(*(hips[:, None] - hips[None]).transpose(2, 0, 1))
        apart = apart[np.triu_indices(len(hips), 1)]
        radius = float(self._show.model.radius.max())
        self._overlaps += int((apart < 2 * radius).sum())
        self._nearest = min(self._nearest, float(apart.min()))

    def _beat_times(self, view: StageView) -> None:
        """When a clip's own beat is shown, against the Timeline's: crossings of whole beats between two frames."""
        beats = view.beats_per_measure
        number, danced = self._show.span.number, self._show.span.fraction(view.beat) * beats
        if self._last_phase is not None:
            last_number, last, time = self._last_phase
            total, before = number * beats + danced, last_number * beats + last
            whole = np.ceil(before)
            if before < whole <= total:
                shown = time + (whole - before) / (total - before) * (view.time - time)
                beat = round(self._show.timeline.beat_at(shown))
                self._beats.append(shown - self._show.timeline.time_at(beat))
        self._last_phase = (number, danced, view.time)

    def result(self) -> dict[str, Any]:
        """The figures; null where nothing was measured."""
        slides = np.concatenate(self._slides) if self._slides else np.zeros(0)
        beats = np.abs(self._beats) * 1e3
        return {
            "foot_slide_mean": _or_none(slides, np.mean),
            "foot_slide_p99": _or_none(slides, lambda v: np.percentile(v, 99)),
            "skating_ratio": self._skating / self._foot_frames if self._foot_frames else None,
            "beat_offset_ms": {
                "annotated": {
                    "median": _or_none(beats, np.median),
                    "p95": _or_none(beats, lambda v: np.percentile(v, 95)),
                }
            },
            "path_error_m": _list_and_p95(self._path_errors),
            "heading_error_deg": _list_and_p95(self._heading_errors),
            "overlaps": self._overlaps,
            "min_distance_m": None if np.isinf(self._nearest) else self._nearest,
            "steps": self._steps,
            "detours": self._show.scheduler.detours,
            "missing": [{"from": None, "to": None, "needs": text} for text in self._show.graph.missing],
        }


def _or_none(values: Any, figure: Any) -> float | None:
    return float(figure(values)) if len(values) else None


def _list_and_p95(values: list[float]) -> dict[str, Any]:
    return {"list": values, "p95": float(np.percentile(values, 95)) if values else None}
