"""The quality controller on simulated machines: highest sustainable step, without oscillation."""

from itertools import pairwise

import pytest

from live.render.adaptive_quality import (
    HARDWARE,
    PATIENCE_S,
    SETTLE_S,
    SOFTWARE,
    WARM_UP_S,
    QualityController,
    quality_steps,
)

PERIOD = 1.0 / 60.0


class SimulatedMachine:
    """Draws frames whose duration depends on the step, with a pacer that waits for the next display refresh."""

    def __init__(self, costs):
        self.ladder = QualityController(len(costs))
        self.costs, self.late, self.time, self.overload = costs, 0, 0.0, 0.0
        self.steps = []

    def run(self, seconds):
        end = self.time + seconds
        while self.time < end:
            cost = self.costs[self.ladder.step]
            took = PERIOD * -(-cost // PERIOD)  # up to the display's next picture
            late = took > 1.5 * PERIOD
            self.late += late
            self.time += took
            self.steps.append(self.ladder.update(late, took, cost / PERIOD, self.overload))
        return self


@pytest.mark.parametrize("holds", range(5))
def test_controller_settles_at_first_sustainable_step(holds):
    costs = [0.03] * holds + [0.010] * (5 - holds)
    machine = SimulatedMachine(costs).run(WARM_UP_S + holds * (SETTLE_S + 0.5) + 1.0)
    assert machine.ladder.step == holds
    late = machine.late
    machine.run(10.0)
    assert machine.ladder.step == holds
    assert machine.late == late


def test_first_step_down_follows_shortly_after_warm_up():
    machine = SimulatedMachine([0.03, 0.01]).run(WARM_UP_S)
    assert machine.ladder.step == 0
    assert machine.run(0.3).ladder.step == 1


def test_quality_rises_slowly_step_by_step_with_headroom():
    machine = SimulatedMachine([0.03, 0.03, 0.0155]).run(30.0)
    assert machine.ladder.step == 2
    machine.costs = [0.004, 0.004, 0.004]
    machine.run(PATIENCE_S - 1.0)
    assert machine.ladder.step == 2
    machine.run(5.0)
    assert machine.ladder.step == 1
    machine.run(PATIENCE_S + 2.0)
    assert machine.ladder.step == 0


def test_quality_does_not_rise_without_headroom():
    machine = SimulatedMachine([0.03, 0.0155]).run(300.0)  # in time, but only just
    assert machine.ladder.step == 1
    assert machine.ladder.changes == 1


def test_failed_step_up_is_retried_at_growing_intervals():
    machine = SimulatedMachine([0.03, 0.004]).run(1800.0)
    ups = [now < before for before, now in pairwise(machine.steps)]
    assert 3 <= sum(ups) <= 12
    assert machine.late < 1800.0 / PERIOD * 0.01


def test_a_single_late_frame_changes_nothing():
    machine = SimulatedMachine([0.004, 0.002]).run(20.0)
    machine.costs = [0.04, 0.002]
    machine.run(0.04)
    machine.costs = [0.004, 0.002]
    machine.run(20.0)
    assert machine.ladder.changes == 0


@pytest.mark.parametrize("best", [SOFTWARE, HARDWARE], ids=["software", "card"])
def test_each_step_costs_less_and_resolution_is_reduced_last(best):
    steps = quality_steps(best)
    assert steps[0].quality == best
    names = [step.name for step in steps]
    assert len(set(names)) == len(names)
    assert names[-3:] == ["3/4 of the size", "3/5 of the size", "half the size"]
    for above, below in pairwise(steps):
        a, b = above.quality, below.quality
        assert a != b
        assert set(a.left_out) <= set(b.left_out)
        assert (b.samples, b.floor_map, b.scale, b.near_count) <= (a.samples, a.floor_map, a.scale, a.near_count)
        assert (a.samples > 0) == (b.samples > 0)


def test_steps_without_effect_are_skipped_in_both_directions():
    machine = SimulatedMachine([0.03, 0.03, 0.03, 0.01, 0.01])
    machine.ladder = QualityController(5, lambda step: step not in (1, 2))
    machine.run(WARM_UP_S + 0.5)
    assert machine.steps[-1] == 3
    assert machine.ladder.changes == 1
    machine.costs = [0.001] * 5
    machine.run(PATIENCE_S + 1.0)
    assert machine.ladder.step == 2  # without what step 3 takes; what 1 and 2 take is not there
    machine.run(PATIENCE_S + 1.0)
    assert machine.ladder.step == 0


def test_held_step_stays_until_release():
    machine = SimulatedMachine([0.03] * 4 + [0.001])
    machine.ladder.hold(1)
    assert (machine.run(20.0).ladder.step, machine.ladder.held) == (1, 1)
    machine.ladder.hold(9)
    assert machine.run(20.0).ladder.step == 4
    machine.ladder.hold(0)
    machine.run(5.0)
    machine.ladder.hold(None)
    assert machine.ladder.step == 0
    machine.run(8.0)
    assert machine.ladder.step == 4


def test_overloaded_machine_steps_down_after_one_late_frame_and_never_up():
    machine = SimulatedMachine([0.004, 0.002, 0.002]).run(20.0)
    machine.overload = 1.0
    machine.costs = [0.04, 0.002, 0.002]
    machine.run(0.04)
    machine.costs = [0.004, 0.002, 0.002]
    machine.run(100.0)
    assert (machine.ladder.step, machine.ladder.changes) == (1, 1)
    machine.overload = 0.0
    machine.run(PATIENCE_S + 5.0)
    assert machine.ladder.step == 0
