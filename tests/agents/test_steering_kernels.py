"""Reynolds' behaviors: directions, limits, prediction and degenerate directions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents import steering_kernels as b

PLACE = st.floats(-8.0, 8.0, width=32)


def line(*points):
    vertices = np.zeros((1, 64, 2), np.float32)
    vertices[0, : len(points)] = points
    return vertices, len(points)


@given(PLACE, PLACE, PLACE, PLACE)
def test_flee_is_the_inverse_of_seek_at_top_speed(x, z, tx, tz):
    to, away = np.array(b.seek(x, z, tx, tz)), np.array(b.flee(x, z, tx, tz))
    assert np.allclose(to, -away)
    d = math.hypot(tx - x, tz - z)
    if d > 1e-6:
        assert np.allclose(to, [(tx - x) / d, (tz - z) / d])
    assert b.seek(x, z, x, z) == (0.0, 0.0)


@given(PLACE, PLACE)
def test_arrival_speed_is_proportional_to_distance(x, z):
    d = math.hypot(x, z)
    assert math.hypot(*b.arrive(x, z, 0.0, 0.0, 2.0)) == pytest.approx(min(d / 2.0, 1.0), abs=1e-9)
    assert b.arrive(1.0, 1.0, 1.0, 1.0, 0.0) == (0.0, 0.0)


def test_pursuit_leads_the_target_and_evasion_is_opposite():
    # the target 3 m away crosses at 1 m/s; at 2 m/s it is reached after 1.5 s, 1.5 m farther
    to = np.array(b.pursue(0.0, 0.0, 0.0, 3.0, 1.0, 0.0, 2.0))
    assert np.allclose(to, np.array([1.5, 3.0]) / math.hypot(1.5, 3.0))
    assert np.allclose(b.evade(0.0, 0.0, 0.0, 3.0, 1.0, 0.0, 2.0), -to)
    assert np.allclose(b.pursue(0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 2.0), b.seek(0.0, 0.0, 0.0, 3.0))


def test_wander_turns_gradually_and_is_seeded():
    times = np.arange(0.0, 20.0, 1.0 / 64.0)
    way = np.array([b.wander(0.0, 0.0, 0.0, 1.0, 9.0, 9.0, 7, 3, t) for t in times])
    assert np.allclose(np.hypot(*way.T), 1.0)
    heading = np.arctan2(way[:, 0], way[:, 1])
    assert np.abs(np.diff(heading)).max() < 0.1  # a small displacement each tick
    assert heading.std() > 0.3
    assert abs(heading.mean()) < 0.4
    assert b.wander(0.0, 0.0, 0.0, 1.0, 9.0, 9.0, 7, 3, 5.0) == tuple(way[320])
    assert b.wander(0.0, 0.0, 0.0, 1.0, 9.0, 9.0, 8, 3, 5.0) != tuple(way[320])


@given(PLACE, PLACE, st.integers(0, 50), st.floats(0.0, 100.0))
def test_wander_never_leaves_the_stage(x, z, agent, time):
    wx, wz = b.wander(x, z, x, z, 8.0, 8.0, 1, agent, time)
    assert abs(x + 0.4 * wx) <= 8.0 + 1e-6
    assert abs(z + 0.4 * wz) <= 8.0 + 1e-6


@given(PLACE, PLACE)
def test_vortex_is_perpendicular_to_radial_flow(x, z):
    out, turn = np.array(b.flow_radial(x, z, 1.0, -1.0, 1.5)), np.array(b.flow_vortex(x, z, 1.0, -1.0, 1.5))
    assert abs(out @ turn) < 1e-12
    d = math.hypot(x - 1.0, z + 1.0)
    assert np.hypot(*out) == pytest.approx(1.0 - math.exp(-d / 1.5), abs=1e-6)


def test_flow_grid_is_interpolated_and_clamped_at_edges():
    grid = np.zeros((1, 3, 5, 2), np.float32)
    u, v = np.meshgrid(np.linspace(-4, 4, 5), np.linspace(-2, 2, 3))
    grid[0, ..., 0], grid[0, ..., 1] = 2 * u + v, v - 1
    for x, z in ((0.0, 0.0), (1.3, -0.7), (-4.0, 2.0), (3.99, 1.99)):
        assert np.allclose(b.flow_grid(grid, 0, x, z, 4.0, 2.0), (2 * x + z, z - 1), atol=0.01)
    assert np.allclose(b.flow_grid(grid, 0, 99.0, -99.0, 4.0, 2.0), (6.0, -3.0), atol=0.02)


@given(st.lists(st.tuples(PLACE, PLACE), min_size=1, max_size=9), st.booleans(), PLACE, PLACE)
def test_nearest_point_on_line_matches_shapely(points, closed, x, z):
    import shapely

    vertices, count = line(*points)
    d2, px, pz, segment, t = b.nearest_on_line(vertices, 0, count, closed, x, z, 0.0, 0.0)
    ring = [*points, points[0]] if closed and count > 2 else points
    shape = shapely.LineString(ring) if count > 1 else shapely.Point(points[0])
    assert math.sqrt(d2) == pytest.approx(shape.distance(shapely.Point(x, z)), abs=1e-4)
    assert math.hypot(px - x, pz - z) == pytest.approx(math.sqrt(d2), abs=1e-6)
    assert 0 <= segment < max(count, 1)
    assert 0.0 <= t <= 1.0


def test_advance_along_line_passes_corners_and_stops_at_end():
    vertices, count = line((0, 0), (2, 0), (2, 3))
    assert np.allclose(b.along_line(vertices, 0, count, False, 0, 0.5, 0.5), (1.5, 0, 1, 0))
    assert np.allclose(b.along_line(vertices, 0, count, False, 0, 0.5, 2.0), (2, 1, 0, 1))
    assert np.allclose(b.along_line(vertices, 0, count, False, 1, 0.0, 9.0)[:2], (2, 3))
    around = b.along_line(vertices, 0, count, True, 1, 0.0, 3.0 + math.sqrt(13.0) + 1.0)
    assert np.allclose(around[:2], (1, 0), atol=1e-5)
    same, count = line((1, 1), (1, 1))
    assert np.allclose(b.along_line(same, 0, count, True, 0, 0.0, 3.0), (1, 1, 0, 0))


def walk(step, seconds, x=0.0, z=0.0, speed=1.3):
    """A Reynolds vehicle without neighbors; its positions, 64 per second."""
    place, velocity, way = np.array([x, z]), np.zeros(2), []
    for _ in range(int(seconds * 64)):
        force = (np.array(step(*place, *velocity)) * speed - velocity) / 0.3  # T081: desired minus current velocity
        velocity = velocity + np.clip(force, -4.0, 4.0) / 64
        place = place + velocity / 64
        way.append(place)
    return np.array(way)


def test_path_is_followed_within_its_width_to_the_end():
    import shapely

    corners = ((-4, 0), (0, 2), (4, -2), (5, 3))
    vertices, count = line(*corners)

    def step(x, z, vx, vz):
        return b.follow_path(vertices, 0, count, False, 0.4, x, z, vx, vz, 1.3)

    way = walk(step, 25.0, -5.0, -1.0)
    shape = shapely.LineString(corners)
    away = [shape.distance(shapely.Point(p)) for p in way[200:]]
    assert max(away) < 0.75
    assert np.hypot(*(way[-1] - (5, 3))) < 0.1


def test_figure_eight_is_followed_through_its_crossing():
    t = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    vertices, count = line(*np.stack([4 * np.sin(t), 2 * np.sin(2 * t)], 1))

    def step(x, z, vx, vz):
        return b.follow_path(vertices, 0, count, True, 0.3, x, z, vx, vz, 1.2)

    way = walk(step, 60.0, 0.0, 0.0, 1.2)
    left, right = (way[-2500:, 0] < -3).any(), (way[-2500:, 0] > 3).any()
    assert left
    assert right


def test_follower_stays_behind_and_clears_the_path():
    # the leader walks along +x: the place behind is at -x
    fx, fz = b.follow_behind(0.0, 0.0, 3.0, 0.0, 1.0, 0.0, 0.9)
    assert fx > 0.9
    assert abs(fz) < 1e-9
    assert b.follow_behind(2.1, 0.0, 3.0, 0.0, 1.0, 0.0, 0.9) == pytest.approx((0.0, 0.0), abs=1e-9)
    # towards the audience, a side of +1 is at +x: back by the gap and to the right by the gap
    assert np.allclose(b.follow_in_wedge(1.0, -1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0), (0.0, 0.0))
    ahead = np.array(b.clear_path(1.0, 0.2, 0.0, 0.0, 1.0, 0.0))
    assert ahead[1] > 0.2  # aside, to the side of the follower
    assert b.clear_path(-1.0, 0.2, 0.0, 0.0, 1.0, 0.0) == (0.0, 0.0)
    assert b.clear_path(1.0, 0.9, 0.0, 0.0, 1.0, 0.0) == (0.0, 0.0)


@given(st.integers(0, 2**31), st.integers(0, 4000), st.integers(0, 2**31))
def test_hash_is_in_the_unit_interval(seed, agent, turn):
    assert 0.0 <= b.hash_unit(seed, agent, turn) < 1.0
