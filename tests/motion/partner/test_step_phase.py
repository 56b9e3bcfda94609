"""H018: the phase of the step is not in the control, yet sharp turns come on the foot on which they were recorded."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion.partner.partner_synthesis import (
    WALK_SEARCH,
    find_partner,
)
from live.motion.partner.path_leader import frenet_cloud
from live.motion.partner.point_clouds import ends_cloud, path_cloud
from live.motion.partner.step_phase import (
    PhaseAtTurns,
    phase_at_turns,
    phase_difference,
    phase_values,
    pooled,
    sharp_turns,
    step_phases,
)
from live.motion.partner.units import Example, cut_units
from tests.motion.partner.made_walks import RATE, Corner, places, walk


def corners(side: float) -> list[Corner]:
    """Corners of one side at one phase of the step: a quarter of a cycle, to the right three quarters."""
    at = 2.25 if side > 0 else 2.75
    return [Corner(at + 3.0 * n, side * float(np.radians(angle))) for n, angle in enumerate((90, 70, 110, 90))]


def test_sharp_turns_are_found_where_they_are() -> None:
    made = [Corner(2.0, np.pi / 2), Corner(5.0, -1.3), Corner(8.0, 0.4)]  # the last one is no sharp one
    found = sharp_turns(path_cloud(walk("walk", made, 10.0)))
    np.testing.assert_allclose(found.times, [2.0, 5.0], atol=0.06)
    assert (np.sign(found.angles) == [1.0, -1.0]).all()
    assert len(sharp_turns(path_cloud(walk("walk", [], 10.0))).times) == 0
    assert len(sharp_turns(path_cloud(walk("walk", [], 0.3))).times) == 0


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.8])
def test_phase_of_a_steady_walk_is_that_of_its_clock(phase: float) -> None:
    clip = walk("walk", [], 8.0, phase)
    times = np.linspace(1.5, 6.0, 40)
    away = (step_phases(clip, times) - (phase + times)) % 1.0
    assert np.minimum(away, 1.0 - away).max() < 0.03
    assert np.isnan(step_phases(clip, np.array([-1.0, 99.0]))).all()


@pytest.mark.long
def test_turns_of_an_answer_come_on_the_recorded_foot_whenever_the_path_turns() -> None:
    recordings = [walk(f"recorded {side}", corners(side), 15.0) for side in (1.0, -1.0)]
    examples = []
    for clip in recordings:
        landed = np.flatnonzero((np.diff(clip.contact.astype(np.int8), axis=0) > 0).any(axis=1)) + 1.0
        examples.append(Example(clip.name, path_cloud(clip), ends_cloud(clip), clip, np.asarray(landed), np.zeros(0)))
    units = cut_units(examples)
    recorded = pooled([phase_at_turns(clip, path_cloud(clip)) for clip in recordings])
    assert recorded.spread < 0.02
    chance = np.random.default_rng(4)
    answered, steady = [], []
    for _ in range(3):
        times = 2.0 + np.cumsum(chance.uniform(2.2, 3.3, 6))
        made = [Corner(float(at), float(chance.choice([-1.0, 1.0]) * chance.uniform(1.2, 1.9))) for at in times]
        seconds = float(times[-1]) + 2.5
        clock = np.arange(round(seconds * RATE)) / RATE
        path = frenet_cloud(clock, places(made, clock), RATE)
        uninformed = walk("steady", made, seconds)
        search = replace(WALK_SEARCH, max_path_distance=0.12)
        answered.append(phase_at_turns(find_partner(uninformed, path, units, search).clip, path))
        steady.append(phase_at_turns(uninformed, path))
    found, other = pooled(answered), pooled(steady)
    assert found.count == other.count == 18
    assert found.spread < 0.05
    assert phase_difference(found, recorded) < 0.05
    assert found.chance < 1e-4
    assert other.spread > 0.2  # a walk that goes on at its rhythm turns on any foot


def test_circular_statistics() -> None:
    """Fisher 1993: Rayleigh's probability is uniform under chance; the deviation of a narrow normal law is its own."""
    chance = np.random.default_rng(1)
    tried = np.array([PhaseAtTurns(chance.uniform(0, 1, 12)).chance for _ in range(4000)])
    for level in (0.05, 0.2, 0.5):
        assert (tried < level).mean() == pytest.approx(level, abs=0.025)
    narrow = PhaseAtTurns((0.97 + chance.normal(0.0, 0.05, 4000)) % 1.0)
    assert narrow.spread == pytest.approx(0.05, rel=0.05)
    assert phase_difference(narrow, PhaseAtTurns(np.array([0.02]))) == pytest.approx(0.05, abs=0.01)
    assert PhaseAtTurns(np.zeros(0)).chance == 1.0
    assert phase_values(PhaseAtTurns(np.zeros(0))) == {
        "turns": 0, "mean_cycles": None, "spread_cycles": None, "chance": None,
    }  # fmt: skip
