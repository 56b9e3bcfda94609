"""Hearing: samples in; per frame of 11.6 ms, how much it sounds like a beat and like a downbeat."""

from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from live.clock.tracking.bands import BAND_COUNT, HOP, LAGS
from live.clock.tracking.feature_kernels import LEVEL_FLOOR, follow_level, look
from live.clock.tracking.spectrum import Samples, Spectrum

DELAY_FRAMES: Final = 3
DELAY: Final = DELAY_FRAMES * HOP
"""A frame speaks of the moment this long [s] before its last sample: then the window has seen the attack."""

SPARE: Final = 4
"""Frames that may come beside those that a block completes."""

LONGEST: Final = 256
"""Frames for which room is made at the start (3 s); a longer block makes more once."""


Chances = npt.NDArray[np.float64]


class Activation(Protocol):
    """What makes two numbers of each frame: the network, or plain onsets where there is none.

    It may wait for a frame or two and then speak of all of them at once.
    """

    beat: Chances
    """Chance that a beat lies at a frame's moment, 0 to 1 (a downbeat is a beat too), oldest frame first."""
    downbeat: Chances
    """Chance that a downbeat lies there, 0 to `beat`."""

    def step(self, look: npt.NDArray[np.float32]) -> int:
        """Take one frame's compressed bands and rises, shape (2 * BAND_COUNT,).

        Returns of how many frames it now speaks, the newest of them this one: the first rows of `beat`, `downbeat`.
        """

    def reset(self) -> None:
        """Forget all music so far."""


class Hearing:
    """Feeds a stream of samples, at any rate and block size, to an Activation, frame by frame.

    After `feed` the frames it completed lie in the first rows of `position`, `beat` and `downbeat`; the next call
    overwrites them. Nothing is allocated from one block to the next.
    """

    def __init__(self, sample_rate: float, activation: Activation) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        self._spectrum = Spectrum(sample_rate)
        self._activation = activation
        self._level = LEVEL_FLOOR
        self._past = np.zeros((int(LAGS.max()) + 1, BAND_COUNT), np.float32)
        self._look = np.zeros(2 * BAND_COUNT, np.float32)
        self._make_room(LONGEST)

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return self._spectrum.sample_rate

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame is full: feed so many to lose no time."""
        return self._spectrum.wanted

    @property
    def fed(self) -> float:
        """Seconds of sound fed so far."""
        return self._spectrum.fed / self._spectrum.sample_rate

    @property
    def level(self) -> float:
        """RMS of the newest frame, full scale = 1."""
        return self._spectrum.level

    @property
    def bad_samples(self) -> int:
        """Samples that were no sound (NaN, infinite, beyond 64) and became 0, since the start."""
        return self._spectrum.bad_samples

    def feed(self, samples: Samples) -> int:
        """Hear the next samples, shape (n,), of one channel; returns how many frames they completed.

        Frame i of them speaks of the moment `position[i]` [s from the first sample fed]: `beat[i]` is the chance
        that a beat lies there, `downbeat[i]` that a downbeat does (never more than `beat[i]`).
        Raises ValueError for another shape.
        """
        if samples.ndim != 1:
            raise ValueError(f"samples of shape {samples.shape}: one channel, shape (n,), expected")
        if samples.shape[0] > (self.position.shape[0] - SPARE) * self._spectrum.hop:
            self._make_room(int(samples.shape[0] / self._spectrum.hop) + SPARE + 1)
        count = start = 0
        while start < samples.shape[0]:
            start += self._spectrum.take(samples, start)
            if self._spectrum.wanted == 0:
                count += self._hear(count)
        return count

    def reset(self) -> None:
        """Forget the music so far (after a long silence); positions go on."""
        self._activation.reset()
        self._level = LEVEL_FLOOR
        self._past[:] = 0.0

    def _hear(self, first: int) -> int:
        spectrum = self._spectrum
        spectrum.read()
        self._level = follow_level(spectrum.bands, self._level)
        look(spectrum.bands, self._level, LAGS, self._past, spectrum.frames, self._look)
        count = self._activation.step(self._look)
        for index in range(count):
            self.position[first + index] = (spectrum.frames - count + 1 + index) * HOP - DELAY
            self.beat[first + index] = self._activation.beat[index]
            self.downbeat[first + index] = self._activation.downbeat[index]
        return count

    def _make_room(self, frames: int) -> None:
        self.position = np.zeros(frames)
        """Moments that the frames speak of [s], shape (frames,)."""
        self.beat = np.zeros(frames)
        """Chance of a beat, shape (frames,)."""
        self.downbeat = np.zeros(frames)
        """Chance of a downbeat, shape (frames,)."""
