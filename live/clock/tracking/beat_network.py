"""Neural network for the probabilities of a beat and a downbeat, and the feature stream that feeds it.

Filters along frequency, one dense layer, two gated recurrent layers (Cho et al., Learning phrase representations
using RNN encoder-decoder, 2014; the form with the reset after the product), one head of three classes: nothing, beat,
downbeat. The recurrent layers run at every second frame and give results for both. A frame is 11.6 ms. Networks of
several trainings answer together: what one of them learned by chance, the others do not (Hansen and Salamon, Neural
network ensembles, PAMI 1990; for beats Böck, Krebs and Widmer, ISMIR 2014). `training/` makes the weights; they are
passed in as arrays.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np
import numpy.typing as npt

from live.clock.tracking.feature_kernels import (
    LEVEL_FLOOR,
    dense_layer,
    filter_bands,
    follow_level,
    gru_step,
    network_input,
)
from live.clock.tracking.features import BAND_COUNT, BANDS_PER_WINDOW, HOP, LAGS, Samples, Spectrum

Floats = npt.NDArray[np.float32]

STRIDE: Final = 5
"""Stride of the filters in bands."""

LAYERS: Final = 2
"""Number of recurrent layers."""

FRAMES_PER_STEP: Final = 2
"""Number of frames that the recurrent layers process at a time."""

CLASSES: Final = 3
"""Nothing, beat, downbeat."""


@dataclass(frozen=True, slots=True, eq=False)
class NetworkWeights:
    """Trained weights, float32, C-contiguous."""

    filters: tuple[Floats, ...]
    """Per window type, filters (2 span, channels): levels, then rises."""
    filter_bias: tuple[Floats, ...]
    dense: Floats
    dense_bias: Floats
    input_weights: tuple[Floats, ...]
    """Per recurrent layer, the input weights (inputs, 3 units): update, reset, candidate."""
    input_bias: tuple[Floats, ...]
    recurrent_weights: tuple[Floats, ...]
    """Per recurrent layer, the recurrent weights (units, 3 units)."""
    candidate_bias: tuple[Floats, ...]
    head: Floats
    """(units of all layers, FRAMES_PER_STEP * CLASSES): the older frame first."""
    head_bias: Floats

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[np.floating]]) -> "NetworkWeights":
        """Build from named arrays as the training writes them; KeyError or ValueError if they do not fit together."""

        def take(name: str) -> Floats:
            found = np.array(arrays[name], np.float32, order="C")  # a copy: kernels take no read-only arrays
            if not np.isfinite(found).all():
                raise ValueError(f"weights {name} are not finite")
            return found

        ears, layers = range(len(BANDS_PER_WINDOW)), range(LAYERS)
        weights = cls(
            filters=tuple(take(f"ear{ear}_w") for ear in ears),
            filter_bias=tuple(take(f"ear{ear}_b") for ear in ears),
            dense=take("dense_w"),
            dense_bias=take("dense_b"),
            input_weights=tuple(take(f"gru{index}_x") for index in layers),
            input_bias=tuple(take(f"gru{index}_b") for index in layers),
            recurrent_weights=tuple(take(f"gru{index}_h") for index in layers),
            candidate_bias=tuple(take(f"gru{index}_c") for index in layers),
            head=take("head_w"),
            head_bias=take("head_b"),
        )
        weights._check()
        return weights

    def filter_positions(self, ear: int) -> int:
        """Return the number of positions of a window type's filters."""
        count: int = (BANDS_PER_WINDOW[ear] - self.filters[ear].shape[0] // 2) // STRIDE + 1
        return count

    def _check(self) -> None:
        flat = sum(self.filter_positions(ear) * weight.shape[1] for ear, weight in enumerate(self.filters))
        sizes = [self.dense.shape[1], *(weight.shape[0] for weight in self.recurrent_weights)]
        wanted: list[tuple[Floats, tuple[int, ...]]] = [(self.dense, (flat, sizes[0])), (self.dense_bias, (sizes[0],))]
        for ear, weight in enumerate(self.filters):
            wanted.append((self.filter_bias[ear], (weight.shape[1],)))
        for index in range(LAYERS):
            below, units = sizes[index] * (FRAMES_PER_STEP if index == 0 else 1), sizes[index + 1]
            wanted += [
                (self.input_weights[index], (below, 3 * units)),
                (self.input_bias[index], (3 * units,)),
                (self.recurrent_weights[index], (units, 3 * units)),
                (self.candidate_bias[index], (units,)),
            ]
        wanted += [
            (self.head, (sum(sizes[1:]), CLASSES * FRAMES_PER_STEP)),
            (self.head_bias, (CLASSES * FRAMES_PER_STEP,)),
        ]
        for array, shape in wanted:
            if array.shape != shape:
                raise ValueError(f"weights of shape {array.shape} where {shape} is expected")


class BeatNetwork:
    """The trained activation, of one network or several: the mean of their log-odds. Allocates nothing after its
    creation."""

    def __init__(self, *weights: NetworkWeights) -> None:
        """Raises ValueError if there are none."""
        if not weights:
            raise ValueError("a beat network without weights")
        self.beat = np.zeros(FRAMES_PER_STEP)
        self.downbeat = np.zeros(FRAMES_PER_STEP)
        self._members = [_Member(one) for one in weights]
        self._logits = np.zeros(CLASSES * FRAMES_PER_STEP, np.float32)

    def reset(self) -> None:
        """Reset the recurrent state."""
        for member in self._members:
            member.reset()

    def step(self, features: Floats) -> int:
        """Process one frame's compressed bands and rises, shape (2 * BAND_COUNT,); return 0 and
        FRAMES_PER_STEP in turn."""
        if features.shape != (2 * BAND_COUNT,):
            raise ValueError(f"a frame of shape {features.shape}: {(2 * BAND_COUNT,)} expected")
        count = 0
        self._logits[:] = 0.0
        for member in self._members:
            count = member.step(features)
            self._logits += member.logits
        if count:
            self._tell()
        return count

    def _tell(self) -> None:
        self._logits *= np.float32(1.0 / len(self._members))
        for frame in range(FRAMES_PER_STEP):
            nothing, beat, downbeat = self._logits[CLASSES * frame : CLASSES * (frame + 1)].tolist()
            top = max(nothing, beat, downbeat)
            shares = math.exp(nothing - top), math.exp(beat - top), math.exp(downbeat - top)
            total = sum(shares)
            self.downbeat[frame] = shares[2] / total
            self.beat[frame] = (shares[1] + shares[2]) / total


class _Member:
    """One trained network."""

    def __init__(self, weights: NetworkWeights) -> None:
        self.logits = np.zeros(CLASSES * FRAMES_PER_STEP, np.float32)
        """Log-odds of nothing, beat and downbeat of the last frames, the older first."""
        self._waiting = 0
        self._weights = weights
        channels = [weight.shape[1] for weight in weights.filters]
        places = [weights.filter_positions(ear) for ear in range(len(BANDS_PER_WINDOW))]
        self._edges = [0, *np.cumsum([a * b for a, b in zip(places, channels, strict=True)]).tolist()]
        self._first = [0, *np.cumsum(BANDS_PER_WINDOW).tolist()]
        self._filtered = np.zeros(self._edges[-1], np.float32)
        self._pair = np.zeros(FRAMES_PER_STEP * weights.dense.shape[1], np.float32)
        self._dense = np.split(self._pair, FRAMES_PER_STEP)
        units = [weight.shape[0] for weight in weights.recurrent_weights]
        self._input_terms = [np.zeros(3 * count, np.float32) for count in units]
        self._recurrent_terms = [np.zeros(3 * count, np.float32) for count in units]
        self._none = [np.zeros(3 * count, np.float32) for count in units]
        self._all = np.zeros(sum(units), np.float32)
        edges = [0, *np.cumsum(units).tolist()]
        self._memory = [self._all[edges[index] : edges[index + 1]] for index in range(LAYERS)]

    def reset(self) -> None:
        """Reset the recurrent state."""
        self._all[:] = 0.0
        self._waiting = 0

    def step(self, features: Floats) -> int:
        """Process one frame; return 0 and FRAMES_PER_STEP in turn: then there are new log-odds."""
        kept = self._weights
        for ear, bands in enumerate(BANDS_PER_WINDOW):
            filter_bands(
                features, self._first[ear], bands, kept.filters[ear], kept.filter_bias[ear], STRIDE,
                self._filtered, self._edges[ear],
            )  # fmt: skip
        dense = self._dense[self._waiting]
        dense_layer(self._filtered, kept.dense, kept.dense_bias, dense)
        np.maximum(dense, np.float32(0.0), out=dense)
        self._waiting = (self._waiting + 1) % FRAMES_PER_STEP
        if self._waiting:
            return 0
        below = self._pair
        for index, memory in enumerate(self._memory):
            dense_layer(below, kept.input_weights[index], kept.input_bias[index], self._input_terms[index])
            dense_layer(memory, kept.recurrent_weights[index], self._none[index], self._recurrent_terms[index])
            gru_step(self._input_terms[index], self._recurrent_terms[index], kept.candidate_bias[index], memory)
            below = memory
        dense_layer(self._all, kept.head, kept.head_bias, self.logits)
        return FRAMES_PER_STEP


DELAY_FRAMES: Final = 3
DELAY: Final = DELAY_FRAMES * HOP
"""A frame describes the moment this long [s] before its last sample, so that the window contains the attack."""

SPARE: Final = 4
"""Spare frames besides those that a block completes."""

INITIAL_CAPACITY: Final = 256
"""Frames allocated at the start (3 s); a longer block allocates more once."""


Probabilities = npt.NDArray[np.float64]


class Activation(Protocol):
    """Interface for the beat and downbeat probabilities of frames: the network, or onset strength.

    It may wait for a frame or two and then return results for all of them at once.
    """

    beat: Probabilities
    """Probability of a beat at a frame's moment, 0 to 1 (a downbeat is a beat too), oldest frame first."""
    downbeat: Probabilities
    """Probability of a downbeat, 0 to `beat`."""

    def step(self, features: npt.NDArray[np.float32]) -> int:
        """Process one frame's compressed bands and rises, shape (2 * BAND_COUNT,).

        Return the number of frames with results, this one being the newest: the first rows of `beat`, `downbeat`.
        """

    def reset(self) -> None:
        """Reset the recurrent state."""


class ActivationStream:
    """Feeds an audio stream, at any rate and block size, to an Activation, frame by frame.

    After `feed` the first rows of `position`, `beat` and `downbeat` hold the completed frames; the next call
    overwrites them. Nothing is allocated from one block to the next.
    """

    def __init__(self, sample_rate: float, activation: Activation) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        self._spectrum = Spectrum(sample_rate)
        self._activation = activation
        self._level = LEVEL_FLOOR
        self._past = np.zeros((int(LAGS.max()) + 1, BAND_COUNT), np.float32)
        self._features = np.zeros(2 * BAND_COUNT, np.float32)
        self._former = np.zeros(2 * BAND_COUNT, np.float32)
        self._allocate(INITIAL_CAPACITY)

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return self._spectrum.sample_rate

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame is full: feed this many for minimum latency."""
        return self._spectrum.wanted

    @property
    def fed_seconds(self) -> float:
        """Seconds of audio fed so far."""
        return self._spectrum.fed / self._spectrum.sample_rate

    @property
    def level(self) -> float:
        """RMS of the newest frame, full scale = 1."""
        return self._spectrum.level

    @property
    def bad_samples(self) -> int:
        """Number of faulty samples (NaN, infinite, beyond 64), which became 0, since the start."""
        return self._spectrum.bad_samples

    def feed(self, samples: Samples) -> int:
        """Process the next samples, shape (n,), of one channel; return the number of frames completed.

        Frame i describes the moment `position[i]` [s from the first sample fed]: `beat[i]` is the probability of a beat
        there, `downbeat[i]` of a downbeat (never more than `beat[i]`). Raises ValueError for another shape.
        """
        if samples.ndim != 1:
            raise ValueError(f"samples of shape {samples.shape}: one channel, shape (n,), expected")
        if samples.shape[0] > (self.position.shape[0] - SPARE) * self._spectrum.hop:
            self._allocate(int(samples.shape[0] / self._spectrum.hop) + SPARE + 1)
        count = start = 0
        while start < samples.shape[0]:
            start += self._spectrum.feed(samples, start)
            if self._spectrum.wanted == 0:
                count += self._process_frame(count)
        return count

    def reset(self) -> None:
        """Reset after a long silence; positions continue."""
        self._activation.reset()
        self._level = LEVEL_FLOOR
        self._past[:] = 0.0

    def _process_frame(self, first: int) -> int:
        spectrum = self._spectrum
        spectrum.analyse()
        self._level = follow_level(spectrum.bands, self._level)
        network_input(spectrum.bands, self._level, LAGS, self._past, spectrum.frames, self._features)
        count = self._activation.step(self._features)
        for index in range(count):
            self.features[first + index] = self._former if index < count - 1 else self._features
            self.position[first + index] = (spectrum.frames - count + 1 + index) * HOP - DELAY
            self.beat[first + index] = self._activation.beat[index]
            self.downbeat[first + index] = self._activation.downbeat[index]
        self._former[:] = self._features
        return count

    def _allocate(self, frames: int) -> None:
        self.position = np.zeros(frames)
        """Moments that the frames describe [s], shape (frames,)."""
        self.beat = np.zeros(frames)
        """Probability of a beat, shape (frames,)."""
        self.downbeat = np.zeros(frames)
        """Probability of a downbeat, shape (frames,)."""
        self.features = np.zeros((frames, 2 * BAND_COUNT), np.float32)
        """Compressed bands and their rises, shape (frames, 2 BAND_COUNT)."""
