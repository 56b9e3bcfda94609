"""Beat tracker based on aubio's causal tempo tracker (Davies and Plumbley)."""

import math
from collections.abc import Callable
from typing import Any, Final

import aubio
import numpy as np

from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.silence import SILENT_AFTER, SILENT_LEVEL

HOP: Final = 0.0116
"""Approximate hop of the analysis [s]; rounded to a power of two of samples."""

AUBIO_ADVANCE: Final = 0.0029
"""aubio reports beats too early by this [s]: mean over clicks at 80 to 160 bpm, equal at 22 to 192 kHz."""

RESTART_AFTER: Final = 2.0
"""Seconds of silence after which the tracker is reset."""

MAX_SAMPLE: Final = 64.0
"""Samples beyond this are faulty and count as bad (full scale is 1)."""

DRUM_BANDS_HZ: Final = ((30.0, 180.0), (180.0, 2500.0))
"""Bands in which bass drum and snare are strong, and hi-hats are not."""

DRUM_BEATS: Final = 8
"""Number of beats over which the drums decide which half beat is the beat."""

DRUM_RATIO: Final = 1.3
"""Ratio by which drums must be stronger half a beat off to move the beat there."""

DRUM_MEMORY: Final = 0.003
"""Weight of each hop in a band's usual strength (time constant about 4 s)."""

DRUM_HOPS: Final = 1024
"""Number of hops for which the drums' strength is kept (about 12 s)."""

DRUM_FLOOR: Final = 1e-3
"""Strength below which a band counts as empty."""

RATE_MIN_HZ: Final = 8_000.0
RATE_MAX_HZ: Final = 400_000.0


class AubioTracker:
    """Feeds blocks of any length to aubio, hop by hop, at the device's own sample rate.

    Faulty samples (NaN, infinite, beyond `MAX_SAMPLE`) become 0 and are counted. In silence there are no estimates.
    After a long silence the tracker is reset, so that the old tempo does not persist. Without the decision by the drums
    it takes loud hi-hats between the beats for the beat.
    """

    def __init__(self, sample_rate: float) -> None:
        """Raises ValueError for a sample rate [Hz] outside 8,000 to 400,000."""
        if not RATE_MIN_HZ <= sample_rate <= RATE_MAX_HZ:
            raise ValueError(f"a sample rate of {sample_rate} Hz: {RATE_MIN_HZ:g} to {RATE_MAX_HZ:g} expected")
        self.sample_rate = sample_rate
        self.hop = 1 << round(math.log2(sample_rate * HOP))
        """Hop size in samples."""
        self.bad_samples = 0
        """Samples replaced by 0, since the start."""
        self.level = 0.0
        """RMS of the last hop, full scale = 1."""
        self._pending = np.zeros(self.hop, np.float32)
        self._filled = 0
        self._fed = 0
        self._quiet = 0.0
        self._silent = False
        self._window = np.hanning(2 * self.hop).astype(np.float32)
        self._last_two = np.zeros(2 * self.hop, np.float32)
        bin_hz = sample_rate / (2 * self.hop)
        self._bands = [slice(max(1, round(low / bin_hz)), max(2, round(high / bin_hz))) for low, high in DRUM_BANDS_HZ]
        self._band_level = [0.0] * len(self._bands)
        self._band_usual = [DRUM_FLOOR] * len(self._bands)
        self._drum = np.zeros(DRUM_HOPS, np.float32)
        self._hops = 0
        self._off_beat = False
        self._tempo: Callable[[Samples], Any]
        self._restart()

    @property
    def silent(self) -> bool:
        """Whether the last `SILENT_AFTER` seconds were silent."""
        return self._silent

    @property
    def wanted(self) -> int:
        """Samples missing until the next hop is full: feed this many for minimum latency."""
        return self.hop - self._filled

    @property
    def position(self) -> float:
        """Seconds of audio fed so far."""
        return (self._fed + self._filled) / self.sample_rate

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """Analyse the next samples, shape (n,), of one channel; return the beats found in them, oldest first."""
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
        with np.errstate(over="ignore", invalid="ignore"):
            energy = float(np.dot(block, block))
        if not energy <= MAX_SAMPLE**2:  # true for NaN too; the exact search runs only in this rare case
            bad = ~(np.abs(block) <= MAX_SAMPLE)
            self.bad_samples += int(np.count_nonzero(bad))
            block[bad] = 0.0
            energy = float(np.dot(block, block))
        self.level = math.sqrt(energy / self.hop)
        self._update_silence()
        self._update_drums()
        beat = self._tempo(block)[0] > 0.0 and not self._silent
        tempo: Any = self._tempo
        period = float(tempo.get_period_s()) if beat else 0.0
        if not (beat and math.isfinite(period) and period > 0.0):
            return None
        position = self._started + float(tempo.get_last_s()) + AUBIO_ADVANCE
        self._off_beat = self._drums_are_off(position, period)
        return BeatEstimate(
            position=position - 0.5 * period if self._off_beat else position,
            period=period,
            confidence=min(max(float(tempo.get_confidence()), 0.0), 1.0),
            fed=self._fed / self.sample_rate,
        )

    def _update_silence(self) -> None:
        if self.level >= SILENT_LEVEL:
            if self._quiet >= RESTART_AFTER:
                self._restart()
                self._started -= self.hop / self.sample_rate  # the present hop is the first that the new tracker gets
            self._quiet, self._silent = 0.0, False
            return
        self._quiet += self.hop / self.sample_rate
        self._silent = self._quiet >= SILENT_AFTER

    def _update_drums(self) -> None:
        """Record how much louder the drum bands became with this hop, each relative to its usual rise."""
        self._last_two[: self.hop] = self._last_two[self.hop :]
        self._last_two[self.hop :] = self._pending
        spectrum = np.fft.rfft(self._last_two * self._window)
        strength = 0.0
        for band, bins in enumerate(self._bands):
            part = spectrum[bins]
            level = math.sqrt(float(np.vdot(part, part).real))
            rise = max(level - self._band_level[band], 0.0)
            self._band_level[band] = level
            self._band_usual[band] += DRUM_MEMORY * (rise - self._band_usual[band])
            strength += rise / (self._band_usual[band] + DRUM_FLOOR)
        self._drum[self._hops % DRUM_HOPS] = strength
        self._hops += 1

    def _drums_are_off(self, position: float, period: float) -> bool:
        """Whether the drums are half a beat off; the last answer if they are not clear.

        Trackers of onsets most often mistake hi-hats between the beats for the beat.
        """
        step = self.hop / self.sample_rate
        beats = min(DRUM_BEATS, int((DRUM_HOPS - 8) * step / period) - 1)
        first = (position - step) / step - 1.0  # a rise found in hop n began between the middles of windows n - 1 and n
        strength = [0.0, 0.0]
        for half in range(1, 2 * beats + 1):
            centre = round(first - 0.5 * half * period / step)
            low, high = max(centre - 2, self._hops - DRUM_HOPS, 0), centre + 4
            if low < high <= self._hops:
                strength[half % 2] += float(np.max(self._drum.take(range(low, high), mode="wrap")))
        on, off = strength
        return off > DRUM_RATIO * on or (self._off_beat and not on > DRUM_RATIO * off)
