"""Weights of recorded takes by how useful they are (H026)."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.partner.point_clouds import ends_cloud
from live.motion.partner.units import Example, Units, cut_units
from live.motion.partner_live.example_weights import (
    JUDGED_MOMENTS,
    MIN_WEIGHT,
    example_gains,
    judged_rows,
    weights_of_gains,
)
from live.motion.partner_live.follower_model import learn_follower
from tests.motion.partner_live.led_pairs import RATE, led_pair


def kernel_of(feature: np.ndarray, ridge: float = 0.1) -> np.ndarray:
    """A Gaussian kernel of features (n, D), with its ridge."""
    square = ((feature[:, None] - feature[None]) ** 2).sum(axis=-1)
    return np.exp(-0.5 * square) + ridge * np.eye(len(feature))


def takes_of_one_function(seed: int, count: int, rows: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Features (n, 2), targets (n, 3) that follow from them, and the take of each row."""
    chance = np.random.default_rng(seed)
    feature = chance.uniform(-2.0, 2.0, (count * rows, 2))
    target = np.column_stack((np.sin(feature[:, 0]), np.cos(feature[:, 1]), feature.sum(axis=1)))
    return feature, target + 0.02 * chance.standard_normal(target.shape), np.repeat(np.arange(count), rows)


def test_gains_are_those_of_learning_again_without_the_takes() -> None:
    feature, target, take = takes_of_one_function(3, 4, 20)
    kernel = kernel_of(feature)

    def error(of: int, *left_out: int) -> float:
        known = ~np.isin(take, (of, *left_out))
        plain = kernel + 10.0
        given = np.linalg.solve(plain[np.ix_(known, known)], target[known])
        away = plain[np.ix_(take == of, known)] @ given - target[take == of]
        return float(np.linalg.norm(away, axis=1).mean())

    gains = example_gains(kernel, target, take)
    for i in range(4):
        for j in range(4):
            if i != j:
                assert gains[i, j] == pytest.approx(np.log(error(i, j) / error(i)), abs=1e-6)
    assert np.isnan(np.diag(gains)).all()


def test_a_take_that_contradicts_the_others_weighs_less_and_the_others_do_not() -> None:
    feature, target, take = takes_of_one_function(5, 6, 40)
    whole = weights_of_gains(example_gains(kernel_of(feature), target, take))
    assert (whole == 1.0).all()
    target[take == 2] = np.roll(target[take == 2], 13, axis=0)
    weight = weights_of_gains(example_gains(kernel_of(feature), target, take))
    assert weight[2] < 0.3
    assert (np.delete(weight, 2) > 0.7).all()


def test_weights_are_bounded_and_few_or_short_takes_are_not_judged() -> None:
    gains = np.array([[np.nan, -50.0, 3.0], [-50.0, np.nan, 3.0], [-50.0, 0.0, np.nan]])
    assert weights_of_gains(gains).tolist() == [MIN_WEIGHT, MIN_WEIGHT, 1.0]
    assert judged_rows(np.repeat(np.arange(2), 200)) is None
    assert judged_rows(np.repeat(np.arange(9), 20)) is None
    assert judged_rows(np.repeat(np.arange(70), 80)) is None
    rows = judged_rows(np.repeat(np.arange(5), (400, 30, 500, 600, 100)))
    assert rows is not None
    assert len(rows) <= JUDGED_MOMENTS
    assert not ((rows >= 400) & (rows < 430)).any()


def spoiled(example: Example) -> Example:
    """The take with its follower a third of it late."""
    clip = example.follower
    late = clip.sample_count // 3
    moved = {name: np.roll(getattr(clip, name), late, axis=0) for name in ("root_position", "rotation", "contact")}
    follower = replace(clip, **moved)
    return replace(example, name="spoiled", follower=follower, target=ends_cloud(follower))


def takes(count: int) -> list[Example]:
    """Parts of one long dance, so that they are of one kind, as takes of twelve seconds."""
    found = []
    for n in range(count):
        _, units = led_pair(41, samples=700)
        found.append(replace(units.examples[0], name=f"take {n}"))
    return found


@pytest.mark.long
def test_the_follower_trusts_a_spoiled_take_less() -> None:
    known = takes(3)
    units: Units = cut_units([*known, spoiled(known[0])])
    model = learn_follower(units, RATE)
    assert model.example_weight[3] < 0.5
    assert (model.example_weight[:3] == 1.0).all()
    of_spoiled = model.moments.example == 3
    assert (model.example_cost[of_spoiled] > 0.05).all()
    assert (model.example_cost[~of_spoiled] == 0.0).all()
    alike = learn_follower(units, RATE, weighs=False)
    assert (alike.example_weight == 1.0).all()
    said, said_alike = (np.abs(one.weights[of_spoiled]).sum() for one in (model, alike))
    assert said < 0.5 * said_alike
    again = learn_follower(units, RATE)
    assert np.array_equal(again.weights, model.weights)
