"""Tests of contacts of seen feet: a foot that lands, one that glides, one that lifts."""

import numpy as np
import pytest

from live.motion.capture.standing_feet import SOLE_HEIGHTS, SPEED_ON, StandingFeet

RATE = 30.0
AWAY = np.array((0.0, 0.0, -1.0))


def watch(way, height=None):
    """Return the contact (T,) of the left foot whose soles are at `way` (T,) [m] across the stage; the right stands."""
    feet, found = StandingFeet(), []
    for n, x in enumerate(way):
        soles = np.zeros((4, 3))
        soles[:, 1] = SOLE_HEIGHTS
        soles[:2, 0] += x
        soles[:2, 1] += 0.0 if height is None else height[n]
        feet.observe(soles, AWAY, n / RATE)
        found.append(bool(feet.contact[0]))
    return np.array(found)


def braking(speed, seconds):
    """Return the way (T,) of a foot that goes on for 0.2 s, brakes evenly for some seconds and stands for 0.3 s."""
    fine = np.arange(0.0, 0.5 + seconds, 1e-4)
    going = speed * np.clip(1.0 - (fine - 0.2) / seconds, 0.0, 1.0)
    way = np.cumsum(going) * 1e-4
    return np.interp(np.arange(0.0, fine[-1], 1.0 / RATE), fine, way), 0.2 + seconds


@pytest.mark.parametrize(("speed", "seconds", "early"), [(1.5, 0.1, 0.0), (1.2, 0.2, 0.04), (0.8, 0.15, 0.04)])
def test_foot_that_brakes_is_held_as_it_stops(speed, seconds, early):
    """By the mean speed of the last pictures alone the first would be held a picture late, the others as they stop."""
    way, stop = braking(speed, seconds)
    first = int(np.argmax(watch(way))) / RATE
    assert stop - 0.07 <= first <= stop - early + 1e-9


@pytest.mark.parametrize("speed", [0.4, 0.6, 0.9, 1.5])
def test_foot_that_glides_evenly_is_not_held(speed):
    assert speed > SPEED_ON
    assert not watch(speed * np.arange(30) / RATE).any()


def test_foot_that_brakes_in_the_air_is_not_held():
    way, _ = braking(1.2, 0.15)
    assert not watch(way, np.full(len(way), 0.2)).any()


def test_speed_along_the_ray_does_not_end_a_contact():
    feet = StandingFeet()
    for n in range(20):
        soles = np.zeros((4, 3))
        soles[:, 1] = SOLE_HEIGHTS
        soles[:, 2] = 0.05 * (n % 3)
        feet.observe(soles, AWAY, n / RATE)
    assert feet.contact.all()
