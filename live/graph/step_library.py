"""Step library: all step clips as flat arrays, one node per measure (T038-T042)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int8, Int32
from live.base.body.hand_shapes import AUTO, NO_SHAPE, shape_index
from live.graph.mean_poses import mean_poses
from live.graph.storage_kernels import align_signs
from live.motion.pose.foot_lock import LEG_JOINTS, foot_heights
from live.motion.pose.mood_examples import learnt_ends
from live.motion.pose.mood_pose import PARAMETRIC, MoodEnds
from live.motion.pose.pose_pipeline import ClipStore
from live.motion.step_clip import StepClip


@dataclass(frozen=True, slots=True, eq=False)
class StepLibrary:
    """Concatenated clips (C clips, S samples in all) and their measures (N nodes)."""

    steps: tuple[str, ...]
    """Names of the steps, the clusters of T041, in order of first appearance."""
    clips: tuple[StepClip, ...]
    clip_root: Float32
    """Hips of all clips [m], shape (S, 3)."""
    clip_rotation: Float32
    """Local rotations of all clips, shape (S, J, 4)."""
    clip_contact: Bool
    """Left and right foot on the floor, shape (S, 2)."""
    clip_height: Float32
    """Soles of the left and right foot over the floor [m], shape (S, 2)."""
    clip_start: Float64
    """First sample (into S) of each clip, shape (C,)."""
    clip_measure: Float64
    """Samples of a measure of each clip, shape (C,)."""
    store: ClipStore
    """The same clips, and the mean pose of each node, in the format of the pose pipeline."""
    leg_store: ClipStore
    """The joints of the clips that the foot lock needs."""
    node_clip: Int32
    """Index in `clips` of each node, shape (N,)."""
    node_step: Int32
    """Index in `steps` of each node, shape (N,)."""
    node_measure: Int32
    """Index of the node's measure in its step, from 0, shape (N,)."""
    node_measures: Int32
    """Length of the node's step in measures, shape (N,)."""
    node_side: Int32
    """-1 for original measures, 1 for mirrored ones (T042), shape (N,)."""
    node_first: Float64
    """Sample (into S) at which the measure begins, shape (N,)."""
    node_last: Float64
    """Sample at which the measure ends, shape (N,)."""
    node_lead: Float64
    """Earliest sample of the node's clip, where its lead-in begins, shape (N,)."""
    node_travel: Float64
    """Displacement of the hips over the measure in the clip's own axes (x, z) [m], shape (N, 2)."""
    node_hands: Int8
    """Shapes of the left and the right hand (`live.base.body.hand_shapes`) in each quarter of a beat of the node's
    measure, NO_SHAPE where the step says none, shape (N, 4 beats_per_measure, 2)."""
    beats_per_measure: int
    moods: MoodEnds = PARAMETRIC
    """The ends of the moods, learnt from clips that are examples where there are some (T143)."""
    refused: Mapping[str, str] = field(default_factory=dict)
    """Steps that were left out, by name, and why."""

    @property
    def node_count(self) -> int:
        """Number of nodes N."""
        return len(self.node_clip)

    @property
    def joined_clips(self) -> tuple[StepClip, ...]:
        """The clips that joins lead to, see `unjoined`."""
        return tuple(clip for clip in self.clips if not clip.unjoined)

    @property
    def unjoined(self) -> Bool:
        """Whether no join leads to a node, shape (N,): those of variations, which are only mixed into their steps
        (T142), and those of examples of moods (T143)."""
        return np.array([clip.unjoined for clip in self.clips], np.bool_)[self.node_clip]

    @property
    def node_variation(self) -> Bool:
        """Whether a node is of a variation (T142), shape (N,)."""
        return np.array([clip.variation > 0 for clip in self.clips], np.bool_)[self.node_clip]

    def step_index(self, name: str) -> int | None:
        """Return the index of the step called `name` (case and underscores do not matter), None if there is none."""
        wanted = plain_name(name)
        for index, step in enumerate(self.steps):
            if plain_name(step) == wanted:
                return index
        return None

    def samples_behind(self, sample: Float64, share: Float64) -> Float64:
        """Return the samples in `share` (A,) of a measure before each `sample` (K, A), as far as its clip goes back."""
        clip = np.searchsorted(self.clip_start, sample, side="right") - 1
        return np.clip(share * self.clip_measure[clip], 0.0, sample - self.clip_start[clip])

    def refusal(self, name: str) -> str | None:
        """Return why the step called `name` was left out, None if it was not."""
        wanted = plain_name(name)
        return next((why for step, why in self.refused.items() if plain_name(step) == wanted), None)

    def max_travel(self, step: int) -> float:
        """Return the longest distance [m] that one measure of the step travels."""
        ways = np.hypot(*self.node_travel[self.node_step == step].T)
        return float(ways.max()) if len(ways) else 0.0

    def describe(self, node: int) -> str:
        """Return a text for a node: step, measure of the step, direction, side."""
        clip = self.clips[self.node_clip[node]]
        parts = [clip.step]
        if clip.measures > 1:
            parts.append(f"{self.node_measure[node] + 1}/{clip.measures}")
        if clip.direction and clip.direction != "in place":
            parts.append(clip.direction)
        if clip.mirrored:
            parts.append("mirrored")
        return " ".join(parts)


