"""Clothing colours of dancers: by group, with small differences between dancers."""

import numpy as np

from live.base.stage_snapshot import GROUP_COLOURS
from live.render.dancers.wardrobe import CLOTH, SECOND, SKIN, dancer_colours

COLOURS = np.array(GROUP_COLOURS, np.float32)


def test_cloth_is_nearest_to_group_colour() -> None:
    group = np.arange(60, dtype=np.int32) % len(COLOURS)
    cloth = (dancer_colours(group, COLOURS)[:, CLOTH, :3] / 255.0) ** 2
    hue = cloth / np.linalg.norm(cloth, axis=1, keepdims=True)
    wanted = COLOURS / np.linalg.norm(COLOURS, axis=1, keepdims=True)
    np.testing.assert_array_equal((hue @ wanted.T).argmax(axis=1), group)


def test_dancers_of_one_group_differ_slightly() -> None:
    clothes = dancer_colours(np.zeros(40, np.int32), COLOURS)
    assert len(np.unique(clothes[:, CLOTH], axis=0)) > 30
    assert clothes[:, SKIN, 0].std() > 10.0


def test_dancer_keeps_skin_colour_after_group_change() -> None:
    before, after = dancer_colours(np.zeros(5, np.int32), COLOURS), dancer_colours(np.ones(5, np.int32), COLOURS)
    np.testing.assert_array_equal(before[:, SKIN], after[:, SKIN])
    assert (before[:, CLOTH] != after[:, CLOTH]).any()


def test_group_colours_wrap_around_and_tights_are_darker() -> None:
    clothes = dancer_colours(np.array([1, 1 + len(COLOURS)], np.int32), COLOURS).astype(int)
    assert np.abs(clothes[0, CLOTH, :3] - clothes[1, CLOTH, :3]).max() < 60
    assert (clothes[:, SECOND, :3] < clothes[:, CLOTH, :3]).all()
