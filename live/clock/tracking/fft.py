"""Windowed magnitude spectrum for one window length, with its tables and work arrays."""

import numpy as np
import numpy.typing as npt

from live.clock.tracking.fft_kernels import magnitudes

Floats = npt.NDArray[np.float32]

PRIMES = (2, 3, 5, 7, 11)
"""Prime factors of the length of a fast transform."""


def factors(number: int) -> list[int]:
    """Return `number` as a product of 4s and `PRIMES`, the 4s first; empty if it has other prime factors."""
    found = []
    for prime in (4, *PRIMES):
        while number % prime == 0:
            found.append(prime)
            number //= prime
    return found if number == 1 else []


def fast_length(least: int) -> int:
    """Return the smallest even number from `least` on for which the transform is fast."""
    length = least + least % 2
    while not factors(length // 2):
        length += 2
    return length


class MagnitudeTransform:
    """Windowed magnitudes of the newest samples; allocates nothing after its creation."""

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
        half = self.length // 2
        turns = np.exp(-2.0j * np.pi * np.arange(half) / half)
        halves = np.exp(-1.0j * np.pi * np.arange(half) / half)
        self._window = window
        self._radices = np.array(factors(half), np.int32)
        self._turn = turns.real.astype(np.float32), turns.imag.astype(np.float32)
        self._half = halves.real.astype(np.float32), halves.imag.astype(np.float32)
        self._work = np.zeros((4, half), np.float32)

    def compute(self, history: Floats) -> None:
        """Transform the newest W samples of history (n,), n >= W, into `magnitude`."""
        magnitudes(history, self._window, self._radices, *self._turn, *self._half, self._work, self.magnitude)
