"""Onset strength: a beat activation without training, the rises of all bands relative to their usual strength.

A fallback without weights: spectral flux (Dixon, Onset detection revisited, DAFx 2006) through a sigmoid. It does not
detect downbeats: the rises of the low bands replace them.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.features import BAND_COUNT

LOW_BANDS: Final = 6
"""Number of bands of the short window below about 160 Hz: bass drum, bass."""

MEMORY: Final = 0.004
"""Weight of each frame in the usual strength (time constant 3 s)."""


class OnsetActivation:
    """Beat activation from spectral flux alone."""

    def __init__(self) -> None:
        self.beat = np.zeros(1)
        self.downbeat = np.zeros(1)
        self.reset()

    def reset(self) -> None:
        """Reset the usual strength."""
        self._held = (0.0, 0.0)
        self._usual = 0.02
        self._spread = 0.02

    def step(self, features: npt.NDArray[np.float32]) -> int:
        """Process one frame's compressed bands and rises, shape (2 * BAND_COUNT,); return 1."""
        rises = features[BAND_COUNT:]
        flux = float(rises.mean())
        low = float(rises[:LOW_BANDS].mean())
        self._usual += MEMORY * (flux - self._usual)
        self._spread += MEMORY * (abs(flux - self._usual) - self._spread)
        height = (flux - self._usual) / (self._spread + 1e-3)
        self.beat[0], self.downbeat[0] = self._held  # the rise is steepest a frame before its moment comes
        beat = 1.0 / (1.0 + math.exp(3.0 - height))
        self._held = (beat, beat * min(max(low / (4.0 * flux + 1e-3), 0.0), 0.5))
        return 1
