"""Spectrum: a stream of samples of any rate and block size, cut into frames of band magnitudes."""

from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.bands import BAND_COUNT, BANDS, BASE_HOP, BASE_RATE, EARS, filters, window_length
from live.clock.tracking.feature_kernels import append, band_magnitudes, level_of
from live.clock.tracking.fft import Transform, fast_length

Samples = npt.NDArray[np.float32]

RATE_MIN_HZ: Final = 16_000.0
RATE_MAX_HZ: Final = 400_000.0


class Spectrum:
    """Collects samples until a frame is full and reads its bands; allocates nothing after it was made."""

    def __init__(self, sample_rate: float) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        if not RATE_MIN_HZ <= sample_rate <= RATE_MAX_HZ:
            raise ValueError(f"a sample rate of {sample_rate} Hz: {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g} expected")
        self.sample_rate = sample_rate
        self.hop = BASE_HOP * sample_rate / BASE_RATE
        """Samples per frame; not a whole number at most rates, and kept exactly."""
        self.bands = np.zeros(BAND_COUNT, np.float32)
        """Magnitudes of the newest frame, a full sine about 1, shape (BAND_COUNT,)."""
        self.bad_samples = 0
        """Samples replaced by 0, since the start."""
        self.level = 0.0
        """RMS of the newest frame, full scale = 1."""
        self.frames = 0
        """Frames read since the start."""
        self.fed = 0
        """Samples taken since the start."""
        lengths = [window_length(ear, sample_rate) for ear in EARS]
        self._history = np.zeros(max(lengths), np.float32)
        self._filters = [
            filters(ear, sample_rate, fast_length(length)) for ear, length in zip(EARS, lengths, strict=True)
        ]
        self._transforms = [
            Transform(np.hanning(length + 1)[:-1].astype(np.float32), kept.bins)
            for length, kept in zip(lengths, self._filters, strict=True)
        ]
        edges = np.cumsum((0, *BANDS))
        self._out = [self.bands[low:high] for low, high in pairwise(edges)]

    @property
    def next_end(self) -> int:
        """Samples that have to be taken before the next frame is full, counted from the start."""
        return int((self.frames + 1) * self.hop)

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame is full."""
        return self.next_end - self.fed

    def take(self, samples: Samples, start: int) -> int:
        """Take samples[start:], shape (n,), up to the end of the frame; returns how many were taken."""
        taken: int = min(self.wanted, samples.shape[0] - start)
        self.bad_samples += int(append(self._history, samples, start, taken))
        self.fed += taken
        return taken

    def read(self) -> None:
        """Read the frame that has just become full (`wanted` is 0) into `bands`."""
        self.level = level_of(self._history, int(self.hop))
        for transform, kept, out in zip(self._transforms, self._filters, self._out, strict=True):
            transform.read(self._history)
            band_magnitudes(transform.magnitude, kept.start, kept.offset, kept.weight, out)
        self.frames += 1
