"""Cameras that move: around the stage in measures, along with whom they follow, and the views that every show has."""

import math

import numpy as np
import pytest

from live.base import picture_parameters
from live.base.errors import PersonError
from live.base.projector_perspective import floor_corners
from live.clock.ticks import TICK
from live.render.camera import project_points
from live.show.desk.scenes import view_settings
from live.show.patch.patch import Patch
from live.show.view.render_scene import make_scene
from tests.show.desk.desk_show import DESK, Hands

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


def camera(hands, after=0.0):
    """The camera of the picture so long after the last tick."""
    view = hands.show.view()
    hands.show.fill(view, hands.ticks * TICK + after)
    return picture_parameters.camera_from_row(view.picture)


def bearing(of):
    return math.degrees(math.atan2(of.eye[0] - of.target[0], of.eye[2] - of.target[2]))


def test_an_orbit_comes_back_after_its_measures_and_keeps_distance_and_height():
    hands = Hands(DESK + MOVING).run(beats=1)
    hands.say("/dance/camera", "carousel")
    start = camera(hands)
    far = math.dist(start.eye, start.target)
    for quarter in range(1, 5):
        now = camera(hands.run(beats=2))
        turn = math.remainder(bearing(now) - bearing(start) - 90.0 * quarter, 360.0)
        assert abs(turn) < 1e-3
        assert math.dist(now.eye, now.target) == pytest.approx(far, abs=1e-6)
        assert now.eye[1] == start.eye[1]
    assert camera(hands).eye == pytest.approx(start.eye, abs=1e-4)


def test_between_two_ticks_an_orbit_goes_on_evenly():
    hands = Hands(DESK + MOVING).run(beats=1)
    hands.say("/dance/camera", "carousel")
    hands.run(ticks=3)
    here, between, there = camera(hands), camera(hands, TICK / 2), camera(hands.run(ticks=1))
    assert bearing(between) == pytest.approx(0.5 * (bearing(here) + bearing(there)), abs=1e-6)
    assert bearing(there) > bearing(here)


def test_a_move_into_an_orbit_has_no_jerk():
    hands = Hands(DESK + MOVING).run(beats=1)
    hands.say("/dance/camera", "carousel", 1.0)
    eyes = np.array([camera(hands.run(ticks=1)).eye for _ in range(256)])
    jumps = np.linalg.norm(np.diff(eyes, n=2, axis=0), axis=1)
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() > 0.02  # it goes
    assert jumps.max() < 0.01  # and its speed changes little from tick to tick


def test_a_followed_group_stays_in_the_middle_of_the_picture():
    hands = Hands(DESK + MOVING).run(beats=1)
    hands.say("/dance/camera", "with front")
    front = hands.show.casting.select("front", hands.show.state.position)
    offs = []
    for _ in range(40):
        now = camera(hands.run(ticks=8))
        middle = hands.show.state.position[front & hands.show.motion.present].mean(axis=0)
        offs.append(math.dist((now.target[0], now.target[2]), middle))
        assert np.subtract(now.eye, now.target) == pytest.approx((0.0, 1.0, 8.0), abs=1e-9)  # it goes along
        assert abs(project_points(now, SIZE, [(middle[0], 1.0, middle[1])])[0, 0] - 640) < 80
    assert max(offs) < 0.8


def test_following_is_damped_and_goes_over_to_somebody_else_without_a_jump():
    hands = Hands(DESK).run(beats=1)
    hands.say("/dance/camera/follow", "front & 1", 0.0)
    here = camera(hands.run(beats=1))
    hands.say("/dance/camera/follow", "front & 2", -1.0, 1.0)
    ways = [camera(hands.run(ticks=1)).target for _ in range(96)]
    steps = np.linalg.norm(np.diff(np.array([here.target, *ways]), axis=0), axis=1)
    assert steps.sum() > 0.3
    assert steps.max() < 0.06
    hands.say("/dance/camera/follow", "off", -1.0, 1.0)
    hands.run(beats=8)
    assert camera(hands).target == pytest.approx(make_scene(hands.show.patch).camera.target)


def test_nobody_to_follow_is_refused_and_named():
    hands = Hands(DESK)
    assert not hands.say("/dance/camera/follow", "nonesuch")
    assert "nonesuch" in str(hands.words)
    with pytest.raises(PersonError, match="nonesuch"):
        Hands(DESK + '[[view]]\nname = "x"\nfollow = "nonesuch"\n')


def test_every_show_has_views_that_show_the_whole_stage():
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


def test_a_show_with_a_projector_begins_with_its_perspective():
    corners = [[0.2, 0.35], [0.8, 0.35], [0.95, 0.9], [0.05, 0.9]]
    table = f"[projector]\nat = [0.0, 5.0, 14.0]\ncorners = {corners}\n"
    hands = Hands(table + DESK)
    stage = hands.show.patch.stage
    floor = floor_corners(stage.width, stage.depth)
    at = project_points(camera(hands), (1920, 1080), np.stack([floor[:, 0], np.zeros(4), floor[:, 1]], axis=1))
    assert np.abs(at - np.array(corners) * (1920, 1080)).max() < 0.01
    hands.say("/dance/camera", "front")
    assert camera(hands).shift == (0.0, 0.0)
    hands.say("/dance/camera", "projector")
    assert camera(hands).eye == (0.0, 5.0, 14.0)


def test_the_same_events_give_the_same_cameras_bit_by_bit():
    def danced():
        hands = Hands(DESK + MOVING).run(beats=1)
        hands.say("/dance/camera", "with front", 1)
        hands.run(beats=3)
        hands.say("/dance/camera", "carousel", 0.5)
        return [camera(hands.run(ticks=1)) for _ in range(64)], hands.show.state_hash()

    assert danced() == danced()
