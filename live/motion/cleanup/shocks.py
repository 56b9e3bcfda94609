"""Shocks: frames at which a joint starts or stops faster than bodies can; what tracking faults look like (T161)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.source_motion import Float64
from live.motion.retarget.body_tracks import BodyTracks

Float = npt.NDArray[np.floating]

ACCELERATION: Final = 350.0
"""[m/s²]: of 50,000 frames of salsa at 60 Hz without fault the fastest has 280, the faults have 440 to 2,300."""
LEAST_KICK: Final = 0.06
"""Twice as far as a joint must be off its path [m] to count, however short a frame is."""
SLOW_KICK: Final = 0.25
"""The same where frames are long, so that `ACCELERATION` would forgive too much."""
SLOW_RATIO: Final = 3.0
"""And so many times the kick that 1 of 200 frames of the recording exceeds."""
TWIST: Final = np.radians(40.0)
TWIST_RATE: Final = np.radians(2000.0)
"""A joint's turn per frame may change by this [rad, rad/s]; wrists flick with 1,700 degrees per second."""


@dataclass(frozen=True, slots=True, eq=False)
class Shocks:
    """How hard each frame of a recording kicks each joint; first and last frame cannot be judged and are 0."""

    kick: Float64
    """Change of the way per frame, |p(t-1) - 2 p(t) + p(t+1)| [m], shape (T, B)."""
    twist: Float64
    """Change of the turn per frame relative to the parent [rad], shape (T, B)."""
    kick_limit: float
    """What is believed of a body at this frame rate [m]."""
    twist_limit: float

    @property
    def severity(self) -> Float64:
        """The larger of kick and twist over its limit: from 1 on it is a fault, shape (T, B)."""
        return np.maximum(self.kick / self.kick_limit, self.twist / self.twist_limit)


def find_shocks(tracks: BodyTracks, start: int = 0) -> Shocks:
    """Kicks and twists of every frame after `start` (frames before it are 0, as if nothing were there)."""
    kick = np.zeros(tracks.positions.shape[:2])
    twist = np.zeros_like(kick)
    if tracks.frame_count - start > 2:
        kick[start + 1 : -1] = np.linalg.norm(np.diff(tracks.positions[start:], 2, axis=0), axis=-1)
        turn = quaternion.mul(tracks.rotation[start + 1 :], quaternion.inverse(tracks.rotation[start:-1]))
        twist[start + 1 : -1] = turned_by(quaternion.mul(turn[1:], quaternion.inverse(turn[:-1])))
    usual = float(np.percentile(kick[start + 1 : -1], 99.5)) if tracks.frame_count - start > 2 else 0.0
    fast = ACCELERATION / tracks.rate**2
    limit = max(LEAST_KICK, min(fast, max(SLOW_KICK, SLOW_RATIO * usual)))
    return Shocks(kick, twist, limit, max(float(TWIST), float(TWIST_RATE) / tracks.rate))


def turned_by(rotation: Float) -> Float64:
    """Angle of unit quaternions [rad], 0 to pi, shape (...)."""
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(rotation[..., 1:], axis=-1), np.abs(rotation[..., 0])))
