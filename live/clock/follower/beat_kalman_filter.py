"""Kalman filter for beat time and period from observations with jitter.

The state is (time of a beat, period). The period varies a little from beat to beat. When the last innovations all
have the same sign, it may vary more, so that a drummer who pushes is followed and jitter is not (an adaptive filter
after Mehra, IEEE Trans. Automatic Control 15(2), 1970: innovations that are not white show that the model is too
stiff).
"""

import math
from typing import Final

from live.clock.timeline import Grid

JITTER: Final = 0.008
"""Standard deviation of an observation's time when its source is sure [s]; three times as much when it is not."""

PERIOD_JITTER: Final = 0.04
"""Standard deviation of an observation's period, relative."""

WANDER: Final = 0.001
"""Variation of the period from beat to beat, relative."""

BIAS_MEMORY: Final = 0.3
"""Weight of the newest innovation in their mean."""

BIAS_TOLERANCE: Final = 0.5
"""A mean innovation below this many standard deviations counts as chance."""

EXTRA_WANDER: Final = 0.05
"""Additional variation of the period for each standard deviation above, relative."""

GATE: Final = 3.5
GATE_MIN: Final = 0.045
GATE_BEATS: Final = 0.2
"""An observation is accepted within this many standard deviations, at least this many seconds, at most this many
beats."""


class BeatFilter:
    """One hypothesis of the beats. `update` returns whether an observation fits it."""

    def __init__(self, time: float, period: float, confidence: float, number: int = 0) -> None:
        """A beat at `time` [s] with its `number`, `period` [s] to the next."""
        self._time, self._period, self.number = time, period, number
        self._var_time = _noise(confidence) ** 2
        self._cov = 0.0
        self._var_period = (PERIOD_JITTER * period) ** 2
        self._bias = 0.0
        self._before = (time, period, self._var_time, 0.0, self._var_period, 0.0, number)
        self.updates = 1
        """Number of different beats accepted."""

    @property
    def grid(self) -> Grid:
        """The present estimate of the beats."""
        return Grid(self._time, self._period, self.number)

    def update(self, time: float, period: float, confidence: float) -> bool:
        """Process a beat at `time` [s], `period` [s] to the next; if it does not fit, return False and change nothing.

        An observation of the same beat as the last one replaces it.
        """
        steps = round((time - self._time) / self._period)
        if steps < 0:
            return True  # an older beat: nothing new
        again = steps == 0
        kept = self._state()
        if again:
            self._restore(self._before)
            steps = self._before_steps
        self._predict(steps)
        before = (*self._before,)
        if not again:
            self._before, self._before_steps = kept, steps
        error = time - self._time
        noise = _noise(confidence) ** 2
        spread = math.sqrt(self._var_time + noise)
        gate = min(max(GATE * spread, GATE_MIN), GATE_BEATS * self._period)
        if abs(error) > gate or abs(math.log(period / self._period)) > 0.15:
            self._before = before
            self._restore(kept)
            return False
        self._bias += BIAS_MEMORY * (error / spread - self._bias)
        excess = max(abs(self._bias) - BIAS_TOLERANCE, 0.0)
        self._var_period += (EXTRA_WANDER * excess * self._period) ** 2
        self._correct(error, noise)
        self._correct_period(period)
        self.updates += not again
        return True

    _before_steps = 0

    def _state(self) -> tuple[float, float, float, float, float, float, int]:
        return (
            self._time, self._period, self._var_time, self._cov, self._var_period, self._bias, self.number,
        )  # fmt: skip

    def _restore(self, state: tuple[float, float, float, float, float, float, int]) -> None:
        self._time, self._period, self._var_time, self._cov, self._var_period, self._bias, self.number = state

    def _predict(self, steps: int) -> None:
        for _ in range(min(steps, 64)):
            self._var_time += 2.0 * self._cov + self._var_period
            self._cov += self._var_period
            self._var_period += (WANDER * self._period) ** 2
        self._time += steps * self._period
        self.number += steps

    def _correct(self, error: float, noise: float) -> None:
        total = self._var_time + noise
        gain_time, gain_period = self._var_time / total, self._cov / total
        self._time += gain_time * error
        self._period += gain_period * error
        self._var_period -= gain_period * self._cov
        self._cov -= gain_time * self._cov
        self._var_time -= gain_time * self._var_time

    def _correct_period(self, period: float) -> None:
        error = period - self._period
        total = self._var_period + (PERIOD_JITTER * self._period) ** 2
        gain_time, gain_period = self._cov / total, self._var_period / total
        self._time += gain_time * error
        self._period += gain_period * error
        self._var_time -= gain_time * self._cov
        self._cov -= gain_period * self._cov
        self._var_period -= gain_period * self._var_period


def _noise(confidence: float) -> float:
    return JITTER * (3.0 - 2.0 * min(max(confidence, 0.0), 1.0))
