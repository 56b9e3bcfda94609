"""The picture row in the renderer: same pixels as a scene created with the same values."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, CAMERA, COLOURS_START, picture_row
from live.base.stage_snapshot import Camera, Scene
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.passes.stage_pass import LONG_STILL
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.test_renderer import SIZE, crowd, read, scene

pytestmark = pytest.mark.gl
OTHER = Scene(
    (10.0, 8.0),
    Camera((7.0, 2.5, 4.0), (0.5, 1.0, 0.0), 50.0),
    12, 22, ((0.1, 0.8, 0.2), (0.9, 0.1, 0.8), (0.2, 0.2, 0.9)),
    start_values=(
        ("/dance/light/key/colour", (1.0, 0.3, 0.1)), ("/dance/light/background", (0.1, 0.0, 0.02)),
        ("/dance/light/haze", 0.08), ("/dance/light/ambient", 0.4), ("/dance/light/key/direction", (0.6, -1.0, 0.1)),
    ),
)  # fmt: skip


@pytest.fixture
def make_renderer(gl_context):
    """Creates a renderer; returns a function that draws one view with it and returns its pixels."""
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


@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[0], ids=["software", "card"])
def test_picture_row_matches_scene_with_same_values(make_renderer, quality):
    from_start, changed = make_renderer(OTHER, quality), make_renderer(scene(12), quality)
    plain = changed(crowd())
    assert np.array_equal(changed(crowd(), picture_row(scene(12))), plain)  # the scene's own row changes nothing
    there = changed(crowd(), picture_row(OTHER), times=2)  # in the second frame light and camera stand
    assert np.array_equal(there, from_start(crowd()))
    back = changed(crowd(), times=LONG_STILL + 2)  # after two changes so near each other the backdrop waits
    assert np.array_equal(back, plain)


@pytest.mark.long
def test_picture_during_light_change_is_close_to_final(make_renderer):
    draw = make_renderer(scene(12))
    row = picture_row(scene(12))
    draw(crowd())
    row[BY_ADDRESS["/dance/light/rim"].first] = 1.5
    moving, standing = draw(crowd(), row).astype(int), draw(crowd(), row).astype(int)
    assert np.abs(moving - standing).mean() < 1.0


@pytest.mark.long
def test_changes_during_blackout_appear_afterwards(make_renderer):
    draw, view = make_renderer(scene(12)), crowd()
    draw(view)
    view.brightness = 0.0
    assert draw(view, picture_row(OTHER)).max() == 0
    view.brightness = 1.0
    assert np.array_equal(draw(view, picture_row(OTHER)), make_renderer(OTHER)(crowd()))


def test_level_fades_to_black_and_saturation_to_grey(make_renderer):
    draw, row = make_renderer(scene(12)), picture_row(scene(12))
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


def test_invalid_camera_keeps_last_camera(make_renderer):
    draw, row = make_renderer(scene(12)), picture_row(scene(12))
    before = draw(crowd(), row)
    row[BY_ADDRESS["/dance/camera/target"].row_slice] = row[BY_ADDRESS["/dance/camera/eye"].row_slice]
    assert np.array_equal(draw(crowd(), row, times=2), before)
    assert CAMERA.stop <= COLOURS_START


def test_group_colours_are_kept_after_resize(gl_context):
    renderer = Renderer(gl_context, scene(12), size=SIZE, quality=SOFTWARE)
    view = crowd()
    row = picture_row(replace(OTHER, camera=Camera(), start_values=()))
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
