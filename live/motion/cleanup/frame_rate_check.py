"""Suspicion of a frame rate that is too high: feet swing from step to step faster than legs can.

A leg swings like a pendulum. Walkers take about half a second for it, and sprinters at their top speed no less than
0.3 s, however long their steps are (Weyand et al., Faster top running speeds are achieved with greater ground forces,
not more rapid leg movements, J. Appl. Physiol. 89, 2000). In a recording that is played at twice its rate a swing takes
half of that. The time says more than speeds and accelerations, which jumps, size and noise change, too.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion.beats.dance_rhythm import gaussian_smooth
from live.motion.retarget.body_tracks import BodyTracks

SMOOTHING_S: Final = 0.02
"""Standard deviation of the smoothing of positions [s], against noise."""
MIN_PEAK: Final = 0.6
"""Least speed [m/s] that a swinging foot reaches."""
MIN_WAY: Final = 0.15
"""Least way [m] of a swing."""
EDGE_SHARE: Final = 0.3
"""A swing lasts while the foot is faster than this share of its peak."""
SHORTEST_SWING: Final = 0.28
"""Least median duration of swings [s]: recordings at their true rate have 0.32 and more, at twice their rate 0.26 and
less, also if noise of 1 cm is added and if the body is a third larger or a quarter smaller than was thought."""
MIN_SWINGS: Final = 6
"""With fewer swings nothing is said."""
MAX_SECONDS: Final = 120.0
"""Longest part of a recording that is looked at [s]."""


@dataclass(frozen=True, slots=True)
class RateSuspicion:
    """Why a frame rate is doubtful."""

    swing_s: float
    """Median duration of the feet's swings [s]."""
    rate: float
    """The doubtful rate [Hz]."""

    def __str__(self) -> str:
        return (
            f"at {self.rate:g} frames a second the feet swing from step to step in {self.swing_s:.2f} s, faster than "
            f"legs can; is the true rate {0.5 * self.rate:g} (fps)?"
        )


def suspect_frame_rate(tracks: BodyTracks, start: int = 0) -> RateSuspicion | None:
    """Return why the rate of a recording from frame `start` on is too high; None if it may be right."""
    feet = tracks.ankles[start : start + round(MAX_SECONDS * tracks.rate)]
    swings = np.concatenate([swing_durations(feet[:, side], tracks.rate) for side in (0, 1)])
    if len(swings) < MIN_SWINGS or np.median(swings) >= SHORTEST_SWING:
        return None
    return RateSuspicion(float(np.median(swings)), tracks.rate)


def swing_durations(foot: Float, rate: float) -> Float64:
    """Return the durations [s] of the swings of a foot (T, 3) at `rate` frames a second, in no particular order.

    The fastest moments come first; each takes the time around it in which the foot is faster than a share of it.
    """
    if len(foot) < 5:
        return np.zeros(0)
    smooth = np.stack([gaussian_smooth(column, SMOOTHING_S * rate) for column in np.asarray(foot).T], axis=1)
    speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=-1) * rate
    peaks = 1 + np.flatnonzero((speed[1:-1] > speed[:-2]) & (speed[1:-1] >= speed[2:]) & (speed[1:-1] > MIN_PEAK))
    taken = np.zeros(len(speed), np.bool_)
    found = []
    for peak in peaks[np.argsort(-speed[peaks], kind="stable")].tolist():
        if taken[peak]:
            continue
        edge = EDGE_SHARE * speed[peak]
        slow = np.flatnonzero(speed[:peak] <= edge)[-1:], peak + np.flatnonzero(speed[peak:] <= edge)[:1]
        if not (len(slow[0]) and len(slow[1])):
            continue  # it begins before the recording, or ends after it
        first, last = int(slow[0][0]), int(slow[1][0])
        taken[first : last + 1] = True
        if np.linalg.norm(smooth[last] - smooth[first]) >= MIN_WAY:
            begin = first + (edge - speed[first]) / (speed[first + 1] - speed[first])
            end = last - (edge - speed[last]) / (speed[last - 1] - speed[last])
            found.append((end - begin) / rate)
    return np.array(found, np.float64)
