"""The plan view: a circle at each dancer, a triangle in the facing direction, a path behind each dancer."""

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Camera, Scene
from live.render.adaptive_quality import SOFTWARE
from live.render.camera import project_points
from live.render.renderer import Renderer
from tests.render.poses import ARMS_DOWN
from tests.render.test_renderer import read, scene, stage_view

pytestmark = pytest.mark.gl
SIZE = (320, 200)
ABOVE = Camera((0.0, 27.0, 0.0), (0.0, 0.0, 0.0), 20.0)
RED = 0


def scene_from_above(count):
    of = scene(count)
    return Scene(of.stage_size, ABOVE, count, of.joint_count)


@pytest.fixture
def plan(gl_context):
    """Draws views with the plan at an amount."""
    kept = []

    def make(count):
        of = scene_from_above(count)
        renderer, target = Renderer(gl_context, of, size=SIZE, quality=SOFTWARE), gl_context.simple_framebuffer(SIZE)
        kept.extend((renderer, target))

        def draw(view, amount=1.0):
            view.picture = picture_row(of)
            view.picture[BY_ADDRESS["/dance/camera/plan"].first] = amount
            renderer.draw(view, target)
            return read(target).astype(int)

        return draw

    yield make
    for thing in kept:
        thing.release()


@pytest.mark.long
def test_circles_mark_dancers_and_triangles_point_in_facing_direction(plan, golden):
    places = [(-3.0, -1.5), (0.0, 1.0), (3.0, 0.0)]
    view = stage_view(
        [(ARMS_DOWN, at, turn, n) for n, (at, turn) in enumerate(zip(places, (0.0, 90.0, 200.0), strict=True))]
    )
    seen = plan(3)(view)
    bare = plan(1)(stage_view([(ARMS_DOWN, (0.0, 99.0), 0.0, 0)]))
    marks = (np.abs(seen - bare).max(axis=2) > 12).astype(int)
    for (x, z), turn in zip(places, np.radians((0.0, 90.0, 200.0)), strict=True):
        away = 0.30
        centre = project_points(ABOVE, SIZE, [(x, 0.0, z)])[0]
        ahead = project_points(ABOVE, SIZE, [(x + away * np.sin(turn), 0.0, z + away * np.cos(turn))])[0] - centre
        rows, columns = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
        off = np.stack([columns + 0.5 - centre[0], rows + 0.5 - centre[1]])
        radius = np.hypot(*off)
        assert marks[radius < 5].all()
        assert not marks[(radius > 12) & (radius < 15)].any()
        bright = seen.sum(axis=2) * (radius < 6)
        along = (off[0] * ahead[0] + off[1] * ahead[1]) / np.hypot(*ahead)
        beside = np.abs(off[0] * ahead[1] - off[1] * ahead[0]) / np.hypot(*ahead)
        tip, base = (bright[(beside > 2.0) & (radius < 6) & side].mean() for side in (along > 2.0, along < -1.0))
        assert base > 1.05 * tip  # the triangle is broad behind and narrow ahead
    golden(seen.astype(np.uint8), "plan", law=lambda picture: (picture.max(axis=2) > 60).mean() > 0.01)


@pytest.mark.long
def test_paths_fade_behind_dancers_and_clear_after_jump(plan):
    draw = plan(1)

    def at(x, beat):
        view = stage_view([(ARMS_DOWN, (x, 0.0), 90.0, 0)])
        view.beat = beat
        return draw(view)

    at(-3.0, 0.0)
    for step in range(1, 33):
        seen = at(-3.0 + step * 0.15, step / 8.0)
    ground = at(50.0, 200.0)  # long after: no way is left, and nobody is there
    more = np.abs(seen - ground).sum(axis=2)
    levels = []
    for x in (-2.5, -1.0, 0.5):
        spot = project_points(ABOVE, SIZE, [(x, 0.0, 0.0)])[0].astype(int)
        levels.append(more[spot[1] - 2 : spot[1] + 3, spot[0] - 1 : spot[0] + 2].max())
    assert 12 < levels[0] < levels[1] < levels[2]
    side = project_points(ABOVE, SIZE, [(-1.0, 0.0, 1.0)])[0].astype(int)
    assert more[side[1], side[0]] < 6


def test_half_plan_lies_between_picture_and_plan(plan):
    draw, view = plan(3), stage_view([(ARMS_DOWN, (x, 0.0), 0.0, 0) for x in (-2.0, 0.0, 2.0)])
    off, half, on = (draw(view, amount).mean() for amount in (0.0, 0.5, 1.0))
    assert min(off, on) < half < max(off, on)
