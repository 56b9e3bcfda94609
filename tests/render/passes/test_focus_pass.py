"""Depth of field: the lens' law, what is sharp and what is not, where the automatic focus lies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import laplace

from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Camera
from live.render.adaptive_quality import HARDWARE, SOFTWARE, quality_steps
from live.render.camera import project_points
from live.render.passes.focus_pass import automatic_distance, spread_of
from live.render.renderer import Renderer
from tests.render.poses import ARMS_DOWN, REACH, stage_view
from tests.render.test_renderer import read, scene

SIZE = (640, 360)
CAMERA = Camera(eye=(0.0, 1.3, 7.0), target=(0.0, 1.0, 0.0), field_of_view_deg=36.0)


def pair():
    """Someone near and somebody far, both in the picture."""
    return stage_view([(REACH, (-1.0, 3.0), 0.0, 0), (ARMS_DOWN, (1.0, -2.5), 0.0, 1)])


@pytest.fixture
def draw(gl_context):
    """Draws the pair with picture parameters."""

    def once(quality=HARDWARE, **said):
        of = replace(scene(2, CAMERA))
        renderer = Renderer(gl_context, of, size=SIZE, quality=quality, warm_up=False)
        target = gl_context.simple_framebuffer(SIZE)
        view = pair()
        view.picture = picture_row(of)
        for name, value in said.items():
            view.picture[BY_ADDRESS["/dance/" + name.replace("__", "/")].row_slice] = value
        renderer.draw(view, target)
        seen = read(target).astype(float)
        renderer.release()
        target.release()
        return seen

    return once


def sharpness(picture, dancer):
    """Mean square of the second derivative around a dancer's chest."""
    joints = pair().joint_position[dancer]
    x, y = project_points(CAMERA, SIZE, joints[[0, 3]]).mean(axis=0).astype(int)
    return float((laplace(picture[y - 40 : y + 40, x - 30 : x + 30].mean(axis=2)) ** 2).mean())


@pytest.mark.parametrize(("focus", "distance"), [(4.0, 9.0), (8.0, 3.0), (6.0, 60.0)])
def test_circle_of_confusion_is_that_of_a_thin_lens(focus, distance):
    lens, length, angle = 0.3, 0.5, 36.0  # a lens of 0.5 m focal length: 1 / f = 1 / object + 1 / image
    image = {at: 1.0 / (1.0 / length - 1.0 / at) for at in (focus, distance)}
    circle = lens * abs(image[focus] - image[distance]) / image[distance]
    height = 2.0 * image[focus] * math.tan(0.5 * math.radians(angle))
    share = spread_of(lens, focus, angle) * abs(distance - focus) / distance
    assert share == pytest.approx(circle / height)


@pytest.mark.long
@pytest.mark.gl
def test_only_what_is_off_the_focus_loses_its_edges(draw):
    plain = draw()
    near, far = (draw(pass__focus=1.0, pass__focus__distance=at, pass__focus__aperture=0.4) for at in (4.0, 9.5))
    assert sharpness(near, 0) > 0.5 * sharpness(plain, 0)  # its outline stands before what is soft
    assert sharpness(near, 1) < 0.1 * sharpness(plain, 1)
    assert sharpness(far, 1) > 0.5 * sharpness(plain, 1)
    assert sharpness(far, 0) < 0.1 * sharpness(plain, 0)
    assert abs(near.mean() - plain.mean()) < 1.0  # light is spread, neither added nor lost
    assert np.array_equal(draw(pass__focus=0.0, pass__focus__aperture=2.0), plain)


@pytest.mark.long
@pytest.mark.gl
def test_software_quality_leaves_depth_of_field_out(draw):
    assert np.array_equal(draw(SOFTWARE, pass__focus=1.0, pass__blur=0.5), draw(SOFTWARE))
    assert {"focus", "blur"} <= set(SOFTWARE.left_out)
    assert [step.kind for step in quality_steps(HARDWARE)].index("focus") > 0


def test_automatic_focus_is_on_the_spot_then_on_the_middle_dancer_then_on_the_target():
    view = pair()
    dark, lit = [0.0] * 4, [0.0, 1.0, 0.5, 0.0]
    ahead = replace(CAMERA, eye=(0.0, 1.0, 7.0))  # level: distance along the axis is the difference of z
    assert automatic_distance(view, ahead, dark) == pytest.approx(9.5, abs=0.3)  # 1 m aside of 9.5 is nearer the middle
    view.spot[1] = -2.0, 3.5
    assert automatic_distance(view, ahead, lit) == pytest.approx(3.5)
    view.present[:] = False
    assert automatic_distance(view, ahead, dark) == pytest.approx(7.0)
    behind = replace(CAMERA, eye=(0.0, 1.0, -7.0), target=(0.0, 1.0, -14.0))
    view.present[:] = True
    assert automatic_distance(view, behind, dark) == pytest.approx(7.0)  # nobody is before the camera
