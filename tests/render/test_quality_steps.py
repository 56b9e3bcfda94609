"""The quality steps as pictures: reduced cost, same stage, and a sharp overlay."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.renderer import Renderer
from tests.render.passes.test_passes import CAMERA, SCENE, has_detail, row_with, three_dancers
from tests.render.test_renderer import read, scene

pytestmark = pytest.mark.gl
SIZE = (256, 144)


@pytest.fixture(
    scope="module", params=[SOFTWARE, pytest.param(HARDWARE, marks=pytest.mark.long)], ids=["software", "card"]
)
def quality_renderer(request, headless_context):
    """A renderer with all its quality steps, and a function that draws a view with it."""
    with headless_context:
        renderer = Renderer(headless_context, SCENE, size=SIZE, quality=request.param, steps=True)
        target = headless_context.simple_framebuffer(SIZE)

    def draw(view=None, row=None, step=0):
        with headless_context:
            view = view or three_dancers()
            view.picture = row
            renderer.set_step(step)
            _ = headless_context.error  # moderngl provokes one for each framebuffer that it makes
            renderer.draw(view, target)
            assert headless_context.error == "GL_NO_ERROR"
            return read(target)

    yield renderer, draw
    with headless_context:
        renderer.release()


def test_every_step_shows_same_stage(quality_renderer):
    renderer, draw = quality_renderer
    best = draw().astype(int)
    for step in range(1, len(renderer.steps)):
        picture = draw(step=step)
        assert has_detail(picture)
        assert np.abs(picture.astype(int) - best).mean() < (2.0 if renderer.steps[step].quality.scale == 1.0 else 4.0)


def test_best_step_is_unchanged_after_other_steps(quality_renderer):
    renderer, draw = quality_renderer
    best = draw()
    for step in range(1, len(renderer.steps)):
        draw(step=step)
    assert np.array_equal(draw(), best)


def test_pass_left_out_by_step_is_not_drawn(quality_renderer):
    renderer, draw = quality_renderer
    names = [step.name for step in renderer.steps]
    dull = picture_row(SCENE)
    dull[BY_ADDRESS["/dance/pass/mirror"].first] = 0.0
    step = names.index("no mirror")
    assert np.array_equal(draw(step=step), draw(step=step, row=dull))
    trails = row_with(trails=1.0)
    assert np.array_equal(draw(three_dancers(), trails, step), draw(three_dancers(), trails, step))
    moved = draw(three_dancers(0.8), trails, step)
    assert np.array_equal(draw(three_dancers(0.8), row_with(), step), moved)


def test_overlay_stays_sharp_at_reduced_resolution(quality_renderer):
    renderer, draw = quality_renderer
    view = three_dancers()
    view.overlay = ("120 bpm",)
    renderer.graph.count = 0
    written, small = draw(view), draw(view, step=len(renderer.steps) - 1)
    letters = written.min(axis=2) > 190
    assert letters[:30, :90].sum() > 40
    assert np.array_equal(letters[:30, :90], (small.min(axis=2) > 190)[:30, :90])


def test_golden_frame_graph_marks_late_frames(gl_context, golden):
    renderer = Renderer(gl_context, replace(scene(1), camera=CAMERA), size=SIZE, quality=SOFTWARE)
    target = gl_context.simple_framebuffer(SIZE)
    view = three_dancers()
    graph = renderer.graph
    graph.times[:] = 16.6
    graph.times[100:110] = 40.0
    graph.count, graph.period = len(graph.times), 16.6
    renderer.draw(view, target)
    without = read(target).astype(int)  # no overlay: no graph
    view.overlay = ("frames",)
    renderer.draw(view, target)
    picture = read(target)
    changed = np.abs(picture.astype(int) - without).max(axis=2) > 0
    assert changed[100:, :100].any()
    red = (picture[..., 0] > 180) & (picture[..., 1] < 110)
    assert 0 < red.sum() < 60
    columns = np.flatnonzero(red.any(axis=0))
    left, wide = 8.0, 0.28 * SIZE[0]
    assert columns.min() == pytest.approx(left + wide * 100 / 240, abs=2)
    assert columns.max() == pytest.approx(left + wide * 110 / 240, abs=2)
    golden(picture, "overlay_graph", law=lambda seen: red.any() and has_detail(seen))
    renderer.release()
    target.release()
