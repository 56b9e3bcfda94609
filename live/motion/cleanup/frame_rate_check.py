"""Suspicion of a frame rate that is too high: hips and feet accelerate as no dancer's do.

At twice the true rate everything is twice as fast and accelerates four times as much. Feet kick and land hard in any
jump, and hips are thrown about in some; but hips that are always as restless, with feet that are always as sharp, are a
recording played too fast. Calibrated on recordings of salsa, modern and Indian dance, a routine, and walks.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion.beats.dance_rhythm import gaussian_smooth
from live.motion.retarget.body_tracks import BodyTracks

SMOOTHING_S: Final = 0.02
"""Standard deviation of the smoothing of positions [s], against noise."""
FOOT_PERCENTILE: Final = 99.0
RESTLESS: Final = 17.0
"""Largest geometric mean of the two accelerations [m/s²] that a dancer reaches: recordings at their true rate have up
to 14.4, salsa at twice its rate 20 and more."""
MIN_SECONDS: Final = 2.0
"""Shorter recordings may be a single jump."""


@dataclass(frozen=True, slots=True)
class RateSuspicion:
    """Why a frame rate is doubtful."""

    feet: float
    """Acceleration of the feet in a hundredth of the time [m/s²]."""
    hips: float
    """Acceleration of the hips in half of the time [m/s²]."""
    rate: float
    """The doubtful rate [Hz]."""

    def __str__(self) -> str:
        return (
            f"at {self.rate:g} frames a second the hips accelerate at {self.hips:.0f} m/s² half of the time and the "
            f"feet at up to {self.feet:.0f}, which no dancer does; is the true rate {0.5 * self.rate:g} (fps)?"
        )


def suspect_frame_rate(tracks: BodyTracks, start: int = 0) -> RateSuspicion | None:
    """Return why the rate of a recording from frame `start` on is too high; None if it may be right."""
    hips = tracks.column("hips")
    if hips is None or tracks.frame_count - start < max(MIN_SECONDS * tracks.rate, 5):
        return None
    feet = float(np.percentile(_accelerations(tracks.ankles[start:], tracks.rate), FOOT_PERCENTILE))
    middle = float(np.median(_accelerations(tracks.positions[start:, hips, None], tracks.rate)))
    restless = math.sqrt(feet * middle)
    if restless <= RESTLESS:  # accelerations grow with the square of the rate
        return None
    return RateSuspicion(feet, middle, tracks.rate)


def _accelerations(points: Float, rate: float) -> Float64:
    """Accelerations of points (T, n, 3) after smoothing [m/s²], (T, n)."""
    frames, count, _ = points.shape
    columns = np.asarray(points, np.float64).reshape(frames, -1)
    smooth = np.stack([gaussian_smooth(column, SMOOTHING_S * rate) for column in columns.T], axis=1)
    second = np.gradient(np.gradient(smooth, axis=0), axis=0).reshape(frames, count, 3)
    return np.asarray(np.linalg.norm(second, axis=-1) * rate**2)
