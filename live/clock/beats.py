"""BeatTracker: sound in, beat estimates out, around aubio's causal tempo tracker (Davies and Plumbley)."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import aubio
import numpy as np
import numpy.typing as npt

Samples = npt.NDArray[np.float32]

HOP: Final = 0.0116
"""Wanted step of the analysis [s]; the hop is the power of two of samples that comes nearest."""

EARLY: Final = 0.0029
"""aubio names beats this much too early [s]: mean over clicks at 80 to 160 bpm, equal at 22 to 192 kHz."""

SILENT_LEVEL: Final = 10.0 ** (-55.0 / 20.0)
"""Below this level (RMS, full scale = 1) nothing is played: -55 dB lies over the noise of a line input."""

SILENT_AFTER: Final = 0.7
"""Seconds below `SILENT_LEVEL` that make a silence; shorter ones are part of the music."""

RESTART_AFTER: Final = 2.0
"""Seconds of silence after which the tracker forgets the music before."""

LOUDEST: Final = 64.0
"""Samples beyond this are no sound but a fault, and count as bad (full scale is 1)."""

RATE_MIN_HZ: Final = 8_000.0
RATE_MAX_HZ: Final = 400_000.0


@dataclass(frozen=True, slots=True)
class BeatEstimate:
    """One beat as the tracker hears it; `position` and `heard` are seconds from the first sample fed."""

    position: float
    """Where the beat lies [s]; it may lie a few milliseconds ahead of what was fed."""
    period: float
    """Seconds to the next beat."""
    confidence: float
    """How sure the tracker is, 0 to 1."""
    heard: float
    """How much had been fed when the estimate was made [s]."""


class BeatTracker:
    """Feeds blocks of any length to aubio, hop by hop, at the device's own sample rate.

    Samples that are no sound (NaN, infinite, beyond `LOUDEST`) become 0 and are counted. In silence nothing is
    estimated, and after a long one the tracker starts anew, so that it does not go on with the music before.
    """

    def __init__(self, sample_rate: float) -> None:
        """Raises ValueError for a sample rate [Hz] outside 8,000 to 400,000."""
        if not RATE_MIN_HZ <= sample_rate <= RATE_MAX_HZ:
            raise ValueError(f"a sample rate of {sample_rate} Hz: {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g} expected")
        self.sample_rate = sample_rate
        self.hop = 1 << round(math.log2(sample_rate * HOP))
        """Samples per step of the analysis."""
        self.bad_samples = 0
        """Samples replaced by 0, since the start."""
        self.level = 0.0
        """RMS of the last hop, full scale = 1."""
        self._pending = np.zeros(self.hop, np.float32)
        self._filled = 0
        self._fed = 0
        self._quiet = 0.0
        self._silent = False
        self._tempo: Callable[[Samples], Any]
        self._restart()

    @property
    def silent(self) -> bool:
        """Whether nothing was to be heard for the last `SILENT_AFTER` seconds."""
        return self._silent

    @property
    def wanted(self) -> int:
        """Samples missing until the next step of the analysis: feed so many to lose no time at a step."""
        return self.hop - self._filled

    @property
    def position(self) -> float:
        """Seconds of sound fed so far."""
        return (self._fed + self._filled) / self.sample_rate

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """Analyse the next samples, shape (n,), of one channel; returns the beats found in them, oldest first."""
        if samples.ndim != 1:
            raise ValueError(f"samples of shape {samples.shape}: one channel, shape (n,), expected")
        found: list[BeatEstimate] = []
        start = 0
        while start < samples.shape[0]:
            taken = min(self.hop - self._filled, samples.shape[0] - start)
            self._pending[self._filled : self._filled + taken] = samples[start : start + taken]
            start += taken
            self._filled += taken
            if self._filled == self.hop:
                self._filled = 0
                self._fed += self.hop
                estimate = self._analyse()
                if estimate is not None:
                    found.append(estimate)
        return found

    def _restart(self) -> None:
        self._tempo = aubio.tempo("default", 2 * self.hop, self.hop, round(self.sample_rate))
        self._started = self._fed / self.sample_rate

    def _analyse(self) -> BeatEstimate | None:
        block = self._pending
        energy = float(np.dot(block, block))
        if not energy <= self.hop * LOUDEST:  # also true for NaN: one test for the rule, the search for the exception
            with np.errstate(invalid="ignore"):
                bad = ~(np.abs(block) <= LOUDEST)
            self.bad_samples += int(np.count_nonzero(bad))
            block[bad] = 0.0
            energy = float(np.dot(block, block))
        self.level = math.sqrt(energy / self.hop)
        self._listen_for_silence()
        beat = self._tempo(block)[0] > 0.0 and not self._silent
        tempo: Any = self._tempo
        period = float(tempo.get_period_s()) if beat else 0.0
        if not (beat and math.isfinite(period) and period > 0.0):
            return None
        return BeatEstimate(
            position=self._started + float(tempo.get_last_s()) + EARLY,
            period=period,
            confidence=min(max(float(tempo.get_confidence()), 0.0), 1.0),
            heard=self._fed / self.sample_rate,
        )

    def _listen_for_silence(self) -> None:
        if self.level >= SILENT_LEVEL:
            if self._quiet >= RESTART_AFTER:
                self._restart()
                self._started -= self.hop / self.sample_rate  # the hop in hand is the first that it hears
            self._quiet, self._silent = 0.0, False
            return
        self._quiet += self.hop / self.sample_rate
        self._silent = self._quiet >= SILENT_AFTER
