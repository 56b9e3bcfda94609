"""A picture's row in the renderer: it draws what a scene would that had been made so from the start, bit by bit."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, CAMERA, COLOURS_START, picture_row
from live.base.stage_snapshot import Camera, Look, Scene
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.renderer import Renderer
from tests.render.test_renderer import SIZE, crowd, read, scene

pytestmark = pytest.mark.gl
OTHER = Scene(
    (10.0, 8.0),
    Camera((7.0, 2.5, 4.0), (0.5, 1.0, 0.0), 50.0),
    Look(key_light=(1.0, 0.3, 0.1), background=(0.1, 0.0, 0.02), haze=0.08, ambient=0.4, key_direction=(0.6, -1.0, 0.1),
         group_colours=((0.1, 0.8, 0.2), (0.9, 0.1, 0.8), (0.2, 0.2, 0.9))),
    12, 22,
)  # fmt: skip


@pytest.fixture
def made(gl_context):
    """A renderer, and a function that draws one view with it and gives its pixels."""
    kept = []

    def make(of, quality=SOFTWARE):
        renderer = Renderer(gl_context, of, size=SIZE, quality=quality)
        target = gl_context.simple_framebuffer(SIZE)
        kept.extend((renderer, target))
        assert isinstance(gl_context, moderngl.Context)

        def draw(view, row=None, times=1):
            view.picture = row
            for _ in range(times):
                renderer.draw(view, target)
            return read(target)

        return draw

    yield make
    for thing in kept:
        thing.release()


@pytest.mark.parametrize("quality", [SOFTWARE, HARDWARE], ids=["software", "card"])
def test_a_row_draws_what_a_scene_made_so_would(made, quality):
    from_start, changed = made(OTHER, quality), made(scene(12), quality)
    plain = changed(crowd())
    assert np.array_equal(changed(crowd(), picture_row(scene(12))), plain)  # the scene's own row changes nothing
    there = changed(crowd(), picture_row(OTHER), times=2)  # in the second frame light and camera stand
    assert np.array_equal(there, from_start(crowd()))
    assert np.array_equal(changed(crowd(), times=2), plain)  # and back


def test_while_light_moves_the_picture_is_nearly_what_it_is_when_it_stands(made):
    draw = made(scene(12))
    row = picture_row(scene(12))
    draw(crowd())
    row[BY_ADDRESS["/dance/light/rim"].first] = 1.5
    moving, standing = draw(crowd(), row).astype(int), draw(crowd(), row).astype(int)
    assert np.abs(moving - standing).mean() < 1.0


def test_what_changed_in_the_dark_is_there_when_the_light_comes_back(made):
    draw, view = made(scene(12)), crowd()
    draw(view)
    view.brightness = 0.0
    assert draw(view, picture_row(OTHER)).max() == 0
    view.brightness = 1.0
    assert np.array_equal(draw(view, picture_row(OTHER)), made(OTHER)(crowd()))


def test_level_is_darker_down_to_black_and_saturation_goes_down_to_grey(made):
    draw, row = made(scene(12)), picture_row(scene(12))
    means = []
    for level in (1.0, 0.5, 0.1, 0.0):
        row[BY_ADDRESS["/dance/light/level"].first] = level
        means.append(draw(crowd(), row).mean())
    assert means == sorted(means, reverse=True)
    assert means[-1] == 0.0
    row[BY_ADDRESS["/dance/light/level"].first] = 1.0
    row[BY_ADDRESS["/dance/light/saturation"].first] = 0.0
    grey = draw(crowd(), row).astype(int)
    assert np.ptp(grey, axis=2).max() <= 1


def test_a_camera_that_looks_nowhere_leaves_the_last_one(made):
    draw, row = made(scene(12)), picture_row(scene(12))
    before = draw(crowd(), row)
    row[BY_ADDRESS["/dance/camera/target"].row_slice] = row[BY_ADDRESS["/dance/camera/eye"].row_slice]
    assert np.array_equal(draw(crowd(), row, times=2), before)
    assert CAMERA.stop <= COLOURS_START


def test_colours_survive_a_new_size(gl_context):
    renderer = Renderer(gl_context, scene(12), size=SIZE, quality=SOFTWARE)
    view = crowd()
    row = picture_row(replace(OTHER, camera=Camera(), look=replace(Look(), group_colours=OTHER.look.group_colours)))
    view.picture = row
    small, large = gl_context.simple_framebuffer((160, 90)), gl_context.simple_framebuffer(SIZE)
    renderer.draw(view, large)
    first = read(large)
    renderer.resize((160, 90))
    renderer.draw(view, small)
    renderer.resize(SIZE)
    renderer.draw(view, large)
    assert np.array_equal(read(large), first)
    for thing in (renderer, small, large):
        thing.release()
