"""Quality metrics of an assembled dance, in the contracts' format, compared with those of the raw clips."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from live.base.arrays import Bool, Float64
from live.graph.motion_graph import MotionGraph
from live.graph.render_dance import RenderedDance
from live.graph.search.path_following import Targets
from live.graph.select.candidates import wrap_angle
from live.motion import quaternion
from live.motion.clip import read_clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.beat_chance import compare_with_chance
from live.motion.quality.body_contact import self_contacts
from live.motion.quality.metrics import (
    contact_slide_speeds,
    half_width,
    largest_around,
    largest_at_samples,
    mean_speed,
    motion_beats,
    random_changes,
    raw_p99,
    skating_frames,
    velocity_changes,
)
from live.motion.step_clip import StepClip


@dataclass(frozen=True)
class RawClips:
    """The source clips of a dance, played at its tempo and sampled like it."""

    steps: tuple[StepClip, ...]
    seconds: float
    """Length of a measure [s]."""
    rate: float

    @cached_property
    def sampled_clips(self) -> list[tuple[Float64, Bool]]:
        """Return joints (T, J, 3) [m] and contacts (T, 2) of each whole clip, lead-in included."""
        return [self._sample(step) for step in self.steps]

    @cached_property
    def traces(self) -> list[tuple[Float64, Float64]]:
        """Return the largest velocity change and acceleration at every sample, (T,) each."""
        return [largest_at_samples(position, self.rate) for position, _ in self.sampled_clips]

    @property
    def slide(self) -> Float64:
        """Return the speeds [m/s] of feet in contact, (n,)."""
        return np.concatenate(
            [contact_slide_speeds(position, contact, self.rate) for position, contact in self.sampled_clips]
        )

    def changes_by_joint(self, half: float) -> Float64:
        """Return the largest velocity change [m/s] of each joint within `half` s of random samples, (M, J)."""
        return random_changes(
            [velocity_changes(position, self.rate) for position, _ in self.sampled_clips], half, self.rate
        )

    def p99(self, half: float) -> tuple[float, float]:
        """Return p99 of the largest velocity change [m/s] and acceleration [m/s²] within `half` s of random samples."""
        change, acceleration = zip(*self.traces, strict=True)
        return raw_p99(change, half, self.rate), raw_p99(acceleration, half, self.rate)

    def _sample(self, step: StepClip) -> tuple[Float64, Bool]:
        stride = step.samples_per_measure / (self.seconds * self.rate)
        samples = np.arange(int((step.clip.sample_count - 1) / stride) + 1) * stride
        root, rotation, contact = read_clip(step.clip, samples)
        position, _ = forward_kinematics(root.astype(np.float64), quaternion.unit(rotation.astype(np.float64)))
        return position.astype(np.float64), contact


@dataclass(frozen=True)
class DanceMetrics:
    """Metrics of one dance and its source clips."""

    graph: MotionGraph
    dance: RenderedDance
    targets: Targets | None = None

    @cached_property
    def position(self) -> Float64:
        """Joints in stage coordinates [m], shape (T, J, 3)."""
        clip = self.dance.clip
        position, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
        return position.astype(np.float64)

    @cached_property
    def raw(self) -> RawClips:
        """The clips danced, and the other takes mixed in."""
        dance = self.dance
        nodes = np.unique(np.concatenate([dance.node, dance.take[dance.take_share > 0.0]]))
        clips = np.unique(self.graph.library.node_clip[nodes])
        steps = tuple(self.graph.library.clips[clip] for clip in clips)
        return RawClips(steps, float(dance.line_time[1]), dance.clip.sample_rate)

    @property
    def slide(self) -> Float64:
        """Return the speeds [m/s] of feet in contact, (n,)."""
        return contact_slide_speeds(self.position, self.dance.clip.contact, self.dance.clip.sample_rate)

    @cached_property
    def joins(self) -> tuple[Float64, Float64]:
        """Return the largest velocity change [m/s] and acceleration [m/s²] of any joint at each join, (K,) each."""
        rate, join = self.dance.clip.sample_rate, self.dance.join
        change, acceleration = largest_at_samples(self.position, rate)
        middle = join.mean(axis=1)
        return largest_around(change, middle, self.half, rate), largest_around(acceleration, middle, self.half, rate)

    @property
    def half(self) -> float:
        """Seconds examined before and after the middle of each join."""
        return half_width(self.graph.window * float(self.dance.line_time[1]))

    @property
    def annotated_offsets(self) -> Float64:
        """Return the display time of each clip's own beat minus the beat [s], shape (M, beats)."""
        library, dance = self.graph.library, self.dance
        first, last = library.node_first[dance.node], library.node_last[dance.node]
        own = np.array([library.clips[clip].samples_per_measure for clip in library.node_clip[dance.node]])
        place = np.arange(dance.beats_per_measure) / dance.beats_per_measure  # of each beat, in measures of the clip
        shown = dance.line_time[:-1, None] + place * (own / (last - first))[:, None] * dance.line_time[1]
        return np.asarray(shown - dance.beat_time[:-1].reshape(shown.shape), np.float64)

    def result(self) -> dict[str, Any]:
        """Return the metrics; null where nothing was measured. The caller adds `steps` and `missing`."""
        dance, rate = self.dance, self.dance.clip.sample_rate
        slide, skating = self.slide, skating_frames(self.position, rate)
        change, acceleration = self.joins
        raw_change, raw_acceleration = self.raw.p99(self.half) if len(change) else (0.0, 0.0)
        beats = compare_with_chance(dance.beat_time, [motion_beats(mean_speed(self.position, rate), rate)])
        path, heading = self._errors()
        return {
            "foot_slide_mean": float(slide.mean()) if len(slide) else None,
            "foot_slide_p99": float(np.percentile(slide, 99)) if len(slide) else None,
            "skating_ratio": float(skating.mean()) if len(skating) else None,
            "join_velocity_ratio": ratio(change, raw_change),
            "join_acceleration_ratio": ratio(acceleration, raw_acceleration),
            "beat_offset_ms": {
                "annotated": median_and_p95(self.annotated_offsets.reshape(-1)),
                "kinematic": median_and_p95(beats.offset),
                "kinematic_chance": median_and_p95(beats.chance_offset),
            },
            "beat_alignment": beats.alignment,
            "path_error_m": list_and_p95(path),
            "heading_error_deg": list_and_p95(heading),
            "overlaps": 0,
            "min_distance_m": None,
            "self_contact_ratio": float(self_contacts(self.position).mean()),
            "neighbour_contact_ratio": None,
            "hand_contact_ratio": None,
        }

    def _errors(self) -> tuple[list[float], list[float]]:
        """Return the errors at the measure lines: hips to their target [m], planned heading to the wanted one [°]."""
        if self.targets is None:
            return [], []
        dance = self.dance
        rows = np.minimum(np.round(dance.line_time[1:] * dance.clip.sample_rate).astype(int), len(self.position) - 1)
        place = np.hypot(*(self.position[rows, 0][:, (0, 2)] - self.targets.place[1:]).T)
        heading = np.degrees(np.abs(wrap_angle(dance.end[:, 2] - self.targets.heading[1:])))
        return place.tolist(), heading.tolist()


def ratio(joins: Float64, raw: float) -> float | None:
    """Return p99 over the joins (K,) divided by the raw clips' p99; None without joins or a reference."""
    return float(np.percentile(joins, 99) / raw) if len(joins) and raw > 0.0 else None


def median_and_p95(seconds: Float64) -> dict[str, float | None]:
    """Return median and p95 of |seconds|, in milliseconds."""
    size = np.abs(seconds) * 1e3
    return {
        "median": float(np.median(size)) if len(size) else None,
        "p95": float(np.percentile(size, 95)) if len(size) else None,
    }


def list_and_p95(values: Sequence[float]) -> dict[str, Any]:
    """Return the values and their p95."""
    return {"list": list(values), "p95": float(np.percentile(values, 95)) if len(values) else None}
