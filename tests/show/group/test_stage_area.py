"""Tests of the stage set: an edit changes only the items that it edits."""

import numpy as np
import pytest

from live.agents.crowd.obstacles import Surroundings
from live.show.group.stage_area import place_item, update_set
from live.show.patch.section_stage import ObstacleSection

CHAIR = ObstacleSection(name="chair", at=(1.0, 2.0), radius=0.4)
TABLE = ObstacleSection(name="table", at=(-1.0, 0.0), radius=0.8)
WALL = ObstacleSection(name="wall", at=(-2.0, 1.0), wall_to=(2.0, 1.0))


def make_surroundings(*items):
    around = Surroundings()
    for item in items:
        place_item(around, item)
    return around


def places(around):
    rows = around.obstacles[: around.obstacle_count, :3]
    return dict(zip(around.obstacle_names, rows.tolist(), strict=True))


def test_items_become_round_obstacles_and_walls():
    around = make_surroundings(CHAIR, WALL)
    assert places(around)["chair"] == pytest.approx([1.0, 2.0, 0.4])
    assert around.wall_count == 1
    assert np.asarray(around.walls[0][:4]) == pytest.approx([-2.0, 1.0, 2.0, 1.0])


def test_live_move_is_kept_when_edit_does_not_change_item():
    around = make_surroundings(CHAIR, TABLE)
    around.set_obstacle("chair", 3.0, 3.0, 0.4)
    moved = TABLE.model_copy(update={"at": (0.0, 0.0)})
    update_set(around, (CHAIR, TABLE), (CHAIR, moved))
    assert places(around)["chair"][:2] == [3.0, 3.0]
    assert places(around)["table"][:2] == [0.0, 0.0]


def test_removed_items_disappear_and_obstacle_can_become_wall():
    around = make_surroundings(CHAIR, TABLE)
    update_set(around, (CHAIR, TABLE), (WALL.model_copy(update={"name": "table"}),))
    assert around.obstacle_names == ()
    assert around.wall_count == 1
    update_set(around, (WALL.model_copy(update={"name": "table"}),), ())
    assert around.wall_count == 0
