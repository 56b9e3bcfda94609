"""Measures of whole recordings: their poses on the beat, and how alike any two of them are (K003)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.graph.build.metric import FlatClouds, Metric, joint_weights, window_weights
from live.graph.build.transitions import posed
from live.graph.step_library import window_samples
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.pose.pose_pipeline import ClipStore

POSES_PER_BEAT: Final = 4
"""Poses per beat that are compared."""
MAX_MEASURES: Final = 6000
"""Most measures of one vocabulary: all are compared with all (three hours at 130 bpm)."""
_ROWS: Final = 512


@dataclass(frozen=True, slots=True, eq=False)
class Measures:
    """M measures of some recordings, in order, K poses each."""

    recording: Int32
    """Index of each one's recording, (M,)."""
    number: Int32
    """Number in its recording, from 0, (M,)."""
    pose: Float64
    """World positions of the joints from the first beat to the end of the measure [m], (M, K, J, 3)."""
    contact: Bool
    """Left and right foot on the floor, (M, K, 2)."""
    seconds: Float64
    """Length of each measure [s], (M,)."""
    beats: int
    """Beats per measure."""

    def __len__(self) -> int:
        return len(self.recording)

    @property
    def follows(self) -> Bool:
        """Whether each measure follows the one before it in the same recording, (M,)."""
        same = np.diff(self.recording, prepend=-1) == 0
        return np.asarray(same & (np.diff(self.number, prepend=-2) == 1))


def measures_of(clips: Sequence[Clip], lines: Sequence[Float64], beats: int) -> Measures:
    """Return the measures of recordings between their measure `lines` [s]; ValueError if there are too many."""
    parts = [_measures(number, clip, line, beats) for number, (clip, line) in enumerate(zip(clips, lines, strict=True))]
    total = sum(len(line) - 1 for line in lines)
    if total > MAX_MEASURES:
        raise ValueError(f"{total} measures; at most {MAX_MEASURES} can be compared with each other")
    recording, number, pose, contact, seconds = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Measures(recording, number, pose, contact, seconds, beats)


def _measures(number: int, clip: Clip, lines: Float64, beats: int) -> tuple[Int32, Int32, Float64, Bool, Float64]:
    count = max(len(lines) - 1, 0)
    at = lines * clip.sample_rate
    samples = window_samples(at[:-1], at[1:], POSES_PER_BEAT * beats + 1)
    store = ClipStore.of(clip.root_position, quaternion.align_signs(clip.rotation).astype(np.float32))
    near = np.clip(np.rint(samples).astype(np.int64), 0, clip.sample_count - 1)
    return (
        np.full(count, number, np.int32), np.arange(count, dtype=np.int32), posed(store, samples), clip.contact[near],
        np.diff(lines),
    )  # fmt: skip


def measure_distances(measures: Measures) -> Float32:
    """Return the distance of any two measures [m], shape (M, M): of all their poses at the same phases.

    It is the root of the weighted mean squared distance of the joints after the rigid 2D motion that brings one measure
    as a whole nearest to the other (K001-K003). So places on the stage do not matter; ways and turns do.
    """
    count = measures.pose.shape[1]
    flat = FlatClouds.of(measures.pose, Metric(joint_weights(), window_weights(count, 0.0)))
    out = np.empty((len(measures), len(measures)), np.float32)
    for begin in range(0, len(measures), _ROWS):
        rows = slice(begin, begin + _ROWS)
        alike = np.abs(flat.floor[rows].conj() @ flat.floor.T) + flat.height[rows] @ flat.height.T
        out[rows] = np.sqrt(np.maximum(flat.size[rows, None] + flat.size - 2.0 * alike, 0.0))
    return np.minimum(out, out.T)
