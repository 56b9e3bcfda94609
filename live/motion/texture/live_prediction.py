"""What the last beat of the legs tells about the upper body to come: kernel ridge regression for the stage.

Offline, the prediction sees what legs do after each moment (`upper_body_regression`). Here it is causal: at every
eighth of a beat knees and ankles of the last beat tell where the upper joints turn one and a half eighths later; the
kernel `follow_legs` runs it. As there, takes of other choreographies decide how much of it is believed (P023).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int64
from live.motion.texture.driver_choice import GROUPS, MAX_SAMPLES, SMOOTHNESS, gaussian, solve_sums
from live.motion.texture.fragment_search import squared_distances
from live.motion.texture.live_texture_kernels import FEATURES, LAGS, LIMIT, PER_BEAT, UPPER_COUNT
from live.motion.texture.take_splits import Fold
from live.motion.texture.texture_settings import UPPER

EIGHTH: Final = PER_BEAT // 8
"""Samples of an eighth of a beat."""
AHEAD: Final = 3 * EIGHTH // 2
"""How far ahead is predicted [samples]: a curve through predictions, drawn in the eighth after the last, is late by
that."""
CENTRES: Final = 128
"""Samples on which kernels are centred: costs on stage grow with it."""
LINEAR_RIDGE: Final = 3.0
"""Weight of the penalty of the slopes, against the mean variance of the legs' coordinates."""
LEAST_DEVIATION_M: Final = 0.01
"""A coordinate of a leg that varies less than this [m] is not scaled up further."""
ROUNDING: Final = 2.0**-16
"""What is learnt is rounded to this, so that the last bits of a library do not matter."""
_OUTPUTS: Final = 3 * UPPER_COUNT
_INPUTS: Final = LAGS * FEATURES


@dataclass(frozen=True, slots=True, eq=False)
class LivePrediction:
    """Kernel ridge regression of 39 values: rotation vectors of the upper joints in their parents' axes, from the mean.

    Without centres (M = 0) it tells nothing.
    """

    middle: Float32
    """Mean of the legs in the last beat [m], (LAGS * FEATURES,)."""
    scale: Float32
    """Their scale, with the width of the kernel, (LAGS * FEATURES,)."""
    centres: Float32
    """Scaled legs, (LAGS * FEATURES, M)."""
    weights: Float32
    """Weights of each centre, damped, (M, 39)."""
    slopes: Float32
    """Weights of the scaled legs themselves, within `LIMIT`, damped, (LAGS * FEATURES, 39)."""
    gains: Float64 = field(default_factory=lambda: np.zeros(UPPER_COUNT))
    """How much of the prediction of each joint is believed, 0 to 1, (13,)."""

    @classmethod
    def nothing(cls) -> "LivePrediction":
        """Return the prediction that always is the mean pose."""
        none, one = np.zeros(_INPUTS, np.float32), np.ones(_INPUTS, np.float32)
        return cls(
            none,
            one,
            np.zeros((_INPUTS, 0), np.float32),
            np.zeros((0, _OUTPUTS), np.float32),
            np.zeros((_INPUTS, _OUTPUTS), np.float32),
        )

    def predict(self, legs: Float64) -> Float64:
        """Return the rotation vectors (T, 39) at windows of legs (T, LAGS * FEATURES), as the kernel does."""
        scaled = (legs - self.middle) * self.scale
        far = squared_distances(scaled, self.centres.T.astype(np.float64))
        return np.asarray(gaussian(far, 1.0) @ self.weights + _within(scaled) @ self.slopes)


def leg_windows(legs: Float64, starts: Sequence[int]) -> Float64:
    """Return the last beat of legs (S, FEATURES) at each sample, newest first, (S, LAGS * FEATURES).

    `starts` are the first sample of each clip and the end of the last. Before a clip its beginning is held.
    """
    first = np.repeat(starts[:-1], np.diff(starts))
    at = np.arange(len(legs))[:, None] - EIGHTH * np.arange(LAGS)
    return np.asarray(legs[np.maximum(at, first[:, None])].reshape(len(legs), _INPUTS))


