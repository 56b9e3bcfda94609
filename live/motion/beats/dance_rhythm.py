"""Rhythm features of a dance: foot speed, landings, bounce of the hips, and motion beats."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

Int = npt.NDArray[np.int64]

SPEED_SMOOTHING: Final = 0.033
"""Standard deviation of the smoothing of speeds [s]."""
BEAT_SMOOTHING: Final = 5.0 / 60.0
"""The same for the mean joint speed whose minima are motion beats [s]: 5 frames at 60 Hz, as in Bailando."""


@dataclass(frozen=True, slots=True, eq=False)
class Rhythm:
    """Signals of one clip, one value per sample."""

    rate: float
    """Samples per second."""
    foot_speed: Float64
    """Sum of both feet's speeds, each that of the slower end of the foot [m/s], shape (T,)."""
    foot_deceleration: Float64
    """Deceleration of the feet [m/s²], shape (T,): high where a step lands."""
    bounce: Float64
    """Vertical speed of the hips [m/s], shape (T,)."""
    contact_times: Float64
    """Times at which a foot comes into contact [s], both feet, ascending."""
    motion_beats: Float64
    """Minima of the smoothed mean joint speed [s] (Bailando's kinematic beats)."""

    @property
    def seconds(self) -> float:
        """Length of the clip [s]."""
        return self.foot_speed.size / self.rate


def find_rhythm(clip: Clip) -> Rhythm:
    """Return the signals of a clip of at least five samples."""
    rate = clip.sample_rate
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    speeds = np.linalg.norm(np.gradient(positions, axis=0), axis=-1) * rate
    ends = [[SKELETON.index(side + joint) for joint in ("Foot", "Toes")] for side in ("left", "right")]
    feet = [gaussian_smooth(speeds[:, pair].min(axis=1), SPEED_SMOOTHING * rate) for pair in ends]
    falls = np.sum([np.maximum(0.0, -np.gradient(foot) * rate) for foot in feet], axis=0)
    landed = np.flatnonzero((np.diff(clip.contact.astype(np.int8), axis=0) > 0).any(axis=1)) + 1
    mean = gaussian_smooth(speeds.mean(axis=1), BEAT_SMOOTHING * rate)
    return Rhythm(
        rate=rate,
        foot_speed=np.asarray(feet[0] + feet[1]),
        foot_deceleration=np.asarray(falls),
        bounce=gaussian_smooth(np.gradient(positions[:, 0, 1]) * rate, SPEED_SMOOTHING * rate),
        contact_times=landed / rate,
        motion_beats=_minima(mean) / rate,
    )


def gaussian_smooth(values: Float, deviation: float) -> Float64:
    """Return a signal (T,) smoothed by a Gaussian of `deviation` samples; the end values are repeated."""
    half = max(1, round(4.0 * deviation))
    kernel = np.exp(-0.5 * (np.arange(-half, half + 1) / max(deviation, 1e-6)) ** 2)
    return np.convolve(np.pad(np.asarray(values, np.float64), half, mode="edge"), kernel / kernel.sum(), mode="valid")


def _minima(values: Float) -> Int:
    return np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] <= values[2:])) + 1
