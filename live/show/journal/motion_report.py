"""Motion quality report of a film, measured frame by frame."""

from typing import Any

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.stage_snapshot import StageView
from live.graph.dance_metrics import RawClips, list_and_p95, median_and_p95, ratio
from live.motion.editing.path_bend import source_name
from live.motion.quality.beat_chance import compare_with_chance
from live.motion.quality.body_contact import ContactRecorder
from live.motion.quality.metrics import (
    contact_slide_speeds,
    half_width,
    largest_around,
    motion_beats,
    strict_ratios,
)
from live.motion.quality.motion_recorder import MotionRecorder
from live.motion.step_clip import StepClip
from live.show.show import Show


class MotionReport:
    """Collector of motion figures: call `frame` for every frame, evenly spaced in time, then `result`."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._slides: list[Float64] = []
        self._previous: tuple[float, Float32, Bool] | None = None
        self._trace: MotionRecorder | None = None
        self._times: list[float] = []
        self._transitions: list[tuple[float, float, Int32]] = []
        """For each measure line: its time, the length of the blend before it, the dancers that changed the clip."""
        self._clips: set[int] = set()
        self._line = 0.0
        """End of the current measure [beats]."""
        self._overlaps = 0
        self._nearest = np.inf
        self._contacts = ContactRecorder()
        self._beats: list[float] = []
        self._music: list[float] = []
        """Times of the Timeline's beats [s]."""
        self._last_phase: tuple[int, float, float] | None = None
        self._measure = -1
        self._steps: list[dict[str, Any]] = []
        self._path_errors: list[float] = []
        self._heading_errors: list[float] = []
        self._visible = show.motion.present.copy()
        """Dancers visible in the last frame; dancers off stage are not reported."""
        self._joining: list[tuple[int, int, Int32]] = []  # windows of joins, first and last frame, that are not over
        self._joined: list[Float32] = []
        self._wish: Float64 | None = None
        self._misses: list[Float64] = []
        self._always_visible = self._visible.copy()
        """Dancers visible in all frames; smoothness is measured for these."""

    def frame(self, view: StageView) -> None:
        """Add one frame, right after it was filled."""
        if self._show.span.number != self._measure:
            self._begin_measure()
        self._feet(view)
        self._read_joins()
        self._visible = view.present.copy()
        self._always_visible &= view.present
        self._distances(view)
        self._contacts.add(view.joint_position, self._show.dancers.held_arms(view.time), view.present)
        self._beat_times(view)

    def _begin_measure(self) -> None:
        """Record the new steps, and the position and heading errors at the measure line."""
        show = self._show
        dancers, library = show.dancers, show.graph.library
        self._measure = show.span.number
        self._record_transitions()
        there = show.motion.present
        if self._wish is not None and self._previous is not None:
            hips = self._previous[1][:, 0, ::2].astype(np.float64)
            self._misses.append(np.hypot(*(hips - self._wish)[there & self._visible].T))
        self._wish = show.scheduler.last_wish
        for dancer, node in enumerate(dancers.node):
            if not there[dancer]:
                continue
            self._steps.append(
                {
                    "dancer": dancer + 1,
                    "measure": self._measure + 1,
                    "step": library.steps[library.node_step[node]],
                    "clip": library.describe(int(node)),
                    "weight": round(1.0 - float(dancers.present.take_share[0, dancer]), 3),
                    "cost": self._cost(int(dancers.past.node[dancer]), int(node)),
                }
            )
        wanted, ends = show.scheduler.last_target, dancers.present.end_position()
        if wanted is not None:
            self._path_errors.append(float(np.hypot(*(wanted - ends)[there].T).mean()))
            yaw = dancers.present.end_placement()[:, 2] + show.graph.node_facing[dancers.node]
            off = yaw - show.scheduler.last_heading
            off = off[there]
            self._heading_errors.append(float(np.degrees(np.abs(np.arctan2(np.sin(off), np.cos(off)))).mean()))

    def _cost(self, before: int, node: int) -> float | None:
        """Return the pose distance of a transition [m]; None at the beginning and for a repeated measure."""
        graph = self._show.graph
        if before < 0:
            return None
        edges = slice(graph.edge_start[before], graph.edge_start[before + 1])
        cost = graph.edge_cost[edges][graph.edge_target[edges] == node]
        return round(float(cost[0]), 4) if len(cost) else None

    def _record_transitions(self) -> None:
        """Record the dancers that changed the clip at the measure line just crossed, and the clips in use."""
        show = self._show
        library, node = show.graph.library, show.dancers.node
        self._clips.update(library.node_clip[node[show.motion.present]].tolist())
        if self._times:  # the first measure begins with no blend
            seconds = library.beats_per_measure * 60.0 / show.timeline.tempo
            changed = np.flatnonzero(library.node_measure[node] == 0).astype(np.int32)
            line, blend = show.timeline.time_at(self._line), show.graph.window * seconds
            self._transitions.append((line, blend, changed))
            if self._trace is not None:
                rate, middle, half = self._rate, line - 0.5 * blend - self._times[0], half_width(blend)
                first = max(int(np.ceil((middle - half) * rate - 1e-6)), 1)
                self._joining.append((first, int((middle + half) * rate + 1e-6), changed))

    def _feet(self, view: StageView) -> None:
        position = view.joint_position.copy()
        contact = self._show.dancers.contact(self._show.span.fraction(view.beat))
        if self._previous is not None:
            time, before, stood = self._previous
            dt = view.time - time
            if dt > 0:
                both = self._visible & view.present
                feet = np.stack([before, position])[:, both], np.stack([stood, contact])[:, both]
                self._slides.append(contact_slide_speeds(*feet, 1.0 / dt))
                if self._trace is None:
                    self._trace = MotionRecorder(1.0 / dt)
                    self._trace.add(before)
                self._trace.add(position)
        self._times.append(view.time)
        self._line = self._show.span.end
        self._previous = (view.time, position, contact)

    def _read_joins(self) -> None:
        """Read the joins whose window is over: the largest velocity change of each joint."""
        if self._trace is None or not self._joining or self._trace.count < self._joining[0][1] + 3:
            return
        first, last, changed = self._joining.pop(0)
        there = changed[self._visible[changed]]
        self._joined.append(self._trace.largest_by_joint(first, last)[there])

    def _distances(self, view: StageView) -> None:
        hips = view.joint_position[view.present, 0][:, (0, 2)].astype(np.float64)
        if len(hips) < 2:
            return
        apart = np.hypot(*(hips[:, None] - hips[None]).transpose(2, 0, 1))
        apart = apart[np.triu_indices(len(hips), 1)]
        radius = float(self._show.motion.model.radius.max())
        self._overlaps += int((apart < 2 * radius).sum())
        self._nearest = min(self._nearest, float(apart.min()))

    def _beat_times(self, view: StageView) -> None:
        """Record when a clip's beat is shown and the time of the Timeline's beat, at crossings of whole beats."""
        beats = view.beats_per_measure
        number, danced = self._show.span.number, self._show.span.fraction(view.beat) * beats
        if self._last_phase is not None:
            last_number, last, time = self._last_phase
            total, before = number * beats + danced, last_number * beats + last
            whole = np.ceil(before)
            if before < whole <= total:
                shown = time + (whole - before) / (total - before) * (view.time - time)
                beat = round(self._show.timeline.beat_at(shown))
                self._music.append(self._show.timeline.time_at(beat))
                self._beats.append(shown - self._music[-1])
        self._last_phase = (number, danced, view.time)

    @property
    def slide(self) -> Float64:
        """Sliding speeds [m/s] of feet that are in contact in the clips, (n,)."""
        return np.concatenate(self._slides) if self._slides else np.zeros(0)

    @property
    def beat_offsets(self) -> Float64:
        """Times at which the clips' beats were shown, minus the Timeline's beats [s], (n,)."""
        return np.array(self._beats)

    def result(self) -> dict[str, Any]:
        """Return the figures; None where nothing was measured."""
        found = self.slide
        return {
            "foot_slide_mean": float(found.mean()) if len(found) else None,
            "foot_slide_p99": float(np.percentile(found, 99)) if len(found) else None,
            "skating_ratio": None if self._trace is None else self._trace.skating_ratio(),
            "position_only": None if self._trace is None else self._trace.position_figures().as_json(),
            **self._join_ratios(),
            "uncut_miss_m": self._uncut_miss(),
            **self._beat_figures(),
            "path_error_m": list_and_p95(self._path_errors),
            "heading_error_deg": list_and_p95(self._heading_errors),
            "overlaps": self._overlaps,
            "min_distance_m": None if np.isinf(self._nearest) else self._nearest,
            **self._contacts.ratios(),
            "steps": self._steps,
            "detours": self._show.scheduler.detours,
            "missing": [{"from": None, "to": None, "needs": text} for text in self._show.graph.missing],
        }

    def _join_ratios(self) -> dict[str, Any]:
        """Return the largest velocity change and acceleration at transitions, relative to the raw clips at this
        tempo."""
        values: dict[str, Any] = {"join_velocity_ratio": None, "join_acceleration_ratio": None}
        strict: dict[str, Any] = {"join_ratio_strict": None, "join_ratio_strict_raw": None}
        if self._trace is None or not self._transitions:
            return values | strict
        show, rate = self._show, self._rate
        half = half_width(max(blend for _, blend, _ in self._transitions))
        seconds = show.graph.library.beats_per_measure * 60.0 / show.timeline.tempo
        clips = RawClips(self._raw_clips(), seconds, rate)
        if self._joined:
            unjoined, joined = clips.changes_by_joint(half), np.concatenate(self._joined).astype(np.float64)
            for key, changes in zip(strict, (joined, unjoined), strict=True):
                strict[key] = float(np.percentile(strict_ratios(changes, unjoined), 95)) if len(changes) else None
        for key, trace, peer in zip(values, self._trace.largest(), clips.p99(half), strict=True):
            joins = [
                largest_around(trace[:, dancer], np.array([line - 0.5 * blend - self._times[0]]), half, rate)
                for line, blend, changed in self._transitions
                for dancer in changed
                if self._always_visible[dancer]
            ]
            values[key] = ratio(np.concatenate(joins), peer) if joins else None
        return values | strict

    def _raw_clips(self) -> tuple[StepClip, ...]:
        """Return the clips in use as recorded or sketched: path variants count as what they were made from."""
        clips = self._show.graph.library.clips
        there = {clip.clip.name: number for number, clip in enumerate(clips)}
        own = {there.get(source_name(clips[number].clip.name), number) for number in self._clips}
        return tuple(clips[number] for number in sorted(own))

    @property
    def uncut_misses(self) -> Float64:
        """Distances [m] at measure ends from the dancers to where steering predicted their agents, (n,)."""
        return np.concatenate(self._misses) if self._misses else np.zeros(0)

    def _uncut_miss(self) -> dict[str, float] | None:
        found = self.uncut_misses
        return {"mean": float(found.mean()), "p95": float(np.percentile(found, 95))} if len(found) else None

    def _beat_figures(self) -> dict[str, Any]:
        """Return offsets and alignment of the clips' annotated beats and of kinematic beats, those also by chance."""
        motion: list[Float64] = []
        if self._trace is not None:
            speeds = self._trace.speeds().T[self._always_visible]
            motion = [motion_beats(speed, self._rate, self._times[0]) for speed in speeds]
        found = compare_with_chance(np.array(self._music), motion)
        return {
            "beat_offset_ms": {
                "annotated": median_and_p95(np.array(self._beats)),
                "kinematic": median_and_p95(found.offset),
                "kinematic_chance": median_and_p95(found.chance_offset),
            },
            "beat_alignment": found.alignment,
        }

    @property
    def _rate(self) -> float:
        """Frames per second."""
        return (len(self._times) - 1) / (self._times[-1] - self._times[0])
