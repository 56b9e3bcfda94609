import numpy as np
import pytest

from live.motion.editing.foot_correction import Feet, find_feet
from live.motion.editing.turn_insertion import find_supports, height_difference
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.skeleton import SOLE_BELOW_ANKLE
from tests.motion.editing.made_steps import sketched


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


def test_d_is_the_difference_of_heights_not_the_distance_of_the_feet() -> None:
    assert height_difference(feet_of_heights([0.0, 0.1, 0.3], [0.0, 0.0, 0.4])) == pytest.approx([0.0, 0.1, 0.1])


def test_a_heel_that_rises_alone_lifts_no_sole() -> None:
    feet = feet_of_heights([0.0] * 3, [0.0] * 3)
    feet.ankle[1, 0, 1] += 0.1
    assert height_difference(feet) == pytest.approx([0.0, 0.0, 0.0])


def test_more_than_a_fifth_of_the_largest_difference_is_selected_and_the_lower_foot_carries() -> None:
    right = [0.0] * 20 + [0.0201] * 10 + [0.1] * 10 + [0.0199] * 10
    assert supports([0.0] * 50, right) == [(20, 40, 0)]
    assert supports(right, [0.0] * 50) == [(20, 40, 1)]


def test_ten_frames_of_a_hundred_a_second_are_enough_and_nine_are_not() -> None:
    right = [0.0] * 5 + [0.1] * 9 + [0.0] * 5 + [0.1] * 10 + [0.0] * 5
    assert supports([0.0] * len(right), right) == [(19, 29, 0)]
    assert supports([0.0] * len(right), right, rate=60.0) == [(5, 14, 0), (19, 29, 0)]


def test_a_stretch_is_cut_where_the_feet_change_over() -> None:
    assert supports([0.0] * 15 + [0.1] * 15, [0.1] * 15 + [0.0] * 15) == [(0, 15, 0), (15, 30, 1)]


def test_feet_that_stay_on_the_floor_support_nothing_singly() -> None:
    noise = list(np.random.default_rng(1).uniform(0.0, 0.009, 60))
    assert supports([0.0] * 60, noise) == []
    assert supports([], []) == []


def test_the_blend_window_counts_for_the_bar_but_is_not_selected() -> None:
    right = [0.0] * 10 + [0.03] * 20 + [0.2] * 20
    feet = feet_of_heights([0.0] * 50, right)
    assert find_supports(feet, 100.0, 0, 50, last=30) == []
    low = feet_of_heights([0.0] * 50, right[:30] + [0.06] * 20)
    assert [(s.start, s.stop) for s in find_supports(low, 100.0, 0, 50, last=40)] == [(10, 40)]


def test_the_point_is_where_the_ball_of_the_carrying_foot_stands() -> None:
    (support,) = find_supports(feet_of_heights([0.0] * 20, [0.1] * 20), 100.0, 0, 20)
    assert support.point == pytest.approx((0.1, 0.13))
    assert support.samples == 20


@pytest.mark.parametrize("name", ["walk", "kick", "samba", "turn"])
def test_in_sketches_the_carrying_foot_is_on_the_floor_and_the_other_is_not(name: str) -> None:
    step = sketched(name)
    first = round(step.first)
    found = find_supports(find_feet(step.clip), step.clip.sample_rate, first, first + round(step.samples_per_measure))
    assert found
    for support in found:
        contact = step.clip.contact[support.start : support.stop]
        assert contact[:, support.foot].all()
        assert contact[:, 1 - support.foot].mean() < 0.1
