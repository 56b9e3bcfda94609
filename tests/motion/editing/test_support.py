import numpy as np
import pytest

from live.motion.editing.foot_correction import Feet, find_feet
from live.motion.editing.turn_insertion import find_supports, height_difference
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SOLE_BELOW_ANKLE
from tests.motion.editing.made_steps import sketched_step


def feet_of_heights(left: list[float], right: list[float]) -> Feet:
    """Flat feet whose soles are at these heights [m], the left at x = 0.1, the right at x = -0.1."""
    height = np.array((left, right)).T
    ankle, ball = np.zeros((len(left), 2, 3)), np.zeros((len(left), 2, 3))
    ankle[..., 0] = ball[..., 0] = (0.1, -0.1)
    ankle[..., 1] = height + SOLE_BELOW_ANKLE
    ball[..., 1] = height + TOES_OVER_SOLE
    ball[..., 2] = 0.13
    return Feet(ankle, ball)


def supports(left: list[float], right: list[float], rate: float = 100.0) -> list[tuple[int, int, int]]:
    found = find_supports(feet_of_heights(left, right), rate, 0, len(left))
    return [(s.start, s.stop, s.foot) for s in found]


def test_height_difference_ignores_foot_distance() -> None:
    assert height_difference(feet_of_heights([0.0, 0.1, 0.3], [0.0, 0.0, 0.4])) == pytest.approx([0.0, 0.1, 0.1])


def test_raised_heel_does_not_lift_sole() -> None:
    feet = feet_of_heights([0.0] * 3, [0.0] * 3)
    feet.ankle[1, 0, 1] += 0.1
    assert height_difference(feet) == pytest.approx([0.0, 0.0, 0.0])


def test_lower_foot_supports_above_fifth_of_largest_difference() -> None:
    right = [0.0] * 20 + [0.0201] * 10 + [0.1] * 10 + [0.0199] * 10
    assert supports([0.0] * 50, right) == [(20, 40, 0)]
    assert supports(right, [0.0] * 50) == [(20, 40, 1)]


def test_support_lasts_at_least_tenth_of_second() -> None:
    right = [0.0] * 5 + [0.1] * 9 + [0.0] * 5 + [0.1] * 10 + [0.0] * 5
    assert supports([0.0] * len(right), right) == [(19, 29, 0)]
    assert supports([0.0] * len(right), right, rate=60.0) == [(5, 14, 0), (19, 29, 0)]


def test_support_is_split_at_foot_change() -> None:
    assert supports([0.0] * 15 + [0.1] * 15, [0.1] * 15 + [0.0] * 15) == [(0, 15, 0), (15, 30, 1)]


def test_feet_on_floor_give_no_single_support() -> None:
    noise = list(np.random.default_rng(1).uniform(0.0, 0.009, 60))
    assert supports([0.0] * 60, noise) == []
    assert supports([], []) == []


def test_blend_window_sets_threshold_but_is_not_selected() -> None:
    right = [0.0] * 10 + [0.03] * 20 + [0.2] * 20
    feet = feet_of_heights([0.0] * 50, right)
    assert find_supports(feet, 100.0, 0, 50, last=30) == []
    low = feet_of_heights([0.0] * 50, right[:30] + [0.06] * 20)
    assert [(s.start, s.stop) for s in find_supports(low, 100.0, 0, 50, last=40)] == [(10, 40)]


def test_support_point_is_ball_of_support_foot() -> None:
    (support,) = find_supports(feet_of_heights([0.0] * 20, [0.1] * 20), 100.0, 0, 20)
    assert support.point == pytest.approx((0.1, 0.13))
    assert support.samples == 20


@pytest.mark.parametrize("name", ["walk", "kick", "samba", "turn"])
def test_sketched_support_foot_alone_has_contact(name: str) -> None:
    step = sketched_step(name)
    first = round(step.first)
    found = find_supports(find_feet(step.clip), step.clip.sample_rate, first, first + round(step.samples_per_measure))
    assert found
    for support in found:
        contact = step.clip.contact[support.start : support.stop]
        assert contact[:, support.foot].all()
        assert contact[:, 1 - support.foot].mean() < 0.1
