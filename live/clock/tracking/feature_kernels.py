"""Kernels for audio features: sample buffering, filter bands, network input, and the network's layers."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]

MAX_SAMPLE = 64.0
"""Samples beyond this are faulty and become 0 (full scale is 1)."""

LEVEL_FLOOR = 2e-5
"""Minimum level for normalisation: about -70 dB of full scale."""

LEVEL_FALL = 0.0028
"""Weight of each frame in a falling level (time constant 4 s): a fade of 2 dB a second is followed."""

LEVEL_RISE = 0.045
"""Weight of each frame in a rising level (time constant 0.25 s)."""

LEVEL_JUMP = 4.0
"""A frame louder than the level by this factor raises it at once."""

CONTRAST = 10.0
"""A band at the level becomes ln(1 + CONTRAST)."""


@kernel("f8(f4[::1],f4[::1],i8,i8)")
def append(history: Floats, samples: Floats, start: int, count: int) -> float:
    """Shift `count` samples from `samples[start:]` into `history`, faulty ones as 0; return the number of faulty
    ones."""
    kept = history.shape[0] - count
    for index in range(kept):
        history[index] = history[index + count]
    bad = 0
    for index in range(count):
        value = samples[start + index]
        if not abs(value) <= MAX_SAMPLE:  # true for NaN too
            value = np.float32(0.0)
            bad += 1
        history[kept + index] = value
    return float(bad)


@kernel("f8(f4[::1],i8)")
def level_of(history: Floats, count: int) -> float:
    """Return the RMS of the newest `count` samples."""
    total = 0.0
    for index in range(history.shape[0] - count, history.shape[0]):
        total += float(history[index]) * float(history[index])
    return math.sqrt(total / count)


@kernel("void(f4[::1],i4[::1],i4[::1],f4[::1],f4[::1])")
def band_magnitudes(magnitude: Floats, start: Ints, offset: Ints, weight: Floats, out: Floats) -> None:
    """Compute weighted sums of a spectrum's magnitudes, one per band, shape (bands,)."""
    for band in range(start.shape[0]):
        total = np.float32(0.0)
        first = start[band] - offset[band]
        for index in range(offset[band], offset[band + 1]):
            total += weight[index] * magnitude[first + index]
        out[band] = total


@kernel("f8(f4[::1],f8)")
def follow_level(bands: Floats, level: float) -> float:
    """Return the slow level of the music after one more frame of band magnitudes, from the level before it."""
    mean = 0.0
    for band in range(bands.shape[0]):
        mean += float(bands[band])
    mean /= bands.shape[0]
    level += (LEVEL_RISE if mean > level else LEVEL_FALL) * (mean - level)
    louder: float = max(level, mean / LEVEL_JUMP, LEVEL_FLOOR)
    return louder


@kernel("void(f4[::1],f8,i4[::1],f4[:,::1],i8,f4[::1])")
def network_input(bands: Floats, level: float, lags: Ints, past: Floats, frame: int, out: Floats) -> None:
    """Write the network's input for one frame: compressed bands, then their rises, shape (2 B,).

    past (P, B) is a ring of compressed bands, written at row `frame` modulo P.
    """
    count = bands.shape[0]
    rows = past.shape[0]
    gain = CONTRAST / level
    row = frame % rows
    for band in range(count):
        value = np.float32(math.log1p(gain * float(bands[band])))
        past[row, band] = value
        out[band] = value
        before = past[(frame - lags[band]) % rows, band]
        out[count + band] = max(value - before, np.float32(0.0))


@kernel("void(f4[::1],i8,i8,f4[:,::1],f4[::1],i8,f4[::1],i8)")
def filter_bands(
    features: Floats, first: int, bands: int, weight: Floats, bias: Floats, stride: int, out: Floats, at: int
) -> None:
    """Apply one window type's filters along frequency: weight (2 span, channels) over levels and rises, into out[at:].

    The same filters are applied at every `stride`-th band of seen[first : first + bands]; negative results become 0.
    """
    channels = weight.shape[1]
    span = weight.shape[0] // 2
    count = features.shape[0] // 2
    for place in range((bands - span) // stride + 1):
        start = at + place * channels
        for channel in range(channels):
            out[start + channel] = bias[channel]
        for index in range(span):
            level = features[first + place * stride + index]
            for channel in range(channels):
                out[start + channel] += level * weight[index, channel]
            rise = features[count + first + place * stride + index]
            if rise > 0.0:
                for channel in range(channels):
                    out[start + channel] += rise * weight[span + index, channel]
        for channel in range(channels):
            out[start + channel] = max(out[start + channel], np.float32(0.0))


@kernel("void(f4[::1],f4[:,::1],f4[::1],f4[::1])")
def dense_layer(values: Floats, weight: Floats, bias: Floats, out: Floats) -> None:
    """Apply a dense layer: values (I,) through weight (I, O) and bias (O,), into out (O,)."""
    for column in range(out.shape[0]):
        out[column] = bias[column]
    for row in range(values.shape[0]):
        value = values[row]
        if value != 0.0:
            for column in range(out.shape[0]):
                out[column] += value * weight[row, column]


@kernel("void(f4[::1],f4[::1],f4[::1],f4[::1])")
def gru_step(input_term: Floats, recurrent_term: Floats, bias: Floats, memory: Floats) -> None:
    """Update one recurrent layer: memory (U,) after a frame, from the input and recurrent terms (3 U,).

    The order is update, reset, candidate; `bias` (U,) is added to the candidate's recurrent term before the reset.
    """
    units = memory.shape[0]
    for unit in range(units):
        update = 1.0 / (1.0 + math.exp(-(input_term[unit] + recurrent_term[unit])))
        reset = 1.0 / (1.0 + math.exp(-(input_term[units + unit] + recurrent_term[units + unit])))
        new = math.tanh(input_term[2 * units + unit] + reset * (recurrent_term[2 * units + unit] + bias[unit]))
        memory[unit] = new + update * (memory[unit] - new)