def learn_live_prediction(
    legs: Float64, vectors: Float64, starts: Sequence[int], folds: Sequence[Fold]
) -> tuple[LivePrediction, Float64]:
    """Learn the vectors (S, 39) from the legs (S, FEATURES), PER_BEAT samples a beat; clips begin at `starts`.

    Returns the prediction and what it tells of every sample, (S, 39), without having learnt from the fold that tests
    it. Deterministic.
    """
    told = np.zeros_like(vectors)
    ahead = np.zeros(len(vectors), np.int64)
    for begin, end in pairwise(starts):
        ahead[begin:end] = np.minimum(np.arange(begin, end) + AHEAD, end - 1)
    windows = leg_windows(legs, starts)
    step = EIGHTH * max(1, -(-len(vectors) // (EIGHTH * MAX_SAMPLES)))
    rows: Int64 = np.arange(0, len(vectors), step)
    usable = [fold for fold in folds if fold.learnt[rows].any()]
    if not usable:
        return LivePrediction.nothing(), told
    targets = vectors[ahead]
    errors = [_left_out(windows, targets, rows, usable, *one)[0] for one in SMOOTHNESS]
    width, ridge = SMOOTHNESS[int(np.argmin(errors))]
    _, raw = _left_out(windows, targets, rows, usable, width, ridge)
    gains = _gains(targets, raw, usable)
    if not gains.any():
        return LivePrediction.nothing(), told
    middle, scale, centres, weights, slopes = _fit(windows[rows], targets[rows], width, ridge)
    each = np.repeat(gains, 3)
    told[ahead] = raw * each
    for begin, end in pairwise(starts):
        told[begin : min(begin + AHEAD, end)] = told[min(begin + AHEAD, end - 1)]
    prediction = LivePrediction(
        _float32(middle),
        _float32(scale),
        _float32(centres.T),
        _float32(weights * each),
        _float32(slopes * each),
        gains,
    )
    return prediction, _rounded(told)


def _fit(
    windows: Float64, targets: Float64, width: float, ridge: float
) -> tuple[Float64, Float64, Float64, Float64, Float64]:
    """Return the middle, the scale, the scaled centres (M, D), their weights (M, 39) and the slopes (D, 39)."""
    middle = windows.mean(axis=0)
    scale = 1.0 / (np.maximum(windows.std(axis=0), LEAST_DEVIATION_M) * np.sqrt(windows.shape[1]) * width)
    scaled = (windows - middle) * scale
    near = _within(scaled)
    products = near.T @ near
    penalty = LINEAR_RIDGE * float(np.trace(products)) / len(products)
    slopes = solve_sums(products, near.T @ targets, np.eye(len(products)), max(penalty, 1e-12))
    centres = scaled[np.unique(np.linspace(0, len(scaled) - 1, min(CENTRES, len(scaled))).astype(np.int64))]
    kernel, between = (gaussian(squared_distances(one, centres), 1.0) for one in (scaled, centres))
    left = targets - near @ slopes
    weights = solve_sums(kernel.T @ kernel, kernel.T @ left, between, ridge * len(kernel))
    return middle, scale, centres, weights, slopes


def _within(scaled: Float64) -> Float64:
    return np.clip(scaled, -LIMIT, LIMIT)


def _left_out(
    windows: Float64, targets: Float64, rows: Int64, folds: Sequence[Fold], width: float, ridge: float
) -> tuple[float, Float64]:
    """Return the squared error at samples left out, and the predictions of all of them, (S, 39)."""
    made, error = np.zeros_like(targets), 0.0
    for fold in folds:
        learnt = rows[fold.learnt[rows]]
        middle, scale, centres, weights, slopes = _fit(windows[learnt], targets[learnt], width, ridge)
        tested: Bool = fold.tested
        scaled = (windows[tested] - middle) * scale
        made[tested] = gaussian(squared_distances(scaled, centres), 1.0) @ weights + _within(scaled) @ slopes
        error += float(((targets[tested] - made[tested]) ** 2).sum())
    return error, made


def _gains(targets: Float64, raw: Float64, folds: Sequence[Fold]) -> Float64:
    """Return the gain of each joint, common to a group, that leaves the least squared error at samples left out."""
    tested = np.any([fold.tested for fold in folds], axis=0)
    real, made = (one[tested].reshape(-1, UPPER_COUNT, 3) for one in (targets, raw))
    gains = np.zeros(UPPER_COUNT)
    for joints in GROUPS.values():
        rows = [UPPER.index(joint) for joint in joints]
        squares = float((made[:, rows] ** 2).sum())
        if squares > 1e-12:
            gains[rows] = np.clip(float((real[:, rows] * made[:, rows]).sum()) / squares, 0.0, 1.0)
    return np.asarray(_rounded(gains))


def _rounded(values: Float64) -> Float64:
    return np.asarray(np.round(values / ROUNDING) * ROUNDING)


def _float32(values: Float64) -> Float32:
    return np.ascontiguousarray(_rounded(values), np.float32)
