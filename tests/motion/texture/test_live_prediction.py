"""Laws of what the last beat of legs tells: a coupling is recovered ahead of time, noise is not believed."""

import numpy as np
import pytest

from live.motion.texture.live_prediction import (
    AHEAD,
    EIGHTH,
    LivePrediction,
    learn_live_prediction,
    leg_windows,
)
from live.motion.texture.live_texture_kernels import FEATURES, LAGS, PER_BEAT
from live.motion.texture.take_splits import Fold, choreographies, make_folds

LENGTHS = (400, 500, 450)
STARTS = [0, 400, 900, 1350]
FOLDS = make_folds(LENGTHS, choreographies(3, ()))


def take(samples: int, seed: int, told: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Legs that swing without a period, once in one to four beats, and upper bodies that follow some of them."""
    chance = np.random.default_rng(seed)
    t = np.arange(samples)[:, None, None] / PER_BEAT

    def curves(count: int) -> np.ndarray:
        speed = chance.uniform(0.25, 0.6, (1, count, 6))
        return 0.04 * np.sin(2.0 * np.pi * (speed * t + chance.uniform(0.0, 1.0, (1, count, 6)))).sum(axis=-1)

    legs = np.zeros((samples, FEATURES))
    legs[:, :4] = curves(4)
    legs[:, 4:] = curves(FEATURES - 4) * 0.05
    arms = told * 4.0 * legs[:, :3] + (1.0 - told) * 4.0 * curves(3)
    return legs, np.tile(arms, 13)


def takes(told: float) -> tuple[np.ndarray, np.ndarray]:
    parts = [take(length, seed, told) for seed, length in enumerate(LENGTHS)]
    legs, vectors = (np.concatenate(one) for one in zip(*parts, strict=True))
    return legs, vectors


def test_coupling_is_predicted_ahead_of_time_at_an_unseen_take() -> None:
    prediction, left_out = learn_live_prediction(*takes(1.0), STARTS, FOLDS)
    assert prediction.gains.min() > 0.8
    legs, vectors = take(600, 77)
    made = prediction.predict(leg_windows(legs, (0, 600)))[PER_BEAT : 600 - AHEAD]
    real = vectors[PER_BEAT + AHEAD :]
    assert float(((made - real) ** 2).mean()) < 0.25 * float((real**2).mean())
    late = vectors[PER_BEAT : 600 - AHEAD]
    assert float(((made - real) ** 2).mean()) < float(((made - late) ** 2).mean())
    known = takes(1.0)[1]
    assert float(((left_out - known) ** 2).mean()) < 0.35 * float((known**2).mean())


def test_what_legs_do_not_tell_is_hardly_believed() -> None:
    legs, vectors = takes(0.0)
    prediction, left_out = learn_live_prediction(legs, vectors, STARTS, FOLDS)
    assert prediction.gains.max() < 0.4
    assert float(((left_out - vectors) ** 2).mean()) <= 1.02 * float((vectors**2).mean())


def test_windows_hold_the_past_only_and_no_other_clip() -> None:
    legs = np.random.default_rng(2).normal(size=(60, FEATURES))
    windows = leg_windows(legs, (0, 40, 60)).reshape(60, LAGS, FEATURES)
    assert np.array_equal(windows[30], legs[30 - EIGHTH * np.arange(LAGS)])
    assert np.array_equal(windows[42, 2:], np.tile(legs[40], (LAGS - 2, 1)))
    changed = legs.copy()
    changed[31:] += 1.0
    assert np.array_equal(leg_windows(changed, (0, 40, 60))[:31], leg_windows(legs, (0, 40, 60))[:31])


def test_far_legs_are_told_no_more_than_known_ones() -> None:
    prediction, _ = learn_live_prediction(*takes(1.0), STARTS, FOLDS)
    known = np.abs(prediction.predict(leg_windows(takes(1.0)[0], STARTS))).max()
    assert np.abs(prediction.predict(np.full((1, LAGS * FEATURES), 1e3))).max() < 3.0 * known


@pytest.mark.parametrize("folds", [[], [Fold(np.zeros(1350, np.bool_), np.ones(1350, np.bool_))]])
def test_without_splits_nothing_is_told(folds: list[Fold]) -> None:
    prediction, left_out = learn_live_prediction(*takes(1.0), STARTS, folds)
    assert prediction.centres.shape == LivePrediction.nothing().centres.shape
    assert not left_out.any()


def test_learning_is_deterministic() -> None:
    one, two = (learn_live_prediction(*takes(0.5), STARTS, FOLDS)[0] for _ in range(2))
    assert np.array_equal(one.weights, two.weights)
    assert np.array_equal(one.slopes, two.slopes)
