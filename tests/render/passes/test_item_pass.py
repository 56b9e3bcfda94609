"""Set items on the stage: lighting, occlusion with dancers, and shadow."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS
from live.base.set_geometry import SetItem
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.test_renderer import SIZE, read, scene, standing

pytestmark = pytest.mark.gl


@pytest.fixture
def draw_items(gl_context):
    """Draws one dancer in the middle with items."""

    def draw(*items, quality=SOFTWARE):
        renderer = Renderer(gl_context, replace(scene(1), items=items), size=SIZE, quality=quality)
        target = gl_context.simple_framebuffer(SIZE)
        renderer.draw(standing(), target)
        seen = read(target).astype(int)
        renderer.release()
        target.release()
        return seen

    return draw


def pixel(*at):
    return project_points(scene(1).camera, SIZE, [at])[0].astype(int)


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_item_and_dancer_occlude_each_other_by_depth(draw_items, quality):
    bare = draw_items(quality=quality)
    red = {"size": (1.5, 2.2, 0.4), "colour": (0.6, 0.02, 0.02)}
    before, behind = (
        draw_items(SetItem("box", (0.0, 1.5), **red), quality=quality),
        draw_items(SetItem("box", (0.0, -1.5), **red), quality=quality),
    )
    x, y = pixel(0.0, 1.2, 0.1)
    assert before[y, x, 0] > 60 > 2 * before[y, x, 1]
    assert np.abs(behind[y, x] - bare[y, x]).max() < 12
    x, y = pixel(0.5, 1.2, -1.3)
    assert behind[y, x, 0] > 60 > 2 * behind[y, x, 1]


@pytest.mark.long
def test_item_casts_shadow_away_from_key_light(draw_items):
    bare, seen = draw_items(), draw_items(SetItem("box", (2.0, 0.0), (0.8, 1.0, 0.8)))
    towards = np.array(BY_ADDRESS["/dance/light/key/direction"].start)
    x, z = towards[[0, 2]] / abs(towards[1])
    at = pixel(2.0 + 0.85 * x - 0.15, 0.0, 0.85 * z)
    other = pixel(2.0 - 0.9 * x + 0.3, 0.0, 0.3 - 0.9 * z)
    assert seen[at[1], at[0]].sum() < 0.85 * bare[at[1], at[0]].sum()
    assert seen[other[1], other[0]].sum() > 0.95 * bare[other[1], other[0]].sum()


def test_items_far_from_dancers_are_lit(draw_items, golden):
    seen = draw_items(
        SetItem("cylinder", (-4.0, -2.0), (0.6, 3.0, 0.6), colour=(0.3, 0.3, 0.3)),
        SetItem("steps", (3.0, -2.0), (2.0, 1.0, 1.5)),
    )
    x, y = pixel(-4.0, 1.5, -1.7)
    assert seen[y, x].max() > 60
    golden(seen.astype(np.uint8), "items", law=lambda picture: picture[y, x].max() > 60)


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_another_stage_and_items_look_as_in_a_renderer_made_for_them(gl_context, quality):
    box, steps = SetItem("box", (2.0, 0.0), (0.8, 1.0, 0.8)), SetItem("steps", (-3.0, -2.0), (2.0, 1.0, 1.5), steps=40)
    stages = (((12.0, 8.0), ()), ((7.0, 15.0), (box,)), ((16.0, 8.0), (box, *[steps] * 30)), ((12.0, 8.0), ()))
    target = gl_context.simple_framebuffer(SIZE)
    view = standing()
    view.obstacle_count, view.obstacle[0, :3] = 1, (1.0, 1.0, 0.5)
    edited = Renderer(gl_context, replace(scene(1), stage_size=(10.0, 6.0)), size=SIZE, quality=quality)
    pictures = []
    for stage_size, items in stages:
        edited.set_stage(stage_size, items)
        edited.draw(view, target)
        pictures.append(read(target).astype(int))
        fresh = Renderer(gl_context, replace(scene(1), stage_size=stage_size, items=items), size=SIZE, quality=quality)
        fresh.draw(view, target)
        assert np.array_equal(read(target).astype(int), pictures[-1])
        fresh.release()
    assert np.abs(pictures[1] - pictures[0]).max() > 60
    assert np.abs(pictures[2] - pictures[1]).max() > 60
    edited.release()
    target.release()
