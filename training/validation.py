"""How good activations are on recordings that were not learned from, by style; a plain picker of peaks decides."""

import zlib
from typing import Any, Final

import jax
import mir_eval
import numpy as np
import numpy.typing as npt

from live.clock.tracking.beat_network import DELAY
from live.clock.tracking.feature_kernels import LEVEL_FLOOR
from live.clock.tracking.features import BAND_COUNT, HOP, LAGS
from training import network
from training.examples import Floats, _render, half
from training.features import Item
from training.labels import label

HELD_OUT: Final = 10
"""One item in so many is held out where its maker does not say."""

THRESHOLD: Final = 0.3
"""Activation that makes a peak a beat."""


def split(items: list[Item]) -> tuple[list[Item], list[Item]]:
    """(to learn from, held out): by the maker's word "split", else by a hash of the name."""

    def is_held_out(item: Item) -> bool:
        if "split" in item.facts:
            return bool(item.facts["split"] != "train")
        return zlib.crc32(item.name.encode()) % HELD_OUT == 0

    return [item for item in items if not is_held_out(item)], [item for item in items if is_held_out(item)]


def look_of(item: Item) -> Floats:
    """What the network sees of a whole item, unaltered, shape (frames, 2 bands)."""
    past = np.zeros((int(LAGS.max()) + 1, BAND_COUNT), np.float32)
    out = np.empty((item.log_bands.shape[0], 2 * BAND_COUNT), np.float32)
    ones, none = np.ones(BAND_COUNT, np.float32), np.zeros(BAND_COUNT, np.float32)
    _render(half(item.log_bands), 0.0, 1.0, ones, none, 0, LEVEL_FLOOR, past, out)
    return out


_forward = jax.jit(network.forward)


def activations(weights: network.Weights, items: list[Item]) -> list[Floats]:
    """Chances of nothing, beat, downbeat per frame, shape (frames, 3), of each item."""
    out: list[Floats] = []
    for start in range(0, len(items), 32):
        group = items[start : start + 32]
        longest = 1000 * (max(item.log_bands.shape[0] for item in group) // 1000 + 1)
        look = np.zeros((longest, 32, 2 * BAND_COUNT), np.float32)
        for lane, item in enumerate(group):
            look[: item.log_bands.shape[0], lane] = look_of(item)
        memory = network.state(32)
        found = []
        for first in range(0, longest, 1000):
            logits, _, memory = _forward(weights, look[first : first + 1000], memory)
            found.append(np.asarray(jax.nn.softmax(logits)))
        all_ = np.concatenate(found)
        out += [all_[: item.log_bands.shape[0], lane] for lane, item in enumerate(group)]
    return out


def peaks(activation: Floats, threshold: float = THRESHOLD) -> npt.NDArray[np.float64]:
    """Times [s] of the highest frames within ± 6 that pass the threshold."""
    padded = np.pad(activation, 6)
    highest = np.lib.stride_tricks.sliding_window_view(padded, 13).max(axis=1)
    found = np.flatnonzero((activation >= highest) & (activation > threshold))
    before = activation[np.maximum(found - 1, 0)]
    after = activation[np.minimum(found + 1, activation.size - 1)]
    shift = 0.5 * (after - before) / np.maximum(2.0 * activation[found] - before - after, 1e-6)
    times: npt.NDArray[np.float64] = (found + np.clip(shift, -0.5, 0.5) + 1.0) * HOP - DELAY
    return times


def f_measure(item: Item, beats: npt.NDArray[np.float64], found: npt.NDArray[np.float64]) -> float:
    """F of found beats against the true ones within 70 ms, from 5 s on (mir_eval), where beats can be named."""
    true = beats[beats >= 5.0]
    found = found[(found >= 5.0) & (found <= item.beats[-1] + 0.07)]
    for low, high in item.facts.get("ignore", []):
        found, true = (times[(times < low) | (times > high)] for times in (found, true))
    return float(mir_eval.beat.f_measure(true, np.sort(found))) if true.size and found.size else 0.0


def report(weights: network.Weights, items: list[Item], brief: bool = False) -> str:
    """F of beats and downbeats, and the median error of hits, over all items and by style."""
    rows: dict[str, list[tuple[float, float]]] = {}
    errors: list[float] = []
    losses: list[float] = []
    worth = [item for item in items if item.beats.size > 8]
    for item, chances in zip(worth, activations(weights, worth), strict=True):
        target = label(item, 0.0, 1.0, chances.shape[0])
        losses.append(float(-(target.classes * np.log(chances + 1e-7) * target.known[:, 1:2]).sum(1).mean()))
        found = peaks(1.0 - chances[:, 0])
        beat = f_measure(item, item.beats, found)
        downbeats = item.beats[item.places == 1]
        usable = downbeats.size > 2 and item.facts.get("has_downbeat", True)
        down = f_measure(item, downbeats, peaks(chances[:, 2], 0.2)) if usable else float("nan")
        rows.setdefault(item.style, []).append((beat, down))
        if found.size:
            off = found - item.beats[np.argmin(np.abs(item.beats[None] - found[:, None]), axis=1)]
            errors += list(off[np.abs(off) < 0.07])
    every = [row for style in rows.values() for row in style]
    head = f"held out: {len(every)}  F {_mean(every, 0):.3f}  downbeat F {_mean(every, 1):.3f}"
    lines = [f"{head}  loss {np.mean(losses):.4f}"]
    if errors:
        lines[0] += (
            f"  error of hits {1e3 * np.median(errors):+.1f} ms, |error| {1e3 * np.median(np.abs(errors)):.1f} ms"
        )
    if not brief:
        lines += [
            f"  {style:24s} {len(row):4d}  {_mean(row, 0):.3f}  {_mean(row, 1):.3f}"
            for style, row in sorted(rows.items())
        ]
    return "\n".join(lines)


def _mean(rows: list[tuple[float, float]], column: int) -> float:
    values: list[Any] = [row[column] for row in rows if np.isfinite(row[column])]
    return float(np.mean(values)) if values else float("nan")
