"""StepLibrary: all step clips as flat arrays, one node per measure (T038-T042)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.posing.foot_lock import LEG_JOINTS
from live.motion.posing.pipeline import ClipStore, mean_pose
from live.motion.step_clip import StepClip

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class StepLibrary:
    """Clips one after another (S samples in all) and the measures in them (N nodes, C steps)."""

    steps: tuple[str, ...]
    """Names of the steps, the clusters of T041, in the order in which they first came."""
    clips: tuple[StepClip, ...]
    clip_root: Float32
    """Hips of all clips [m], shape (S, 3)."""
    clip_rotation: Float32
    """Local rotations of all clips, shape (S, J, 4)."""
    clip_contact: Bool
    """Left and right foot on the floor, shape (S, 2)."""
    store: ClipStore
    """The same clips, and the mean pose of each node, as the pose pipeline reads them."""
    leg_store: ClipStore
    """Of them the joints that the foot lock watches."""
    node_clip: Int32
    """Which of `clips` each node belongs to, shape (N,)."""
    node_step: Int32
    """Which of `steps` each node belongs to, shape (N,)."""
    node_measure: Int32
    """Measure of its step that the node holds, from 0, shape (N,)."""
    node_measures: Int32
    """Length of the node's step in measures, shape (N,)."""
    node_side: Int32
    """-1 for measures as they were made, 1 for their mirror images (T042), shape (N,)."""
    node_first: Float64
    """Sample (into S) at which the measure begins, shape (N,)."""
    node_last: Float64
    """Sample at which the measure ends, shape (N,)."""
    node_lead: Float64
    """Earliest sample of the node's clip: its lead-in reaches back to here, shape (N,)."""
    node_travel: Float64
    """Way of the hips over the measure in the clip's own axes (x, z) [m], shape (N, 2)."""
    beats_per_measure: int

    @property
    def node_count(self) -> int:
        """Number of nodes N."""
        return len(self.node_clip)

    def step_index(self, name: str) -> int | None:
        """Index of the step called `name` (case and underscores do not matter), None if there is none."""
        wanted = _plain(name)
        for index, step in enumerate(self.steps):
            if _plain(step) == wanted:
                return index
        return None

    def reach(self, step: int) -> float:
        """The longest way [m] that one measure of the step travels."""
        ways = np.hypot(*self.node_travel[self.node_step == step].T)
        return float(ways.max()) if len(ways) else 0.0

    def describe(self, node: int) -> str:
        """A node in words: step, measure of the step, direction, side."""
        clip = self.clips[self.node_clip[node]]
        parts = [clip.step]
        if clip.measures > 1:
            parts.append(f"{self.node_measure[node] + 1}/{clip.measures}")
        if clip.direction and clip.direction != "in place":
            parts.append(clip.direction)
        if clip.mirrored:
            parts.append("mirrored")
        return " ".join(parts)


def _plain(name: str) -> str:
    return " ".join(name.replace("_", " ").replace("-", " ").casefold().split())


def build_library(clips: Sequence[StepClip]) -> StepLibrary:
    """Join step clips into a library; ValueError if there is none or their metres differ."""
    if not clips:
        raise ValueError("no steps: a library needs at least one step")
    metres = sorted({clip.beats_per_measure for clip in clips})
    if len(metres) > 1:
        names = {beats: next(c.step for c in clips if c.beats_per_measure == beats) for beats in metres}
        raise ValueError(
            "steps of different metres cannot be danced together: "
            + ", ".join(f"{name!r} has {beats} beats a measure" for beats, name in names.items())
        )
    steps: list[str] = []
    rows: list[tuple[int, int, int, int, float, float, float]] = []
    total = 0
    for index, clip in enumerate(clips):
        if clip.step not in steps:
            steps.append(clip.step)
        for measure in range(clip.measures):
            first = total + clip.first + measure * clip.samples_per_measure
            last = min(first + clip.samples_per_measure, total + clip.clip.sample_count - 1.0)
            rows.append((index, steps.index(clip.step), measure, clip.measures, first, last, float(total)))
        total += clip.clip.sample_count
    root = np.concatenate([clip.clip.root_position for clip in clips]).astype(np.float32)
    # neighbours of one sign: the pose pipeline goes straight from one sample to the next
    rotation = np.concatenate([quaternion.continuous(clip.clip.rotation) for clip in clips]).astype(np.float32)
    node = np.array(rows, np.float64).T
    starts, ends = np.ascontiguousarray(node[4]), np.ascontiguousarray(node[5])
    mean = np.stack([mean_pose(rotation[int(a) : int(b) + 1]) for a, b in zip(starts, ends, strict=True)])
    return StepLibrary(
        steps=tuple(steps),
        clips=tuple(clips),
        clip_root=root,
        clip_rotation=rotation,
        clip_contact=np.concatenate([clip.clip.contact for clip in clips]),
        store=ClipStore.of(root, rotation, mean),
        leg_store=ClipStore.of(root, rotation[:, LEG_JOINTS]),
        node_clip=node[0].astype(np.int32),
        node_step=node[1].astype(np.int32),
        node_measure=node[2].astype(np.int32),
        node_measures=node[3].astype(np.int32),
        node_side=np.array([1 if clips[int(n)].mirrored else -1 for n in node[0]], np.int32),
        node_first=starts,
        node_last=ends,
        node_lead=np.ascontiguousarray(node[6]),
        node_travel=np.asarray(_at(root, ends) - _at(root, starts), np.float64)[:, (0, 2)],
        beats_per_measure=metres[0],
    )


def _at(root: Float32, sample: Float64) -> Float32:
    """Root positions at fractional samples, shape (N, 3)."""
    low = np.clip(np.floor(sample).astype(np.int64), 0, len(root) - 1)
    high = np.minimum(low + 1, len(root) - 1)
    t = (sample - low)[:, None]
    result: Float32 = ((1.0 - t) * root[low] + t * root[high]).astype(np.float32)
    return result


def window_samples(start: Float64, stop: Float64, count: int) -> Float64:
    """`count` evenly spaced samples from start to stop of each node, shape (N, count)."""
    t = np.linspace(0.0, 1.0, count)
    return np.asarray(start[:, None] * (1.0 - t) + stop[:, None] * t, np.float64)
