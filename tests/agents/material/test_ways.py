"""Ways as curves with few points: fit, transformation, and evolutions that dance them."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from live.agents.evolutions.intention import FollowWays, Matching, Repertoire, Segment
from live.agents.evolutions.running_plan import Plan
from live.agents.evolutions.start_delays import Ripple
from live.agents.groups.roster import Line, Roster
from live.agents.material.room import room_of
from live.agents.material.transform import Transform
from live.agents.material.ways import Material, danced_ways, fit_ways, sample_ways, transform_ways

TRIANGLE = (((-5.0, -4.0), (5.0, -4.0), (0.0, 5.0)),)


def flock(count=12, moments=65):
    """Places (moments, count, 2) of a flock that turns and drifts."""
    share = np.linspace(0.0, 1.0, moments)[:, None]
    angle = np.arange(count) * 2.4
    reach = 0.8 * np.sqrt(np.arange(count) + 0.5)
    turn = angle + 1.2 * share
    return np.stack([reach * np.cos(turn) + 3.0 * share, reach * np.sin(turn) + np.sin(3 * share)], axis=-1)


def test_fit_stays_within_its_error_with_few_points():
    walked = flock()
    fitted = fit_ways(walked, 0.05)
    made = sample_ways(fitted.ways, len(walked))
    assert np.hypot(*np.moveaxis(made - walked, 2, 0)).max() == pytest.approx(fitted.error)
    assert fitted.error <= 0.05
    assert max(map(len, fitted.ways)) <= 9
    assert made[[0, -1]] == pytest.approx(walked[[0, -1]], abs=0.008)  # rounded to centimetres


def test_who_stands_has_one_point_and_who_walks_straight_two():
    share = np.linspace(0.0, 1.0, 33)[:, None]
    still, straight = np.tile([[1.0, 2.0]], (33, 1)), np.array([[0.0, 0.0]]) + share * [[3.0, 1.0]]
    fitted = fit_ways(np.stack([still, straight], axis=1))
    assert fitted.ways == (((1.0, 2.0),), ((0.0, 0.0), (3.0, 1.0)))


def test_noise_is_told_as_error():
    noise = np.random.default_rng(0).uniform(-1.0, 1.0, (400, 2, 2))
    fitted = fit_ways(noise, 0.01)
    assert fitted.error > 0.01
    assert max(map(len, fitted.ways)) <= 129


def test_mirrored_ways_keep_their_points_and_come_back():
    ways = fit_ways(flock()).ways
    once = transform_ways(Transform(mirror=Line()), ways)
    assert [len(way) for way in once] == [len(way) for way in ways]
    assert once[0][0] == pytest.approx((-ways[0][0][0], ways[0][0][1]))
    twice = transform_ways(Transform(mirror=Line()), once)
    assert all(np.array(a) == pytest.approx(np.array(b)) for a, b in zip(twice, ways, strict=True))


@pytest.mark.long
def test_motion_goes_into_a_region_at_every_moment():
    ways = fit_ways(flock(20)).ways
    there = sample_ways(transform_ways(Transform(into=TRIANGLE), ways), 97)
    assert room_of(TRIANGLE).contains(there.reshape(-1, 2), 0.02).all()
    assert min(cKDTree(now).query(now, k=2)[0][:, 1].min() for now in there) > 0.5
    steps, before = np.diff(there, axis=0), np.diff(sample_ways(ways, 97), axis=0)
    assert np.hypot(*np.moveaxis(steps, 2, 0)).max() < 1.5 * np.hypot(*np.moveaxis(before, 2, 0)).max()


def plan_of(follow=None, count=12, **segment):
    material = Material(fit_ways(flock(12)).ways)
    repertoire = Repertoire().with_ways("flock", danced_ways(material))
    follow = follow or FollowWays("flock", Matching())
    plan = Plan(Roster.create(count), repertoire, [Segment(follow, start=0, measures=4, **segment)], half=(9.0, 9.0))
    return plan, danced_ways(material)


def danced(plan, start, beats):
    plan.begin_measure(0, start, np.zeros(len(start)))
    plan.finish()
    return np.array([plan.state_at(float(beat)).position.copy() for beat in beats])


def test_a_recorded_flock_is_danced_again():
    plan, ways = plan_of()
    walked = flock()
    places = danced(plan, ways[:, 0], np.linspace(0.0, 16.0, 65))
    assert np.hypot(*np.moveaxis(places - walked, 2, 0)).max() < 0.06


def test_it_is_danced_backwards_and_mirrored():
    plan, ways = plan_of(FollowWays("flock", backwards=True), mirror=Line())
    start = ways[:, -1] * (-1.0, 1.0)
    places = danced(plan, start, np.linspace(0.0, 16.0, 65))
    assert np.hypot(*np.moveaxis(places - flock()[::-1] * (-1.0, 1.0), 2, 0)).max() < 0.06


def test_who_is_elsewhere_comes_to_her_way_within_a_measure():
    plan, ways = plan_of()
    places = danced(plan, ways[:, 0] + (0.4, -0.3), [0.0, 4.0, 16.0])
    assert places[0] == pytest.approx(ways[:, 0] + (0.4, -0.3), abs=1e-3)
    assert np.hypot(*(places[1] - flock()[16]).T).max() < 0.1
    assert places[2] == pytest.approx(ways[:, -1], abs=1e-3)


def test_in_canon_each_dances_the_same_later():
    plan, ways = plan_of(ripple=Ripple(4.0))
    places = danced(plan, ways[:, 0], [0.0, 12.0, 16.0])
    first, last = np.argmin(ways[:, 0, 0]), np.argmax(ways[:, 0, 0])
    assert places[1, first] == pytest.approx(ways[first, -1], abs=0.02)  # each takes 12 of 16 beats
    assert np.hypot(*(places[1, last] - ways[last, -1])) > 0.2
    assert places[2, last] == pytest.approx(ways[last, -1], abs=0.02)


def test_who_has_no_way_stands_at_the_edge():
    plan, ways = plan_of(count=14)
    start = np.concatenate([ways[:, 0], [[6.0, 6.0], [-6.0, 6.0]]])
    places = danced(plan, start, [16.0])
    assert (np.abs(places[0]).max(axis=1) > 7.0).sum() == 2
