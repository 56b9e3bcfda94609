"""Network: what is seen of a frame through trained weights, to the chances of a beat and of a downbeat.

Filters along frequency, one dense layer, two gated recurrent layers (Cho et al., Learning phrase representations
using RNN encoder-decoder, 2014; the form with the reset after the product), one head of three classes: nothing, beat,
downbeat. The recurrent layers run at every second frame and speak of both. `training/` makes the weights; the core is
given them as arrays.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.tracking.bands import BAND_COUNT, BANDS
from live.clock.tracking.feature_kernels import filter_bands, layer, rectify, remember

Floats = npt.NDArray[np.float32]

STRIDE: Final = 5
"""Bands from one place of a filter to the next."""

LAYERS: Final = 2
"""Recurrent layers."""

PAIR: Final = 2
"""Frames that the recurrent layers take, and speak of, at a time."""


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Trained numbers, float32, C-contiguous."""

    filters: tuple[Floats, ...]
    """Per ear, filters (2 span, channels): levels, then rises."""
    filter_bias: tuple[Floats, ...]
    dense: Floats
    dense_bias: Floats
    asked: tuple[Floats, ...]
    """Per recurrent layer, the input's share (inputs, 3 units): update, reset, candidate."""
    asked_bias: tuple[Floats, ...]
    recalled: tuple[Floats, ...]
    """Per recurrent layer, the memory's share (units, 3 units)."""
    candidate_bias: tuple[Floats, ...]
    head: Floats
    """(units of all layers, PAIR * 3): the older frame first."""
    head_bias: Floats

    @classmethod
    def of(cls, arrays: Mapping[str, npt.NDArray[np.floating]]) -> "Weights":
        """From named arrays as the training writes them; KeyError or ValueError where they do not fit together."""

        def take(name: str) -> Floats:
            found = np.array(arrays[name], np.float32, order="C")  # a copy: kernels take no read-only arrays
            if not np.isfinite(found).all():
                raise ValueError(f"weights {name} are not finite")
            return found

        ears, layers = range(len(BANDS)), range(LAYERS)
        weights = cls(
            filters=tuple(take(f"ear{ear}_w") for ear in ears),
            filter_bias=tuple(take(f"ear{ear}_b") for ear in ears),
            dense=take("dense_w"),
            dense_bias=take("dense_b"),
            asked=tuple(take(f"gru{index}_x") for index in layers),
            asked_bias=tuple(take(f"gru{index}_b") for index in layers),
            recalled=tuple(take(f"gru{index}_h") for index in layers),
            candidate_bias=tuple(take(f"gru{index}_c") for index in layers),
            head=take("head_w"),
            head_bias=take("head_b"),
        )
        weights._check()
        return weights

    def places(self, ear: int) -> int:
        """How many places an ear's filters look at."""
        count: int = (BANDS[ear] - self.filters[ear].shape[0] // 2) // STRIDE + 1
        return count

    def _check(self) -> None:
        flat = sum(self.places(ear) * weight.shape[1] for ear, weight in enumerate(self.filters))
        sizes = [self.dense.shape[1], *(weight.shape[0] for weight in self.recalled)]
        wanted: list[tuple[Floats, tuple[int, ...]]] = [(self.dense, (flat, sizes[0])), (self.dense_bias, (sizes[0],))]
        for ear, weight in enumerate(self.filters):
            wanted.append((self.filter_bias[ear], (weight.shape[1],)))
        for index in range(LAYERS):
            below, units = sizes[index] * (PAIR if index == 0 else 1), sizes[index + 1]
            wanted += [
                (self.asked[index], (below, 3 * units)),
                (self.asked_bias[index], (3 * units,)),
                (self.recalled[index], (units, 3 * units)),
                (self.candidate_bias[index], (units,)),
            ]
        wanted += [(self.head, (sum(sizes[1:]), 3 * PAIR)), (self.head_bias, (3 * PAIR,))]
        for array, shape in wanted:
            if array.shape != shape:
                raise ValueError(f"weights of shape {array.shape} where {shape} is expected")


class Network:
    """The trained activation; allocates nothing after it was made."""

    def __init__(self, weights: Weights) -> None:
        self.beat = np.zeros(PAIR)
        self.downbeat = np.zeros(PAIR)
        self._waiting = 0
        self._weights = weights
        channels = [weight.shape[1] for weight in weights.filters]
        places = [weights.places(ear) for ear in range(len(BANDS))]
        self._edges = [0, *np.cumsum([a * b for a, b in zip(places, channels, strict=True)]).tolist()]
        self._first = [0, *np.cumsum(BANDS).tolist()]
        self._filtered = np.zeros(self._edges[-1], np.float32)
        self._pair = np.zeros(PAIR * weights.dense.shape[1], np.float32)
        self._dense = np.split(self._pair, PAIR)
        units = [weight.shape[0] for weight in weights.recalled]
        self._asked = [np.zeros(3 * count, np.float32) for count in units]
        self._recalled = [np.zeros(3 * count, np.float32) for count in units]
        self._none = [np.zeros(3 * count, np.float32) for count in units]
        self._all = np.zeros(sum(units), np.float32)
        edges = [0, *np.cumsum(units).tolist()]
        self._memory = [self._all[edges[index] : edges[index + 1]] for index in range(LAYERS)]
        self._logits = np.zeros(3 * PAIR, np.float32)

    def reset(self) -> None:
        """Forget all music so far."""
        self._all[:] = 0.0
        self._waiting = 0

    def step(self, look: Floats) -> int:
        """Take one frame's compressed bands and rises, shape (2 * BAND_COUNT,); returns 0 and PAIR in turn."""
        if look.shape != (2 * BAND_COUNT,):
            raise ValueError(f"a frame of shape {look.shape}: {(2 * BAND_COUNT,)} expected")
        kept = self._weights
        for ear, bands in enumerate(BANDS):
            filter_bands(
                look, self._first[ear], bands, kept.filters[ear], kept.filter_bias[ear], STRIDE,
                self._filtered, self._edges[ear],
            )  # fmt: skip
        dense = self._dense[self._waiting]
        layer(self._filtered, kept.dense, kept.dense_bias, dense)
        rectify(dense)
        self._waiting = (self._waiting + 1) % PAIR
        if self._waiting:
            return 0
        self._recall()
        return PAIR

    def _recall(self) -> None:
        kept = self._weights
        below = self._pair
        for index, memory in enumerate(self._memory):
            layer(below, kept.asked[index], kept.asked_bias[index], self._asked[index])
            layer(memory, kept.recalled[index], self._none[index], self._recalled[index])
            remember(self._asked[index], self._recalled[index], kept.candidate_bias[index], memory)
            below = memory
        layer(self._all, kept.head, kept.head_bias, self._logits)
        for frame in range(PAIR):
            nothing, beat, downbeat = (float(value) for value in self._logits[3 * frame : 3 * frame + 3])
            top = max(nothing, beat, downbeat)
            shares = math.exp(nothing - top), math.exp(beat - top), math.exp(downbeat - top)
            total = sum(shares)
            self.downbeat[frame] = shares[2] / total
            self.beat[frame] = (shares[1] + shares[2]) / total
