"""Tests of stage resizing during a show: limits and border movement."""

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.stage_snapshot import FLOOR_MARGIN
from live.show.group.formations import fit_slots
from live.show.group.stage_area import StageArea
from live.show.patch.section_stage import StageSection


def make_stage_area(width=9.0, depth=6.0):
    return StageArea(StageSection(width=width, depth=depth))


def resize(of, width, depth, *, dancers=4, beat=0.0):
    return of.resize(width, depth, dancers=dancers, beat=beat, beats_per_measure=4.0)


def test_steering_size_changes_at_once_and_border_moves_smoothly():
    stage = make_stage_area()
    half = stage.half
    assert resize(stage, 5.0, 4.0, beat=10.0)
    assert stage.half is half
    np.testing.assert_array_equal(half, [2.5, 2.0])
    borders = []
    for beat in np.linspace(10.0, 40.0, 601):
        stage.tick(float(beat))
        borders.append(stage.border.copy())
    moves = -np.diff(borders, axis=0)
    assert (moves >= 0.0).all()
    assert moves[0].max() < 0.2 * moves.max()  # no jerk when it begins
    taken = 0.05 * (np.count_nonzero(moves[:, 0]))
    assert moves[:, 0].max() / 0.05 < 0.25  # metres in a beat
    assert taken > 2.0 / 0.12 - 0.2
    np.testing.assert_array_equal(borders[-1], half)


def test_border_arrives_after_decided_measures_end():
    stage = make_stage_area()
    resize(stage, 8.9, 6.0)
    stage.tick(7.9)
    assert (stage.border > stage.half).any()
    stage.tick(8.0)
    np.testing.assert_array_equal(stage.border, stage.half)


def test_border_does_not_jump_when_resized_during_movement():
    stage = make_stage_area()
    resize(stage, 4.0, 4.0)
    stage.tick(9.0)
    before = stage.border.copy()
    assert resize(stage, 12.0, 8.0, beat=9.0)
    stage.tick(9.0)
    np.testing.assert_allclose(stage.border, before)
    assert not resize(stage, 12.0, 8.0, beat=9.5)


@pytest.mark.parametrize("size", [(9.0, 6.0), (3.0, 2.5), (60.0, 40.0)])
def test_stage_size_is_limited_by_floor_and_twice_patch_size(size):
    stage = make_stage_area(*size)
    most = 2.0 * stage.largest
    assert (most <= 2.0 * np.array(size) + 1e-9).all()
    assert (most < np.array(size) + 2.0 * FLOOR_MARGIN).all()
    assert resize(stage, *most.tolist())
    for width, depth in ((most[0] + 0.01, most[1]), (most[0], most[1] + 0.01), (1.99, 5.0), (np.nan, 5.0), (5, np.inf)):
        with pytest.raises(PersonError, match="cannot be"):
            resize(stage, width, depth)


def test_stage_needs_room_for_all_dancers_unless_patch_size():
    stage = make_stage_area()
    with pytest.raises(PersonError, match="20 dancers"):
        resize(stage, 4.0, 3.9, dancers=20)
    assert resize(stage, 4.0, 4.0, dancers=20)
    assert resize(stage, 9.0, 6.0, dancers=500)


def test_formations_shrink_only_when_too_large():
    chance = np.random.default_rng(3)
    half = np.array([3.0, 2.0])
    for _ in range(50):
        slots = chance.uniform(0.2, 6.0) * chance.uniform(-1.0, 1.0, (12, 2)) + chance.uniform(-6.0, 6.0, 2)
        new = fit_slots(slots, half)
        assert (np.abs(new) <= half - 0.3 + 1e-9).all()
        ratio = np.linalg.norm(new[1:] - new[0], axis=1) / np.linalg.norm(slots[1:] - slots[0], axis=1)
        np.testing.assert_allclose(ratio, ratio[0])
        assert ratio[0] <= 1.0 + 1e-9
    np.testing.assert_allclose(fit_slots(slots * 0.01, half), slots * 0.01)


def test_border_is_correct_at_negative_beats():
    stage = make_stage_area()
    stage.tick(-4.0)
    np.testing.assert_array_equal(stage.border, [4.5, 3.0])
    resize(stage, 5.0, 4.0, beat=-4.0)
    stage.tick(-4.0)
    np.testing.assert_array_equal(stage.border, [4.5, 3.0])