def plain_name(name: str) -> str:
    """Return a step's name in the form for comparison: casefolded, with single blanks for hyphens and underscores."""
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def build_library(clips: Sequence[StepClip], refused: Mapping[str, str] | None = None) -> StepLibrary:
    """Join step clips into a library; ValueError if there is none or their metres differ.

    `refused`: steps that were left out, and why.
    """
    if not clips:
        raise ValueError("no steps: a library needs at least one step")
    metres = sorted({clip.beats_per_measure for clip in clips})
    if len(metres) > 1:
        names = {beats: next(c.step for c in clips if c.beats_per_measure == beats) for beats in metres}
        raise ValueError(
            "steps of different metres cannot be danced together: "
            + ", ".join(f"{name!r} has {beats} beats a measure" for beats, name in names.items())
        )
    steps: dict[str, int] = {}
    rows: list[tuple[int, int, int, int, float, float, float]] = []
    starts = np.cumsum([0, *(clip.clip.sample_count for clip in clips)])
    for index, clip in enumerate(clips):
        step, begin = steps.setdefault(clip.step, len(steps)), float(starts[index])
        for measure in range(clip.measures):
            first = begin + clip.first + measure * clip.samples_per_measure
            last = min(first + clip.samples_per_measure, begin + clip.clip.sample_count - 1.0)
            rows.append((index, step, measure, clip.measures, first, last, begin))
    root = np.concatenate([clip.clip.root_position for clip in clips], dtype=np.float32)
    rotation = np.concatenate([clip.clip.rotation for clip in clips], dtype=np.float32)
    # sign-consistent quaternions: the pose pipeline interpolates linearly between samples and between clips
    align_signs(rotation, starts)
    node = np.array(rows, np.float64).T
    begins, ends = np.ascontiguousarray(node[4]), np.ascontiguousarray(node[5])
    legs = ClipStore.of(root, np.take(rotation, LEG_JOINTS, axis=1))
    mean = mean_poses(rotation, begins.astype(np.int64), ends.astype(np.int64))
    return StepLibrary(
        steps=tuple(steps),
        clips=tuple(clips),
        clip_root=root,
        clip_rotation=rotation,
        clip_contact=np.concatenate([clip.clip.contact for clip in clips]),
        clip_height=foot_heights(legs),
        clip_start=starts[:-1].astype(np.float64),
        clip_measure=np.array([clip.samples_per_measure for clip in clips], np.float64),
        store=ClipStore.of(root, rotation, mean),
        leg_store=legs,
        node_clip=node[0].astype(np.int32),
        node_step=node[1].astype(np.int32),
        node_measure=node[2].astype(np.int32),
        node_measures=node[3].astype(np.int32),
        node_side=np.array([1 if clips[int(n)].mirrored else -1 for n in node[0]], np.int32),
        node_first=begins,
        node_last=ends,
        node_lead=np.ascontiguousarray(node[6]),
        node_travel=travel_of(root, begins, ends),
        node_hands=np.concatenate([shapes_of(clip) for clip in clips]),
        beats_per_measure=metres[0],
        moods=learnt_ends(clips),
        refused=dict(refused or {}),
    )


