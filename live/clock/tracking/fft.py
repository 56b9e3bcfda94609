"""Windowed magnitude spectrum for one window length, with its work arrays, by numpy's FFT."""

import math

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]

PRIMES = (2, 3, 5, 7, 11)
"""Prime factors of the length of a fast transform."""


def fast_length(least: int) -> int:
    """Return the smallest even number from `least` on whose half has no prime factors but `PRIMES`."""
    half = (least + 1) // 2
    while math.prod(PRIMES) ** half.bit_length() % half:
        half += 1
    return 2 * half


class MagnitudeTransform:
    """Windowed magnitudes of the newest samples; keeps no memory, but numpy computes in temporary double precision."""

    def __init__(self, window: Floats, bins: int) -> None:
        """window (W,); `bins`: number of bins, from 0 Hz on, to compute.

        Raises ValueError for more bins than there are.
        """
        self.length = fast_length(window.shape[0])
        """Length of the transform: the window is padded with zeros to it; bins lie sample_rate / length apart."""
        if not 0 < bins <= self.length // 2:
            raise ValueError(f"{bins} bins of {self.length // 2}")
        self.magnitude = np.zeros(bins, np.float32)
        """Magnitudes of the newest spectrum, shape (bins,)."""
        self._window = window
        self._padded = np.zeros(self.length, np.float32)
        self._spectrum = np.zeros(self.length // 2 + 1, np.complex64)

    def compute(self, history: Floats) -> None:
        """Transform the newest W samples of history (n,), n >= W, into `magnitude`."""
        count = self._window.shape[0]
        np.multiply(history[-count:], self._window, out=self._padded[:count])
        np.fft.rfft(self._padded, out=self._spectrum)  # type: ignore[arg-type] # its stub knows no complex64
        np.abs(self._spectrum[: self.magnitude.shape[0]], out=self.magnitude)
