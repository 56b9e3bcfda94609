"""How a dancer moves, as numbers that follow the moments: energy, size, speed, height of the hands, and tempo.

Tempo follows kinematic beats: dancers slow down on the beat, so feet, hands and hips repeat after one beat, two, four
and eight (as in `live.motion.beats.tempo_estimation` for recordings). Candidates are rated by the autocorrelation of
the last seconds, with a preference for dance tempi (Ellis 2007, "Beat Tracking by Dynamic Programming"); ratings are
smoothed over time, so that the octave does not jump.
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
WINDOW_S: Final = 12.0
"""Motion from which the tempo is found [s]."""
LEAST_S: Final = 4.0
"""Motion until a tempo is told [s]."""
INTERVAL_S: Final = 0.5
"""Time between two ratings [s]."""
BPM_RANGE: Final = (60.0, 200.0)
LIKELY_BPM: Final = 120.0
"""Likely tempo while no music is known [bpm]."""
OCTAVE_SD: Final = 0.2
"""Preference for tempi near the likely one: standard deviation in octaves."""
RATING_SHARE: Final = 0.15
"""Smoothing of ratings: share of a new one."""
JITTER_S: Final = 0.1
"""Time constant of the smoothing of what is rated [s]; beats are slower."""
DRIFT_S: Final = 1.0
"""Time constant of what is subtracted: slower changes are no beats [s]."""
STANDING: Final = 0.06
"""Energy below which there is no tempo [m/s]."""
_SIGNALS: Final = 3
"""Signals that are rated: speed of the feet, bounce of the hips, speed of the hands."""
_PERIOD: Final = RATE * 60.0 / np.exp(np.linspace(math.log(BPM_RANGE[0]), math.log(BPM_RANGE[1]), 301))
_OCTAVE: Final = np.log2(RATE * 60.0 / _PERIOD)
_REPEATS: Final = np.array([0.6, 1.0, 1.0, 1.0])
"""Weights of repeats after 1, 2, 4 and 8 beats."""
_NEAR: Final = 12
"""Candidates on each side of the preferred one among which the best rating counts: 5 %."""
_LEVEL_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * SMOOTHING_S))
_JITTER_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * JITTER_S))
_DRIFT_SHARE: Final = 1.0 - math.exp(-1.0 / (RATE * DRIFT_S))


class Movement:
    """How one body moves. Thread: one at a time."""

    def __init__(self) -> None:
        self.level: Float64 = np.zeros(len(LEVELS))
        """The numbers of `LEVELS`, smoothed, (4,)."""
        self.tempo = 0.0
        """Tempo [bpm]; 0 while none is known."""
        self._signal: Float64 = np.zeros((_SIGNALS, round(WINDOW_S * RATE)))
        self._smooth: Float64 = np.zeros(_SIGNALS)
        self._drift: Float64 = np.zeros(_SIGNALS)
        self._rating: Float64 = np.zeros(len(_PERIOD))
        self._count = 0

    def reset(self) -> None:
        """Begin anew after a gap; the numbers stay."""
        self._signal[:] = self._rating[:] = 0.0
        self._count, self.tempo = 0, 0.0

    def follow(self, measure: Float64, likely_bpm: float = LIKELY_BPM) -> None:
        """Take the next moment, see `BodyStream.measure`; `likely_bpm`: that of the music to which she may dance."""
        newest = self._count % self._signal.shape[1]
        shares = (_LEVEL_SHARE, _JITTER_SHARE, _DRIFT_SHARE) if self._count else (1.0, 1.0, 1.0)
        body.follow_movement(self.level, self._smooth, self._drift, self._signal, measure, newest, *shares)
        self._count += 1
        if self._count % round(INTERVAL_S * RATE) == 0 and self._count >= LEAST_S * RATE:
            self._rate(newest, likely_bpm)

    def _rate(self, newest: int, likely_bpm: float) -> None:
        if self.level[0] < STANDING:
            self.tempo = 0.0
            return
        rating = np.empty(len(_PERIOD))
        body.rate_periods(rating, self._signal, newest, _PERIOD, _REPEATS)
        self._rating += RATING_SHARE * (rating - self._rating)
        preference = np.exp(-0.5 * ((_OCTAVE - math.log2(likely_bpm)) / OCTAVE_SD) ** 2)
        likely = int(((self._rating + 1.0) * preference).argmax())
        first = max(likely - _NEAR, 0)
        best = first + int(self._rating[first : likely + _NEAR + 1].argmax())
        self.tempo = RATE * 60.0 / float(_PERIOD[best])
