"""The ladder of quality on machines made for the test: as good as can be held, and no swinging to and fro."""

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


class Machine:
    """Draws frames whose time depends on the step, with a pacer that waits for the next display's picture."""

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
def test_it_goes_down_to_the_first_step_that_can_be_held_and_stays(holds):
    costs = [0.03] * holds + [0.010] * (5 - holds)
    machine = Machine(costs).run(WARM_UP_S + holds * (SETTLE_S + 0.5) + 1.0)
    assert machine.ladder.step == holds
    late = machine.late
    machine.run(10.0)
    assert machine.ladder.step == holds
    assert machine.late == late


def test_the_first_step_down_comes_within_a_moment_but_not_while_drivers_compile():
    machine = Machine([0.03, 0.01]).run(WARM_UP_S)
    assert machine.ladder.step == 0
    assert machine.run(0.3).ladder.step == 1


def test_it_comes_back_slowly_step_by_step_when_there_is_room():
    machine = Machine([0.03, 0.03, 0.0155]).run(30.0)
    assert machine.ladder.step == 2
    machine.costs = [0.004, 0.004, 0.004]
    machine.run(PATIENCE_S - 1.0)
    assert machine.ladder.step == 2
    machine.run(5.0)
    assert machine.ladder.step == 1
    machine.run(PATIENCE_S + 2.0)
    assert machine.ladder.step == 0


def test_without_room_it_does_not_go_up():
    machine = Machine([0.03, 0.0155]).run(300.0)  # in time, but only just
    assert machine.ladder.step == 1
    assert machine.ladder.changes == 1


def test_what_looks_easy_and_is_not_is_tried_ever_more_rarely():
    machine = Machine([0.03, 0.004]).run(1800.0)
    ups = [now < before for before, now in pairwise(machine.steps)]
    assert 3 <= sum(ups) <= 12
    assert machine.late < 1800.0 / PERIOD * 0.01


def test_a_single_late_frame_changes_nothing():
    machine = Machine([0.004, 0.002]).run(20.0)
    machine.costs = [0.04, 0.002]
    machine.run(0.04)
    machine.costs = [0.004, 0.002]
    machine.run(20.0)
    assert machine.ladder.changes == 0


@pytest.mark.parametrize("best", [SOFTWARE, HARDWARE], ids=["software", "card"])
def test_each_step_draws_less_than_the_one_above_and_the_resolution_comes_last(best):
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


def test_steps_that_take_nothing_from_this_picture_are_passed_over_both_ways():
    machine = Machine([0.03, 0.03, 0.03, 0.01, 0.01])
    machine.ladder = QualityController(5, lambda step: step not in (1, 2))
    machine.run(WARM_UP_S + 0.5)
    assert machine.steps[-1] == 3
    assert machine.ladder.changes == 1
    machine.costs = [0.001] * 5
    machine.run(PATIENCE_S + 1.0)
    assert machine.ladder.step == 2  # without what step 3 takes; what 1 and 2 take is not there
    machine.run(PATIENCE_S + 1.0)
    assert machine.ladder.step == 0


def test_a_step_that_is_held_stays_until_it_is_let_go():
    machine = Machine([0.03] * 4 + [0.001])
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


def test_on_an_overloaded_machine_a_single_late_frame_takes_a_step_down_and_none_is_taken_up():
    machine = Machine([0.004, 0.002, 0.002]).run(20.0)
    machine.overload = 1.0
    machine.costs = [0.04, 0.002, 0.002]
    machine.run(0.04)
    machine.costs = [0.004, 0.002, 0.002]
    machine.run(100.0)
    assert (machine.ladder.step, machine.ladder.changes) == (1, 1)
    machine.overload = 0.0
    machine.run(PATIENCE_S + 5.0)
    assert machine.ladder.step == 0
