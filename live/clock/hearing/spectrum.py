"""Spectrum: a stream of samples of any rate and block size, cut into frames of band magnitudes."""

from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.hearing.bands import BAND_COUNT, BANDS, BASE_HOP, BASE_RATE, EARS, filters, window_length
from live.clock.hearing.kernels import append, band_magnitudes, cut, level_of

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
        self._windows = [np.hanning(length + 1)[:-1].astype(np.float32) for length in lengths]
        self._cut = [np.zeros(length, np.float32) for length in lengths]
        self._spectrum = [np.zeros(length // 2 + 1, np.complex64) for length in lengths]
        self._filters = [filters(ear, sample_rate, length) for ear, length in zip(EARS, lengths, strict=True)]
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
        for index, window in enumerate(self._windows):
            cut(self._history, window, 0, self._cut[index])
            np.fft.rfft(self._cut[index], out=self._spectrum[index])  # type: ignore[arg-type] # its stub knows no complex64
            kept = self._filters[index]
            band_magnitudes(self._spectrum[index], kept.start, kept.offset, kept.weight, self._out[index])
        self.frames += 1
