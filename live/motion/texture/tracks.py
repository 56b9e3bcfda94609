"""Tracks: a clip as degrees of freedom at 24 samples a second, three for each joint and three for the body's sway."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT
from live.motion.texture.bands import RATE, split_bands
from live.motion.texture.charts import Chart, choose_charts, euler_angles

Float = npt.NDArray[np.floating]
Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

SWAY: Final = JOINT_COUNT
"""The "joint" after the last one: where the hips are, to their left, up and forward [m]."""
SLOW: Final = 5
"""Bands of heading and sway that are kept: what is slower is the way itself, which is the sketch's."""
COLUMNS: Final = 3 * (JOINT_COUNT + 1)
"""Degrees of freedom of a clip."""


def columns_of(joints: Sequence[int]) -> Int64:
    """The columns of the degrees of freedom of `joints`."""
    return np.array([3 * joint + axis for joint in joints for axis in range(3)], np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Sampled:
    """A clip at `RATE`: hips (T, 3) [m] and rotations (T, J, 4), float64. The last sample holds the clip's end."""

    clip: Clip
    root: Float
    rotation: Float


def sample_clip(clip: Clip) -> Sampled:
    """The clip at `RATE` samples a second. Neighbouring samples are degrees apart: the chord stands for the arc."""
    last = clip.sample_count - 1
    count = int(np.ceil(last * RATE / clip.sample_rate - 1e-6)) + 1
    at = np.minimum(np.arange(count) * (clip.sample_rate / RATE), last)
    before = np.minimum(at.astype(np.int64), max(last - 1, 0))
    part = at - before
    after = np.minimum(before + 1, last)
    root = clip.root_position
    hips = root[before] * (1.0 - part[:, None]) + root[after] * part[:, None]
    a, b = clip.rotation[before], clip.rotation[after]
    weight = part.astype(np.float32)[:, None, None]
    sign = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, np.float32(-1.0), np.float32(1.0))
    rotation = a * (1.0 - weight) + b * (weight * sign)
    return Sampled(clip, hips.astype(np.float64), np.asarray(quaternion.unit(rotation.astype(np.float64))))


def charts_for(samples: Sequence[Sampled]) -> tuple[Chart, ...]:
    """Charts that hold all of these clips."""
    return choose_charts(np.concatenate([one.rotation for one in samples]))


def tracks_of(sampled: Sampled, charts: Sequence[Chart]) -> Float64:
    """All degrees of freedom (T, COLUMNS) [rad, m] of a clip.

    The heading and the sway are what is beside their slow course. The sway is where the hips are beside their slow
    way, in the axes of the hips' heading: dancers sway alike wherever they go.
    """
    out = np.empty((len(sampled.root), COLUMNS))
    for joint, chart in enumerate(charts):
        out[:, 3 * joint : 3 * joint + 3] = chart.angles(sampled.rotation[:, joint])
    out[:, 0] -= split_bands(out[:, 0], SLOW)[-1]
    out[:, 3 * SWAY :] = turned(sampled.root - _way(sampled.root), -headings(sampled.rotation[:, 0]))
    return out


def headings(hips: Float) -> Float64:
    """Headings [rad] (T,) of the hips' rotations (T, 4), about the vertical."""
    return np.asarray(np.unwrap(euler_angles(np.asarray(hips, np.float64), "YXZ")[..., 0]))


def turned(vectors: Float, heading: Float) -> Float64:
    """Vectors (T, 3) turned about the vertical by `heading` (T,)."""
    sine, cosine = np.sin(heading), np.cos(heading)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack((cosine * x + sine * z, y, -sine * x + cosine * z), axis=-1)


def _way(root: Float) -> Float64:
    """The slow way of the hips over the floor, (T, 3): lower than band `SLOW`; no height."""
    way = split_bands(root, SLOW)[-1]
    way[:, 1] = 0.0
    return np.asarray(way)
