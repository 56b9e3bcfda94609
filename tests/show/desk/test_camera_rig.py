"""Tests of moving cameras: orbits in measures, following dancers, default views and the projector view."""

import math

import numpy as np
import pytest

from live.base import picture_parameters
from live.base.errors import PersonError
from live.base.floor_corners import floor_corners
from live.clock.ticks import TICK
from live.render.camera import project_points
from live.show.desk.scenes import view_settings
from live.show.patch.patch import Patch
from live.show.view.render_scene import make_scene
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DESK, DeskSession

SIZE = (1280, 720)
MOVING = """
[[view]]
name = "carousel"
eye = [0.0, 3.0, 10.0]
target = [1.0, 1.0, 0.0]
orbit_measures = 2
[[view]]
name = "with front"
eye = [0.0, 2.0, 8.0]
target = [0.0, 1.0, 0.0]
follow = "front"
along = 1.0
"""


def camera(session, after=0.0):
    """The camera of the picture `after` seconds after the last tick."""
    view = session.show.view()
    session.show.fill(view, session.ticks * TICK + after)
    return picture_parameters.camera_from_row(view.picture)


def orbit_angle(of):
    return math.degrees(math.atan2(of.eye[0] - of.target[0], of.eye[2] - of.target[2]))


def test_orbit_returns_after_its_measures_at_constant_distance_and_height():
    session = DeskSession(DESK + MOVING).run(beats=1)
    session.say("/dance/camera", "carousel")
    start = camera(session)
    far = math.dist(start.eye, start.target)
    for quarter in range(1, 5):
        now = camera(session.run(beats=2))
        turn = math.remainder(orbit_angle(now) - orbit_angle(start) - 90.0 * quarter, 360.0)
        assert abs(turn) < 1e-3
        assert math.dist(now.eye, now.target) == pytest.approx(far, abs=1e-6)
        assert now.eye[1] == start.eye[1]
    assert camera(session).eye == pytest.approx(start.eye, abs=1e-4)


def test_orbit_is_interpolated_between_ticks():
    session = DeskSession(DESK + MOVING).run(beats=1)
    session.say("/dance/camera", "carousel")
    session.run(ticks=3)
    here, between, there = camera(session), camera(session, TICK / 2), camera(session.run(ticks=1))
    assert orbit_angle(between) == pytest.approx(0.5 * (orbit_angle(here) + orbit_angle(there)), abs=1e-6)
    assert orbit_angle(there) > orbit_angle(here)


@pytest.mark.long
def test_move_into_orbit_is_smooth():
    session = DeskSession(DESK + MOVING).run(beats=1)
    session.say("/dance/camera", "carousel", 1.0)
    eyes = np.array([camera(session.run(ticks=1)).eye for _ in range(256)])
    jumps = np.linalg.norm(np.diff(eyes, n=2, axis=0), axis=1)
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() > 0.02  # it goes
    assert jumps.max() < 0.01  # and its speed changes little from tick to tick


@mostly_long(("measures", "before"), [(2.0, 3), (1.0, 5), (0.5, 0)], quick=[2])
def test_move_out_of_an_orbit_ends_at_the_view(measures, before):
    """Wherever the orbit is when it begins, and with an even speed."""
    session = DeskSession(DESK + MOVING).run(beats=1)
    home = camera(session)
    session.say("/dance/camera", "carousel")
    session.run(beats=before)
    session.say("/dance/camera", "start", measures)
    eyes = np.array([camera(session.run(ticks=1)).eye for _ in range(round(128 * measures) + 16)])
    assert eyes[-16:] == pytest.approx(np.tile(home.eye, (16, 1)), abs=1e-6)
    assert np.linalg.norm(np.diff(eyes, n=2, axis=0), axis=1).max() < 0.05 / measures**2


