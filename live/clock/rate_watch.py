"""RateWatch: whether a device delivers as many samples a second as it says."""

from typing import Final

import numpy as np

WINDOW: Final = 2.0
"""Seconds over which samples are counted."""

WINDOWS: Final = 3
"""So many windows in a row must say the same."""

TOLERANCE: Final = 0.03
"""Share by which a rate may seem wrong: callbacks come in bunches, and 44.1 and 48 kHz lie 9 % apart."""

AGREEMENT: Final = 0.02
"""Share by which the windows may differ; samples that are lost now and then make them differ more."""

RATES: Final = np.array([
    8_000.0, 11_025.0, 16_000.0, 22_050.0, 24_000.0, 32_000.0, 44_100.0, 48_000.0, 88_200.0, 96_000.0, 176_400.0,
    192_000.0,
])  # fmt: skip
"""Rates that devices have [Hz]."""


class RateWatch:
    """Counts samples against the clock, and tells the true rate when it is not the one that was promised."""

    def __init__(self, sample_rate: float) -> None:
        self.sample_rate = sample_rate
        """The rate that holds [Hz]."""
        self._since: tuple[float, float] | None = None
        self._found: list[float] = []

    def observe(self, frame: float, time: float) -> float | None:
        """Frame number `frame` was there at `time` [s]; returns the true rate [Hz] if it is another one, else None."""
        if self._since is None:
            self._since = (frame, time)
            return None
        frames, seconds = frame - self._since[0], time - self._since[1]
        if seconds < WINDOW:
            return None
        self._since = (frame, time)
        rate = frames / seconds
        if seconds > 2.0 * WINDOW or abs(rate / self.sample_rate - 1.0) <= TOLERANCE:
            self._found.clear()  # as promised, or the machine stood still, which says nothing
            return None
        self._found = [*self._found[1 - WINDOWS :], rate]
        low, high = min(self._found), max(self._found)
        if len(self._found) < WINDOWS or high > low * (1.0 + AGREEMENT):
            return None
        self._found.clear()
        rate = float(np.median([low, rate, high]))
        nearest = float(RATES[np.argmin(np.abs(np.log(RATES / rate)))])
        self.sample_rate = nearest if abs(nearest / rate - 1.0) <= TOLERANCE else rate
        return self.sample_rate
