"""Metrics of paths with known values."""

import numpy as np
import pytest

from live.agents.scenarios.metrics import measure
from live.agents.scenarios.scenario import Scenario


def scenario(start, goal, **options):
    goals = tuple(np.array([point], float) for point in goal)
    return Scenario(60.0, 0.25, 1.3, 1.8, 0.3, np.array(start, float).reshape(-1, 2), goals, **options)


def sample_motion(seconds, ways, rate=64):
    """(time, position) of agents whose position is a function of time."""
    time = np.arange(round(seconds * rate) + 1) / rate
    return time, np.stack([np.stack(np.broadcast_arrays(*way(time)), axis=1) for way in ways], axis=1).astype(float)


def test_straight_path_at_preferred_speed_is_ideal():
    time, position = sample_motion(12, [lambda t: (np.minimum(1.3 * t, 13.0), 0.0)])
    figures = measure(scenario([[0, 0]], [[13, 0]]), time, position)
    assert figures.done == 1
    assert figures.time_ratio == pytest.approx(1, abs=0.002)
    assert figures.last_arrival == pytest.approx(12.7 / 1.3, abs=1 / 60)
    assert figures.path_efficiency == pytest.approx(1, abs=0.002)
    assert figures.energy == pytest.approx((2.23 + 1.26 * 1.69) / (2 * np.sqrt(2.23 * 1.26) * 1.3), abs=0.003)
    assert figures.jerk == pytest.approx(0, abs=1e-6)
    assert figures.turn_p99 == pytest.approx(0, abs=1e-6)
    assert figures.overlaps == 0


def test_agent_that_never_arrives_has_no_arrival_time():
    time, position = sample_motion(2, [lambda t: (t, 0.0), lambda t: (2 * t, 5.0)])
    figures = measure(scenario([[0, 0], [0, 5]], [[4, 0], [4, 5]]), time, position)
    assert figures.done == 0.5
    assert figures.last_arrival == pytest.approx(1.85, abs=1 / 60)
    standing = measure(scenario([[0, 0]], [[4, 0]]), *sample_motion(2, [lambda t: (0.0 * t, 0.0)]))
    assert standing.done == 0
    assert standing.as_json()["last_arrival"] is None
    assert standing.as_json()["turn_p99"] is None


def test_overlaps_are_counted_at_onset_and_contact_by_duration():
    """Two bodies: 1 m apart, then 49.6 cm (legal), 48 cm (overlap), 51 cm (touching), 47 cm (overlap), apart."""
    edges, gaps = [1.0, 2.0, 3.0, 4.0, 5.0], [1.0, 0.496, 0.48, 0.51, 0.47, 1.0]

    def way(t):
        return np.array(gaps)[np.searchsorted(edges, t, side="right")], 0.0

    figures = measure(
        scenario([[0, 0], [1, 0]], [[9, 9], [9, 9]]), *sample_motion(6, [lambda t: (0.0 * t, 0.0), way], 60)
    )
    assert figures.overlaps == 2
    assert figures.overlaps_per_agent_minute == pytest.approx(2 / (2 * 0.1), rel=0.01)
    assert figures.deepest == pytest.approx(0.03)
    assert figures.touching == pytest.approx(4.0)  # 2 · 4 s / 2 agents


def test_turn_rate_and_jerk_of_circle_are_analytic():
    speed, radius = 1.2, 2.0
    rate = speed / radius

    def way(t):
        return radius * np.sin(rate * t), radius * np.cos(rate * t)

    figures = measure(scenario([[0, 2]], [[50, 50]]), *sample_motion(8, [way], 60))
    assert figures.turn_mean == pytest.approx(np.degrees(rate), rel=1e-3)
    assert figures.turn_p99 == pytest.approx(np.degrees(rate), rel=1e-3)
    assert figures.acceleration == pytest.approx(speed * rate, rel=1e-3)
    assert figures.jerk == pytest.approx(speed * rate**2, rel=1e-3)


def test_motion_after_arrival_is_excluded():
    """The agent arrives at 3 s and is then shaken: jerk and turns after arrival are excluded."""

    def way(t):
        return np.minimum(t, 3.0), np.where(t > 3.0, 0.1 * np.sin(40 * t), 0.0)

    figures = measure(scenario([[0, 0]], [[3.29, 0]]), *sample_motion(9, [way], 60))
    assert figures.done == 1
    assert figures.jerk == pytest.approx(0, abs=1e-6)


def test_measurement_ends_when_all_agents_arrived():
    close = [lambda t: (np.minimum(t, 2.0), 0.0), lambda t: (np.minimum(t, 2.0), np.where(t < 4, 1.0, 0.3))]
    figures = measure(scenario([[0, 0], [0, 1]], [[2, 0], [2, 1]]), *sample_motion(8, close))
    assert figures.overlaps == 0


def test_endless_or_empty_scenario_has_no_overlaps():
    figures = measure(scenario([[0, 0]], [[0, 0]], endless=True), *sample_motion(2, [lambda t: (t, 0.0)]))
    assert figures.as_json()["done"] is None
    assert figures.overlaps == 0
    nobody = measure(scenario([], []), np.arange(65) / 64, np.zeros((65, 0, 2)))
    assert nobody.done == 1
    assert nobody.overlaps == 0