@pytest.mark.long
def test_followed_group_stays_in_center_of_picture():
    session = DeskSession(DESK + MOVING).run(beats=1)
    session.say("/dance/camera", "with front")
    front = session.show.casting.select("front", session.show.state.position)
    offs = []
    for _ in range(40):
        now = camera(session.run(ticks=8))
        middle = session.show.state.position[front & session.show.motion.present].mean(axis=0)
        offs.append(math.dist((now.target[0], now.target[2]), middle))
        assert np.subtract(now.eye, now.target) == pytest.approx((0.0, 1.0, 8.0), abs=1e-9)  # it goes along
        assert abs(project_points(now, SIZE, [(middle[0], 1.0, middle[1])])[0, 0] - 640) < 80
    assert max(offs) < 0.8


@pytest.mark.long
def test_following_is_damped_and_changes_target_without_jump():
    session = DeskSession(DESK).run(beats=1)
    session.say("/dance/camera/follow", "front & 1", 0.0)
    here = camera(session.run(beats=1))
    session.say("/dance/camera/follow", "front & 2", -1.0, 1.0)
    ways = [camera(session.run(ticks=1)).target for _ in range(96)]
    steps = np.linalg.norm(np.diff(np.array([here.target, *ways]), axis=0), axis=1)
    assert steps.sum() > 0.3
    assert steps.max() < 0.06
    session.say("/dance/camera/follow", "off", -1.0, 1.0)
    session.run(beats=8)
    assert camera(session).target == pytest.approx(make_scene(session.show.patch).camera.target)


def test_unknown_follow_target_is_refused_and_named():
    session = DeskSession(DESK)
    assert not session.say("/dance/camera/follow", "nonesuch")
    assert "nonesuch" in str(session.words)
    with pytest.raises(PersonError, match="nonesuch"):
        DeskSession(DESK + '[[view]]\nname = "x"\nfollow = "nonesuch"\n')


def test_default_views_show_whole_stage():
    for width, depth in ((12.0, 8.0), (30.0, 6.0), (5.0, 14.0)):
        patch = Patch.model_validate(
            {"name": "x", "stage": {"width": width, "depth": depth},
             "group": [{"name": "a", "dancers": 1, "steps": ["groove"]}]}
        )  # fmt: skip
        views = view_settings(patch)
        assert set(views) == {"front", "side", "top", "around"}
        floor = floor_corners(width, depth)
        for name in ("front", "top"):
            row = picture_parameters.picture_row(make_scene(patch))
            for address, value in views[name][0].items():
                row[picture_parameters.BY_ADDRESS[address].row_slice] = value
            at = project_points(
                picture_parameters.camera_from_row(row), SIZE, np.stack([floor[:, 0], np.zeros(4), floor[:, 1]], axis=1)
            )
            assert (at > 0).all()
            assert (at < SIZE).all()


def test_show_with_projector_starts_with_projector_perspective():
    corners = [[0.2, 0.35], [0.8, 0.35], [0.95, 0.9], [0.05, 0.9]]
    table = f"[projector]\nat = [0.0, 5.0, 14.0]\ncorners = {corners}\n"
    session = DeskSession(table + DESK)
    stage = session.show.patch.stage
    floor = floor_corners(stage.width, stage.depth)
    at = project_points(camera(session), (1920, 1080), np.stack([floor[:, 0], np.zeros(4), floor[:, 1]], axis=1))
    assert np.abs(at - np.array(corners) * (1920, 1080)).max() < 0.01
    session.say("/dance/camera", "front")
    assert camera(session).shift == (0.0, 0.0)
    session.say("/dance/camera", "projector")
    assert camera(session).eye == (0.0, 5.0, 14.0)


def test_same_events_give_bit_identical_cameras():
    def danced():
        session = DeskSession(DESK + MOVING).run(beats=1)
        session.say("/dance/camera", "with front", 1)
        session.run(beats=3)
        session.say("/dance/camera", "carousel", 0.5)
        return [camera(session.run(ticks=1)) for _ in range(64)], session.show.state_hash()

    assert danced() == danced()