def joined_library(first: StepLibrary, second: StepLibrary) -> StepLibrary:
    """Return the clips of `first` followed by those of `second`, as `build_library` joins all of them.

    Nodes, clips and steps of `first` keep their indices; no mutable data is shared. ValueError if the metres differ.
    """
    if first.beats_per_measure != second.beats_per_measure:
        raise ValueError(
            f"{second.steps[0]!r} has {second.beats_per_measure} beats a measure, "
            f"the library it should join has {first.beats_per_measure}"
        )
    steps = {name: index for index, name in enumerate(first.steps)}
    number = np.array([steps.setdefault(name, len(steps)) for name in second.steps], np.int32)
    samples = float(len(first.clip_root))

    def both(name: str, more: float = 0) -> Any:
        one, other = getattr(first, name), getattr(second, name)
        return np.concatenate([one, other + one.dtype.type(more) if more else other])

    root, rotation = both("clip_root"), both("clip_rotation")
    legs = np.concatenate([first.leg_store.rotation, second.leg_store.rotation])
    return StepLibrary(
        steps=tuple(steps),
        clips=first.clips + second.clips,
        clip_root=root,
        clip_rotation=rotation,
        clip_contact=both("clip_contact"),
        clip_height=both("clip_height"),
        clip_start=both("clip_start", samples),
        clip_measure=both("clip_measure"),
        store=ClipStore(root, rotation, np.concatenate([first.store.mean, second.store.mean])),
        leg_store=ClipStore(root, legs, first.leg_store.mean),
        node_clip=both("node_clip", len(first.clips)),
        node_step=np.concatenate([first.node_step, number[second.node_step]]),
        node_measure=both("node_measure"),
        node_measures=both("node_measures"),
        node_side=both("node_side"),
        node_first=both("node_first", samples),
        node_last=both("node_last", samples),
        node_lead=both("node_lead", samples),
        node_travel=both("node_travel"),
        node_hands=both("node_hands"),
        beats_per_measure=first.beats_per_measure,
        moods=learnt_ends(first.clips + second.clips),
        refused={step: why for step, why in first.refused.items() if step not in second.steps},
    )


SHAPE_PARTS: Final = 4
"""Hand shapes may change so often in a beat."""


def shapes_of(clip: StepClip) -> Int8:
    """Return the hand shapes of each measure of a step, as `StepLibrary.node_hands` has them."""
    shapes = np.full((SHAPE_PARTS * clip.beats, 2), NO_SHAPE, np.int8)
    for beat, *words in clip.hands:
        found = [shape_index(word or AUTO) for word in words]
        shapes[round(SHAPE_PARTS * beat) :] = [NO_SHAPE if index is None else index for index in found]
    return shapes.reshape(clip.measures, -1, 2)


def travel_of(root: Float32, first: Float64, last: Float64) -> Float64:
    """Return the displacement of the hips (x, z) [m] between the samples `first` and `last` (N,), shape (N, 2)."""
    return np.asarray(_at(root, last) - _at(root, first), np.float64)[:, (0, 2)]


def _at(root: Float32, sample: Float64) -> Float32:
    """Return root positions at fractional samples, shape (N, 3)."""
    low = np.clip(np.floor(sample).astype(np.int64), 0, len(root) - 1)
    high = np.minimum(low + 1, len(root) - 1)
    t = (sample - low)[:, None]
    result: Float32 = ((1.0 - t) * root[low] + t * root[high]).astype(np.float32)
    return result


def window_samples(start: Float64, stop: Float64, count: int) -> Float64:
    """Return `count` evenly spaced samples from start to stop of each node, shape (N, count)."""
    t = np.linspace(0.0, 1.0, count)
    return np.asarray(start[:, None] * (1.0 - t) + stop[:, None] * t, np.float64)
