"""Audio features: magnitudes in logarithmic frequency bands, from an audio stream of any rate and block size.

Windows are the same length in seconds at every sample rate and filters are defined in Hz, so one trained network
serves all rates without a resampler (filters spaced by a logarithm: Böck and Schedl,
Enhanced beat tracking with context-aware neural networks, DAFx 2011).
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.feature_kernels import append, band_magnitudes, level_of
from live.clock.tracking.fft import MagnitudeTransform, fast_length

BASE_RATE: Final = 44_100.0
BASE_HOP: Final = 512
HOP: Final = BASE_HOP / BASE_RATE
"""Seconds from one frame to the next, at any sample rate."""


@dataclass(frozen=True, slots=True)
class AnalysisWindow:
    """One analysis window and its bands."""

    window: int
    """Length in samples at 44.1 kHz."""
    low_hz: float
    high_hz: float
    per_octave: int
    """Bands per octave, limited by the window's resolution."""
    coarse_hz: float
    """From this frequency on there are half as many."""
    lag: int
    """Number of frames back to the reference of a band's rise."""


ANALYSIS_WINDOWS: Final = (
    AnalysisWindow(window=2048, low_hz=32.0, high_hz=16_000.0, per_octave=12, coarse_hz=3000.0, lag=2),
    AnalysisWindow(window=4096, low_hz=60.0, high_hz=1600.0, per_octave=12, coarse_hz=1e9, lag=4),
)
"""The short window is for drums and attacks, the long one for pitches."""


def band_centres(ear: AnalysisWindow) -> npt.NDArray[np.float64]:
    """Return the frequencies [Hz] of its bands, shape (bands + 2,): the first and last are only the outer edges."""
    resolution = BASE_RATE / ear.window
    found = [ear.low_hz]
    while found[-1] < ear.high_hz:
        last = found[-1]
        per_octave = ear.per_octave if last < ear.coarse_hz else ear.per_octave / 2
        found.append(max(last * 2.0 ** (1.0 / per_octave), last + resolution))
    return np.array([max(found[0] - resolution, 1.0), *found])


BANDS_PER_WINDOW: Final = tuple(band_centres(ear).size - 2 for ear in ANALYSIS_WINDOWS)
"""Number of bands of each window type."""

BAND_COUNT: Final = sum(BANDS_PER_WINDOW)
LAGS: Final = np.repeat(np.array([ear.lag for ear in ANALYSIS_WINDOWS], np.int32), BANDS_PER_WINDOW)
"""Per band, number of frames back to the reference of its rise, shape (BAND_COUNT,)."""


def window_length(ear: AnalysisWindow, sample_rate: float) -> int:
    """Return the window length in samples at `sample_rate` [Hz]: as many seconds as at 44.1 kHz."""
    return round(ear.window * sample_rate / BASE_RATE)


@dataclass(frozen=True, slots=True, eq=False)
class Filters:
    """Triangular filters over a spectrum's magnitudes, stored as their non-zero parts."""

    start: npt.NDArray[np.int32]
    """First bin of each band, shape (bands,)."""
    offset: npt.NDArray[np.int32]
    """Offset of each band's weights in `weight`, shape (bands + 1,); equal neighbours mark an empty band."""
    weight: npt.NDArray[np.float32]

    @property
    def bins(self) -> int:
        """Number of bins, from 0 Hz on, that are used."""
        return int(np.max(self.start + np.diff(self.offset)))


def filters(ear: AnalysisWindow, sample_rate: float, length: int) -> Filters:
    """Return the filters for a transform of `length` samples: means of magnitude, wide bands raised by √width.

    So noise of equal strength per Hz gives the same in each band as it would in an energy sum. The magnitude is
    scaled so that a full sine in the middle of a band of one bin gives about 1. Bands beyond half the sample rate
    stay empty: their value is 0.
    """
    edges = band_centres(ear)
    bin_hz = sample_rate / length
    resolution = BASE_RATE / ear.window
    full = 4.0 / window_length(ear, sample_rate)
    bins = np.arange(length // 2) * bin_hz
    start, offset, weight = [], [0], []
    for low, centre, high in zip(edges[:-2], edges[1:-1], edges[2:], strict=True):
        rise = (bins - low) / (centre - low)
        fall = (high - bins) / (high - centre)
        triangle = np.maximum(np.minimum(rise, fall), 0.0)
        inside = np.flatnonzero(triangle)
        if high > 0.5 * sample_rate or inside.size == 0:
            inside = inside[:0]
        start.append(int(inside[0]) if inside.size else 0)
        width = 0.5 * (high - low)
        raised = np.sqrt(max(width / resolution, 1.0))
        weight.append(triangle[inside] * bin_hz / width * raised * full)
        offset.append(offset[-1] + inside.size)
    return Filters(np.array(start, np.int32), np.array(offset, np.int32), np.concatenate(weight).astype(np.float32))


Samples = npt.NDArray[np.float32]

RATE_MIN_HZ: Final = 16_000.0
RATE_MAX_HZ: Final = 400_000.0


class Spectrum:
    """Collects samples until a frame is full and computes its bands; allocates nothing after its creation."""

    def __init__(self, sample_rate: float) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        if not RATE_MIN_HZ <= sample_rate <= RATE_MAX_HZ:
            raise ValueError(f"a sample rate of {sample_rate} Hz: {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g} expected")
        self.sample_rate = sample_rate
        self.hop = BASE_HOP * sample_rate / BASE_RATE
        """Hop size in samples; not an integer at most rates, and kept exactly."""
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
        lengths = [window_length(ear, sample_rate) for ear in ANALYSIS_WINDOWS]
        self._history = np.zeros(max(lengths), np.float32)
        self._filters = [
            filters(ear, sample_rate, fast_length(length))
            for ear, length in zip(ANALYSIS_WINDOWS, lengths, strict=True)
        ]
        self._transforms = [
            MagnitudeTransform(np.hanning(length + 1)[:-1].astype(np.float32), kept.bins)
            for length, kept in zip(lengths, self._filters, strict=True)
        ]
        edges = np.cumsum((0, *BANDS_PER_WINDOW))
        self._out = [self.bands[low:high] for low, high in pairwise(edges)]

    @property
    def next_end(self) -> int:
        """Number of samples, counted from the start, at which the next frame is full."""
        return int((self.frames + 1) * self.hop)

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame is full."""
        return self.next_end - self.fed

    def feed(self, samples: Samples, start: int) -> int:
        """Take samples[start:], shape (n,), up to the end of the frame; return the number taken."""
        taken: int = min(self.wanted, samples.shape[0] - start)
        self.bad_samples += int(append(self._history, samples, start, taken))
        self.fed += taken
        return taken

    def analyse(self) -> None:
        """Compute `bands` of the frame that has just become full (`wanted` is 0)."""
        self.level = level_of(self._history, int(self.hop))
        for transform, kept, out in zip(self._transforms, self._filters, self._out, strict=True):
            transform.compute(self._history)
            band_magnitudes(transform.magnitude, kept.start, kept.offset, kept.weight, out)
        self.frames += 1
