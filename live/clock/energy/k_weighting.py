"""K-weighting: the frequency weighting of loudness meters (ITU-R BS.1770-5, annex 1)."""

from typing import Final

import numpy as np

from live.base.arrays import Float64

REFERENCE_HZ: Final = 48_000.0
SHELF: Final = ((1.53512485958697, -2.69169618940638, 1.19839281085285), (1.0, -1.69065929318241, 0.73248077421585))
"""Shelf filter for the head: numerator and denominator at 48 kHz (table 1)."""

HIGH_PASS: Final = ((1.0, -2.0, 1.0), (1.0, -1.99004745483398, 0.99007225036621))
"""High-pass filter (table 2)."""

OFFSET_DB: Final = -0.691
"""A full sine of 997 Hz in one channel has -3.01 LUFS."""

SILENT_DB: Final = -120.0
"""Loudness of silence."""


def k_weight(frequency: Float64) -> Float64:
    """Return the power factor at each `frequency` [Hz], any shape; 0 above 20 kHz, which is inaudible."""
    z = np.exp(-2j * np.pi * np.minimum(frequency, 0.5 * REFERENCE_HZ) / REFERENCE_HZ)
    gain = np.ones_like(frequency)
    for above, below in (SHELF, HIGH_PASS):
        gain *= np.abs(np.polyval(above[::-1], z) / np.polyval(below[::-1], z)) ** 2
    return np.where(frequency <= 20_000.0, gain, 0.0)


def decibels(power: float) -> float:
    """Return the loudness [dB] of a K-weighted mean square; `SILENT_DB` for none."""
    return max(OFFSET_DB + 10.0 * float(np.log10(power)), SILENT_DB) if power > 1e-13 else SILENT_DB
