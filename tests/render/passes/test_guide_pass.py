"""The operator's guides: strokes appear at their projected positions, and without strokes nothing is drawn."""

import moderngl
import numpy as np
import pytest

from live.base.stage_snapshot import GUIDE_CAPACITY, Camera, Scene, StageView
from live.motion.skeleton import JOINT_COUNT
from live.render.camera import project_points
from live.render.passes.overlay_pass import GuidePass
from live.render.uniforms import FrameUniforms

pytestmark = pytest.mark.gl
SIZE = (320, 180)
GREEN = (0.0, 1.0, 0.0, 1.0)


def draw_guides(ctx, *strokes, camera=None, count=None):
    """RGB picture with these strokes, (H, W, 3), row 0 on top."""
    camera = camera or Camera()
    frame = FrameUniforms(ctx, Scene((10.0, 8.0), camera, 0, JOINT_COUNT), SIZE)
    target, guide, view = ctx.simple_framebuffer(SIZE), GuidePass(ctx), StageView.allocate(0, JOINT_COUNT)
    for row, stroke in enumerate(strokes):
        view.guide[row] = stroke
    view.guide_count = len(strokes) if count is None else count
    frame.write(view)
    target.clear(0.0, 0.0, 0.0, 1.0)
    guide.draw(view, target, SIZE)
    pixels = np.frombuffer(target.read(components=3, alignment=1), np.uint8).reshape(SIZE[1], SIZE[0], 3)
    for thing in (guide, target, frame):
        thing.release()
    return np.flipud(pixels).astype(int)


def test_stroke_connects_projected_endpoints(gl_context: moderngl.Context):
    begin, end = (-2.0, 0.0, 1.0), (1.5, 1.2, -1.0)
    picture = draw_guides(gl_context, (*begin, *end, *GREEN))
    lit = np.argwhere(picture[..., 1] > 100)
    first, last = project_points(Camera(), SIZE, [begin, end])
    x = lit[:, 1] + 0.5
    on_line = first[1] + (x - first[0]) / (last[0] - first[0]) * (last[1] - first[1])
    assert np.abs(lit[:, 0] + 0.5 - on_line).max() < 1.6
    assert x.min() == pytest.approx(first[0], abs=1.5)
    assert x.max() == pytest.approx(last[0], abs=1.5)
    assert picture[..., (0, 2)].max() == 0


def test_zero_guides_draw_nothing(gl_context: moderngl.Context):
    stroke = (-2.0, 0.0, 1.0, 1.5, 1.2, -1.0, *GREEN)
    assert draw_guides(gl_context, stroke, count=0).max() == 0


def test_stroke_behind_camera_is_not_drawn(gl_context: moderngl.Context):
    camera = Camera(eye=(0.0, 1.0, 5.0), target=(0.0, 1.0, 0.0))
    behind = (-1.0, 1.0, 9.0, 1.0, 1.0, 9.0, *GREEN)
    across = (0.0, 1.0, 9.0, 0.0, 1.0, -2.0, *GREEN)
    assert draw_guides(gl_context, behind, across, camera=camera).max() == 0


def test_guides_beyond_capacity_are_ignored(gl_context: moderngl.Context):
    stroke = (-2.0, 0.0, 1.0, 1.5, 1.2, -1.0, *GREEN)
    assert draw_guides(gl_context, stroke, count=GUIDE_CAPACITY + 5)[..., 1].max() > 100
