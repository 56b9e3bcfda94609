"""Kernels for energy features: sample buffering and analysis of one spectrum."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int32]
Complexes = npt.NDArray[np.complex64]

LOUD = 0
LOW = 1
OCTAVES = 2
MAGNITUDE = 3
RISE = 4
POWER = 5
FEATURE_COUNT = 6

MAX_SAMPLE = 64.0
"""Samples beyond this are faulty and become 0 (full scale is 1)."""


@kernel("void(f4[::1],i8,f4[::1],i8,i8)")
def append(history: Floats, at: int, samples: Floats, start: int, count: int) -> None:
    """Copy `count` samples from `samples[start:]` to `history[at:]`; faulty samples (also NaN) become 0."""
    for index in range(count):
        value = samples[start + index]
        history[at + index] = value if abs(value) <= MAX_SAMPLE else 0.0


@kernel("void(c8[::1],f4[::1],f4[::1],i4[::1],i4,f8,f4[::1],f8[::1])")
def spectrum_features(
    spectrum: Complexes,
    weight: Floats,
    octave: Floats,
    edges: Ints,
    low_bands: int,
    floor: float,
    before: Floats,
    out: Doubles,
) -> None:
    """Analyse one spectrum, shape (K,).

    `weight` (K,) gives each bin's share of the K-weighted mean square, `octave` (K,) its position. `edges` (B + 1,)
    are the first bins of B bands; the first `low_bands` are the bass. `floor`: power per bin that is inaudible next to
    the rest. `before` (B,) holds the bands' last levels and takes the new ones. `out` (OUT,) gets: K-weighted power,
    power of the bass, the sum of octaves weighted by magnitude, the sum of magnitudes, the mean rise of the bands
    [nepers over the floor], and the power per bin.
    """
    loud = low = octaves = magnitudes = rise = whole = 0.0
    for band in range(edges.shape[0] - 1):
        power = 0.0
        for k in range(edges[band], edges[band + 1]):
            part = spectrum[k].real * spectrum[k].real + spectrum[k].imag * spectrum[k].imag
            power += part
            loud += weight[k] * part
            magnitude = math.sqrt(part)
            octaves += octave[k] * magnitude
            magnitudes += magnitude
            if band < low_bands:
                low += weight[k] * part
        width = max(edges[band + 1] - edges[band], 1)
        whole += power
        level = np.float32(0.5 * math.log(1e-9 + floor + power / width))
        rise += max(level - before[band], 0.0)
        before[band] = level
    out[LOUD], out[LOW], out[OCTAVES], out[MAGNITUDE] = loud, low, octaves, magnitudes
    out[RISE] = rise / max(edges.shape[0] - 1, 1)
    out[POWER] = whole / max(edges[-1] - edges[0], 1)
