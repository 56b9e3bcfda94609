"""Tests of obstacles, walls and real dancers drawn on the floor."""

from collections.abc import Iterator

import moderngl
import numpy as np
import pytest
import shapely

from live.base.stage_snapshot import StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.passes.set_pass import SetPass
from tests.render.passes.conftest import TEXEL, Draw

pytestmark = pytest.mark.gl
LIT = (0.5, 0.3, 0.1, 0.0)


@pytest.fixture
def scenery(gl_context: moderngl.Context) -> Iterator[SetPass]:
    made = SetPass(gl_context, TEXEL)
    yield made
    made.release()


def empty_view() -> StageView:
    return StageView.allocate(0, JOINT_COUNT)


def test_obstacle_is_dark_with_rim_brightest_at_back(floor: Draw, scenery: SetPass) -> None:
    view = empty_view()
    view.obstacle[0], view.obstacle_count = (1.0, 0.5, 0.8, 1.0), 1
    drawn = floor(scenery, view)
    d = np.hypot(drawn.x - 1.0, drawn.z - 0.5) - 0.8
    taken = drawn.light[..., 3]
    assert taken[d < -0.1].min() > 0.6  # light that the floor loses
    assert taken[d > 0.5].max() < 0.05
    rim = drawn.brightness
    assert rim[np.abs(d) < 0.02].min() > 3.0 * rim[np.abs(d) > 0.2].max()
    assert drawn.at(1.0, -0.3)[:3].sum() > 1.5 * drawn.at(1.0, 1.3)[:3].sum()


def test_obstacle_hides_element_light(floor: Draw, scenery: SetPass) -> None:
    view = empty_view()
    view.obstacle[0], view.obstacle_count = (1.0, 0.5, 0.8, 1.0), 1
    drawn = floor(scenery, view, LIT)
    assert drawn.at(1.0, 0.5)[0] < 0.4 * LIT[0]
    np.testing.assert_allclose(drawn.at(-3.0, 0.5), LIT, atol=1e-6)


def test_wall_is_drawn_along_its_length_only(floor: Draw, scenery: SetPass) -> None:
    view = empty_view()
    view.wall[0], view.wall_count = (-2.0, -1.0, 1.0, 2.0), 1
    drawn = floor(scenery, view)
    wall = shapely.LineString([(-2.0, -1.0), (1.0, 2.0)])
    d = shapely.distance(wall, shapely.points(drawn.x, drawn.z))
    assert drawn.light[..., 3][d < 0.02].min() > 0.4
    assert not drawn.light[d > 0.7].any()


def test_real_dancer_is_marked_by_light(floor: Draw, scenery: SetPass) -> None:
    view = empty_view()
    view.obstacle[0], view.obstacle_count = (1.0, 0.5, 0.25, 0.0), 1
    drawn = floor(scenery, view, LIT)
    assert drawn.light[..., 0].min() >= LIT[0] - 1e-6
    assert drawn.at(1.25, 0.5)[0] > LIT[0] + 0.03


def test_excess_obstacles_and_walls_are_ignored(floor: Draw, scenery: SetPass) -> None:
    view = empty_view()
    view.obstacle[:, 2:] = 0.5, 1.0
    view.obstacle_count = view.wall_count = 5000
    assert np.isfinite(floor(scenery, view).light).all()
    view.obstacle_count = view.wall_count = 0
    assert not floor(scenery, view).light.any()
