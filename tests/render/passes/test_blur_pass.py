"""Motion blur: velocities of joints, direction and length in the picture, nothing after cuts and for what stands."""

from dataclasses import replace

import numpy as np
import pytest

from live.base.picture_parameters import BY_ADDRESS, EYE, TARGET, picture_row
from live.base.stage_snapshot import Camera
from live.motion import quaternion
from live.motion.skeleton import SKELETON
from live.render.adaptive_quality import HARDWARE
from live.render.camera import project_points
from live.render.passes.blur_pass import JointMotion
from live.render.renderer import Renderer
from tests.render.poses import ARMS_DOWN, LUNGE, REACH, stage_view
from tests.render.test_renderer import read, scene

SIZE = (640, 360)
CAMERA = Camera(eye=(0.0, 1.1, 6.0), target=(0.0, 1.1, 0.0), field_of_view_deg=36.0)


def dancer(pose=ARMS_DOWN, x=0.0, heading=0.0):
    return stage_view([(pose, (x, 0.0), heading, 0)])


def test_points_on_bones_are_taken_back_to_where_they_were():
    motion = JointMotion()
    before, now = dancer(LUNGE, 0.0, 10.0), dancer(REACH, 0.2, 35.0)
    motion.update(before, fresh=True)
    rows = motion.update(now, fresh=False)[0]
    for joint in (SKELETON.index(name) for name in ("head", "leftLowerArm", "rightLowerLeg")):
        local = np.array((0.05, -0.12, 0.03))  # fixed to the bone
        there, was = (
            view.joint_position[0, joint] + quaternion.rotate(view.joint_rotation[0, joint], local)
            for view in (now, before)
        )
        x, y, z, w = rows[joint, 2]
        back = rows[joint, 3, :3] + quaternion.rotate(np.array((w, x, y, z)), there - rows[joint, 0, :3])
        assert back == pytest.approx(was, abs=1e-5)


def test_dancers_who_were_put_elsewhere_or_have_just_come_do_not_blur():
    for change in ("leap", "entrance", "cut"):
        motion, before, now = JointMotion(), dancer(), dancer(LUNGE, 5.0 if change == "leap" else 0.1, 40.0)
        before.present[:] = change != "entrance"
        motion.update(before, fresh=True)
        rows = motion.update(now, fresh=change == "cut")[0]
        assert np.array_equal(rows[:, 3, :3], now.joint_position[0])
        assert rows[:, 2] == pytest.approx(np.tile((0.0, 0.0, 0.0, 1.0), (len(rows), 1)), abs=1e-6)


@pytest.fixture
def film(gl_context):
    """Draws views 40 ms apart and returns the last picture."""

    def run(views, amount, pan=0.0, gap=0.04):
        of = replace(scene(1, CAMERA))
        renderer = Renderer(gl_context, of, size=SIZE, quality=HARDWARE, warm_up=False)
        target = gl_context.simple_framebuffer(SIZE)
        for number, view in enumerate(views):
            view.time, view.beat = gap * number, 2.0 * gap * number
            view.picture = picture_row(of)
            view.picture[BY_ADDRESS["/dance/pass/blur"].first] = amount
            view.picture[BY_ADDRESS["/dance/pass/bloom"].first] = 0.0
            for place in (EYE, TARGET):
                view.picture[place] += (pan * number, 0.0, 0.0)
            renderer.draw(view, target)
        seen = read(target).astype(float)
        renderer.release()
        target.release()
        return seen

    return run


def edges(picture):
    """Mean squares of the differences to the right and down around the dancer."""
    middle = picture[60:300, 220:420].mean(axis=2)
    return float((np.diff(middle, axis=1) ** 2).mean()), float((np.diff(middle, axis=0) ** 2).mean())


@pytest.mark.long
@pytest.mark.gl
def test_moving_dancer_blurs_along_the_motion_only(film):
    still = [dancer(), dancer()]
    moving = [dancer(x=-0.12), dancer()]
    sharp, blurred = film(moving, 0.0), film(moving, 1.0)
    across, along = (np.array(edges(blurred)) / np.array(edges(sharp))).tolist()
    assert across < 0.35  # edges that stand across the motion are soft
    assert along > 2.0 * across
    assert np.abs(film(still, 1.0) - film(still, 0.0)).max() <= 2.0
    assert np.abs(blurred - sharp)[:, 560:].max() <= 2.0  # the stage stands still
    assert abs(blurred.mean() - sharp.mean()) < 0.5


@pytest.mark.long
@pytest.mark.gl
def test_blur_is_as_long_as_the_way_with_open_shutter(film):
    step = 0.12
    moving = [dancer(x=-step), dancer()]
    way = float(np.ptp(project_points(CAMERA, SIZE, [(-step, 1.1, 0.0), (0.0, 1.1, 0.0)])[:, 0]))
    y = int(project_points(CAMERA, SIZE, [(0.0, 0.45, 0.0)])[0, 1])
    nobody = dancer()
    nobody.present[:] = False
    empty, sharp, blurred = film([nobody], 0.0), film(moving, 0.0), film(moving, 0.8)
    widths = []
    for picture in (sharp, blurred):
        row = np.abs(picture[y - 8 : y + 8] - empty[y - 8 : y + 8]).sum(axis=(0, 2))[280:360]
        widths.append(int(np.ptp(np.flatnonzero(row > 0.06 * row.max()))))
    assert widths[1] - widths[0] == pytest.approx(0.8 * way, abs=0.4 * way)


@pytest.mark.long
@pytest.mark.gl
def test_camera_motion_blurs_the_stage_and_cuts_and_stalls_do_not(film):
    pair = [dancer(), dancer()]
    sharp, blurred = film(pair, 0.0, pan=0.15), film(pair, 0.9, pan=0.15)
    assert edges(blurred)[0] < 0.6 * edges(sharp)[0]
    stalled = film(pair, 0.9, pan=0.15, gap=2.0)
    assert np.abs(stalled - film(pair, 0.0, pan=0.15, gap=2.0)).max() <= 2.0
    assert np.abs(film(pair[:1], 0.9) - film(pair[:1], 0.0)).max() <= 2.0
