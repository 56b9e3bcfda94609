"""Endless streams of training examples: recordings one after another, each stretched, tinted, dimmed or noisy."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numba
import numpy as np
import numpy.typing as npt

from live.clock.tracking.feature_kernels import CONTRAST, LEVEL_FALL, LEVEL_FLOOR, LEVEL_JUMP, LEVEL_RISE
from live.clock.tracking.features import BAND_COUNT, LAGS
from training.features import LOG_FLOOR, Item
from training.labels import Labels, label

Floats = npt.NDArray[np.float32]

RESET: Final = 0.25
"""Chance that a stream starts anew with a piece, as the engine does when it is switched on in the middle of a song."""


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """A piece of every stream, time first."""

    look: Floats
    """What the network sees, shape (T, B, 2 bands)."""
    classes: Floats
    phases: Floats
    known: Floats
    fresh: npt.NDArray[np.bool_]
    """Which streams start anew with this piece, shape (B,)."""


@numba.njit(nogil=True, cache=True)
def _render(log_bands, first, step, tint, noise, seed, level, past, out):  # type: ignore[no-untyped-def] # numba
    """Frames of a recording as the network sees them; level and past go on from frame to frame as in the engine."""
    np.random.seed(seed)  # noqa: NPY002 - numba's own generator
    count, bands = out.shape[0], log_bands.shape[1]
    rows = past.shape[0]
    magnitude = np.zeros(bands, np.float32)
    for frame in range(count):
        at = first + frame * step
        low = int(at)
        share = np.float32(at - low)
        mean = 0.0
        for band in range(bands):
            value = np.float32(log_bands[low, band]) * (np.float32(1.0) - share) + share * np.float32(
                log_bands[min(low + 1, log_bands.shape[0] - 1), band]
            )
            value = max(np.exp(value) - np.float32(LOG_FLOOR), np.float32(0.0)) * tint[band]
            if noise[band] > 0.0:
                value = np.sqrt(
                    value * value - noise[band] * noise[band] * np.float32(np.log(1.0 - np.random.random()))  # noqa: NPY002
                )
            magnitude[band] = value
            mean += value
        mean /= bands
        level += (LEVEL_RISE if mean > level else LEVEL_FALL) * (mean - level)
        level = max(level, mean / LEVEL_JUMP, LEVEL_FLOOR)
        gain = np.float32(CONTRAST / level)
        row = frame % rows
        for band in range(bands):
            value = np.log(np.float32(1.0) + gain * magnitude[band])
            past[row, band] = value
            out[frame, band] = value
            out[frame, bands + band] = max(value - past[(frame - LAGS[band]) % rows, band], np.float32(0.0))
    return level


def half(log_bands: npt.NDArray[np.float16]) -> Floats:
    """float32 for the kernel (numba has no float16)."""
    return log_bands.astype(np.float32)


def tint(rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(factor per band, noise per band): another room, another desk, another loudness, a narrow band, hiss."""
    place = np.linspace(0.0, 1.0, BAND_COUNT - 49)
    place = np.concatenate([place, np.linspace(0.08, 0.55, 49)])  # both ears hear the same room
    decibel = np.zeros(BAND_COUNT)
    if rng.random() < 0.8:
        for waves in (0.5, 1.0, 2.0):
            decibel += rng.normal(0.0, 3.0) * np.cos(np.pi * waves * (place + rng.random()))
    loud = rng.uniform(-35.0, 6.0) if rng.random() < 0.3 else rng.uniform(-10.0, 3.0)
    factor = 10.0 ** ((decibel + loud) / 20.0)
    if rng.random() < 0.15:
        factor *= place < rng.uniform(0.5, 0.97)
    elif rng.random() < 0.15:
        factor *= np.clip((place - rng.uniform(0.0, 0.25)) * 20.0 + 1.0, 0.0, 1.0)
    noise = np.zeros(BAND_COUNT)
    if rng.random() < 0.25:
        slope = rng.uniform(-20.0, 10.0)
        noise = 10.0 ** ((rng.uniform(-62.0, -34.0) + loud + slope * (place - 0.5)) / 20.0)
    return factor.astype(np.float32), noise.astype(np.float32)


class Stream:
    """One endless stream of frames with their labels."""

    def __init__(self, items: list[Item], seed: int, altered: bool = True) -> None:
        self._items = items
        self._rng = np.random.default_rng(seed)
        self._altered = altered
        self._order: list[int] = []
        self._past = np.zeros((int(LAGS.max()) + 1, BAND_COUNT), np.float32)
        self._level = LEVEL_FLOOR
        self._left = 0
        self._next_item()

    def _next_item(self) -> None:
        rng = self._rng
        if not self._order:
            self._order = list(rng.permutation(len(self._items)))
        self._item = self._items[self._order.pop()]
        self._bands = half(self._item.log_bands)
        self._step = float(np.exp(rng.uniform(np.log(0.8), np.log(1.25)))) if self._altered else 1.0
        self._first = float(rng.uniform(0.0, 400.0)) if self._altered else 0.0
        self._tint, self._noise = (
            tint(rng) if self._altered else (np.ones(BAND_COUNT, np.float32), np.zeros(BAND_COUNT, np.float32))
        )
        self._left = int((self._bands.shape[0] - 1 - self._first) / self._step)

    def restart(self) -> None:
        """Forget the level, as the engine at its start; the music goes on."""
        self._past[:] = 0.0
        self._level = LEVEL_FLOOR

    def fill(self, look: Floats, classes: Floats, phases: Floats, known: Floats) -> None:
        """Write the next frames into look (T, 2 bands), classes (T, 3), phases (T, 4) and known (T, 4)."""
        start = 0
        while start < look.shape[0]:
            if self._left <= 0:
                self._next_item()
            count = min(self._left, look.shape[0] - start)
            end = start + count
            rows = self._past.shape[0]
            out = np.empty((count, look.shape[1]), np.float32)
            self._level = _render(
                self._bands,
                self._first,
                self._step,
                self._tint,
                self._noise,
                int(self._rng.integers(2**31)),
                self._level,
                self._past,
                out,
            )
            self._past = np.roll(self._past, -(count % rows), axis=0)
            look[start:end] = out
            found: Labels = label(self._item, self._first, self._step, count)
            classes[start:end], phases[start:end], known[start:end] = found.classes, found.phases, found.known
            self._first += count * self._step
            self._left -= count
            start = end


def batches(items: list[Item], lanes: int, frames: int, seed: int) -> Iterator[Batch]:
    """Endless batches of `lanes` streams, `frames` frames each; the same for the same seed."""
    rng = np.random.default_rng((seed, 99))
    streams = [Stream(items, seed * 1000 + lane) for lane in range(lanes)]
    look = np.zeros((lanes, frames, 2 * BAND_COUNT), np.float32)
    parts = [np.zeros((lanes, frames, size), np.float32) for size in (3, 4, 4)]
    while True:
        fresh = rng.random(lanes) < RESET
        for lane, stream in enumerate(streams):
            if fresh[lane]:
                stream.restart()
            stream.fill(look[lane], *(part[lane] for part in parts))
        classes, phases, known = (part.swapaxes(0, 1).copy() for part in parts)
        yield Batch(look.swapaxes(0, 1).copy(), classes, phases, known, fresh)
