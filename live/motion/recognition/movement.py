"""How a dancer moves, as numbers that follow the moments: energy, size, speed, height of the hands, and tempo.

Tempo follows kinematic beats: dancers slow down on the beat, so feet, hands and hips repeat after one beat, two and
four (as in `live.motion.beats.tempo_estimation` for recordings). Candidates are rated by the autocorrelation of
the last seconds, with a preference for dance tempi (Ellis 2007, "Beat Tracking by Dynamic Programming"); ratings are
smoothed over time, so that the octave does not jump. A tempo is told when it stands out among all candidates and has
stayed for a while; otherwise the last one that was told is kept.
"""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.recognition import gesture_kernels as body
from live.motion.recognition.body_stream import RATE
from live.motion.recognition.recognition_names import LEVELS

SMOOTHING_S: Final = 0.4
"""Time constant of these numbers [s]."""
MEMORY_S: Final = 12.0
"""Time constant of the motion from which the tempo is found [s]."""
LONGEST_LAG_S: Final = 4.1
"""Longest time after which it is looked for again [s]: four beats at 60 bpm."""
LEAST_S: Final = 4.0
"""Motion until a tempo is told [s]."""
INTERVAL_S: Final = 0.5
"""Time between two ratings [s]."""
BPM_RANGE: Final = (60.0, 200.0)
LIKELY_BPM: Final = 120.0
"""Likely tempo while no music is known [bpm]."""
OCTAVE_SD: Final = 0.2
"""Preference for tempi near the likely one: standard deviation in octaves."""
RATING_SHARE: Final = 0.1
"""Smoothing of ratings: share of a new one."""
JITTER_S: Final = 0.1
"""Time constant of the smoothing of what is rated [s]; beats are slower."""
DRIFT_S: Final = 1.0
"""Time constant of what is subtracted: slower changes are no beats [s]."""
STANDING: Final = 0.06
"""Energy below which there is no tempo [m/s]."""
SURE: Final = 0.6
"""How far the best rating stands out among all [standard deviations] if the tempo is sure, …"""
STEADY: Final = 8
"""… and for how many ratings it has stayed, …"""
SAME: Final = 0.02
"""… within this share."""
_SIGNALS: Final = 3
"""Signals that are rated: speed of the feet, bounce of the hips, speed of the hands."""
_PERIOD: Final = RATE * 60.0 / np.exp(np.linspace(math.log(BPM_RANGE[0]), math.log(BPM_RANGE[1]), 301))
_REPEATS: Final = np.array([0.5, 1.0, 1.0, 0.0])
"""Weights of repeats after 1, 2, 4 and 8 beats; nobody keeps a tempo so well that eight would tell more."""
_NEAR: Final = 12
"""Candidates on each side of the preferred one among which the best rating counts: 5 %."""
_LEVEL_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * SMOOTHING_S))
_JITTER_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * JITTER_S))
_DRIFT_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * DRIFT_S))
_REPEAT_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * MEMORY_S))


class Movement:
    """How one body moves. Thread: one at a time."""

    def __init__(self) -> None:
        self.level: Float64 = np.zeros(len(LEVELS))
        """The numbers of `LEVELS`, smoothed, (4,)."""
        self.tempo = 0.0
        """The last sure tempo [bpm]; 0 while none is known."""
        lags = round(LONGEST_LAG_S * RATE)
        self._signal: Float64 = np.zeros((_SIGNALS, lags))
        self._repeat: Float64 = np.zeros((_SIGNALS, lags))
        self._smooth: Float64 = np.zeros(_SIGNALS)
        self._drift: Float64 = np.zeros(_SIGNALS)
        self._rating: Float64 = np.zeros(len(_PERIOD))
        self._rated, self._steady = 0.0, 0
        """The best rated tempo [bpm], and for how many ratings it has stayed."""
        self._count = 0

    def reset(self) -> None:
        """Begin anew after a gap; the numbers stay."""
        self._signal[:] = self._repeat[:] = self._rating[:] = 0.0
        self._rated, self._steady = 0.0, 0
        self._count, self.tempo = 0, 0.0

    def follow(self, measure: Float64, likely_bpm: float = LIKELY_BPM) -> None:
        """Take the next moment, see `BodyStream.measure`; `likely_bpm`: that of the music to which she may dance."""
        newest = self._count % self._signal.shape[1]
        shares = (_LEVEL_SHARE, _JITTER_SHARE, _DRIFT_SHARE) if self._count else (1.0, 1.0, 1.0)
        body.follow_movement(
            self.level, self._smooth, self._drift, self._signal, self._repeat, measure, newest, *shares, _REPEAT_SHARE
        )
        self._count += 1
        if self._count % round(INTERVAL_S * RATE) == 0 and self._count >= LEAST_S * RATE:
            self._rate(likely_bpm)

    def _rate(self, likely_bpm: float) -> None:
        if self.level[0] < STANDING:
            self.tempo, self._steady = 0.0, 0
            return
        likely = RATE * 60.0 / likely_bpm
        best, far = body.rate_periods(
            self._rating, self._repeat, _PERIOD, _REPEATS, RATING_SHARE, likely, OCTAVE_SD, _NEAR
        )
        bpm = RATE * 60.0 / best
        if abs(bpm - self._rated) <= SAME * self._rated:
            self._steady += 1
        else:
            self._rated, self._steady = bpm, 0
        if self._steady >= STEADY and far >= SURE:
            self.tempo = bpm
