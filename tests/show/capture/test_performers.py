"""Tests of performers: tracked obstacles with velocity, a speed limit and a timeout."""

import numpy as np
import pytest

from live.agents.crowd.obstacles import Surroundings
from live.control.events.events import Performer
from live.show.capture.stage_presence import LOST_S, MAX_SPEED, OBSTACLE_PREFIX, Performers

RADIUS = 0.3


def track_at(performers, time, x, z=0.0, name="anna"):
    return performers.track(Performer(time=time, source="test", name=name, x=x, z=z))


def test_obstacle_has_position_and_velocity_of_performer():
    around = Surroundings()
    performers = Performers(around, RADIUS)
    assert track_at(performers, 1.0, 0.5)
    assert around.obstacle_names == (OBSTACLE_PREFIX + "anna",)
    assert track_at(performers, 1.5, 1.0, 0.25)
    assert around.obstacles[0][:5] == pytest.approx([1.0, 0.25, RADIUS, 1.0, 0.5])


def test_tracking_jump_is_limited_to_maximum_speed():
    around = Surroundings()
    performers = Performers(around, RADIUS)
    track_at(performers, 1.0, -3.0)
    track_at(performers, 1.01, 3.0, 4.0)
    assert np.hypot(*around.obstacles[0][3:5]) == pytest.approx(MAX_SPEED)


def test_lost_performers_are_removed_and_stage_set_stays():
    around = Surroundings()
    performers = Performers(around, RADIUS)
    around.set_obstacle("anna", 2.0, 2.0, 0.5)
    track_at(performers, 1.0, 0.5)
    track_at(performers, 2.0, 0.5, name="ben")
    performers.tick(1.0 + LOST_S)
    assert len(around.obstacle_names) == 3
    performers.tick(1.01 + LOST_S)
    assert set(around.obstacle_names) == {"anna", OBSTACLE_PREFIX + "ben"}
    performers.tick(2.01 + LOST_S)
    assert around.obstacle_names == ("anna",)
