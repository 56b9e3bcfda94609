"""Tests of elements, obstacles and walls in the stage view, and of the steering response."""

import numpy as np

from live.base.element_kinds import ATTRACTOR, CROSSING, PARTICIPANT, PATH
from live.base.stage_snapshot import StageView
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.skeleton import JOINT_COUNT
from tests.show.made_show import made_show

SET = """
[[obstacle]]
name = "plinth"
at = [-5.0, 3.5]
radius = 0.4
[[obstacle]]
name = "screen"
at = [5.0, -3.5]
wall_to = [5.5, -2.5]
[[element]]
kind = "path"
measure = 1
points = [[-3, 2], [3, 2], [3, -2]]
closed = true
radius = 0.5
[[element]]
kind = "cross"
measure = 1
at = [0, -1]
to = [0, 1]
"""


def test_stage_view_contains_elements_obstacles_and_walls():
    show = made_show(SET)
    show.apply(events.Performer(time=0.0, source="camera", name="Ana", x=4.0, z=3.0))
    show.apply(
        events.PlaceElement(
            time=0.0, source="phone", kind="attract", points=((1.5, -0.5),), measures=2.0, fair=True, drag=True
        )
    )
    for tick in range(1, 65):
        show.tick(tick * TICK)
    view = StageView.allocate(9, JOINT_COUNT)
    show.fill(view, show.time)
    np.testing.assert_allclose(view.obstacle[: view.obstacle_count], [[-5, 3.5, 0.4, 1], [4, 3, 0.25, 0]])
    np.testing.assert_allclose(view.wall[: view.wall_count], [[5, -3.5, 5.5, -2.5]])
    assert view.element_kind[: view.element_count].tolist() == [CROSSING, PATH, PARTICIPANT]
    assert ATTRACTOR not in view.element_kind[: view.element_count]
    assert view.element_corners[:3].tolist() == [2, 4, 0]
    first = view.element_first[1]
    assert view.element_corner[first : first + 4].tolist() == [[-3, 2], [3, 2], [3, -2], [-3, 2]]
    assert view.element_radius[1] == 0.5
    assert view.element_position[2].tolist() == [1.5, -0.5]
    show.apply(events.RemoveObstacle(time=show.time, source="test", name="plinth"))
    show.fill(view, show.time)
    assert view.obstacle[: view.obstacle_count, 3].tolist() == [0.0]


def test_agents_respond_smoothly_to_attractor_within_two_ticks():
    shows = made_show(), made_show()
    velocities = []
    for tick in range(1, 400):
        if tick == 300:
            shows[1].apply(
                events.PlaceElement(
                    time=shows[1].time, source="test", kind="attract", points=((5.0, -2.0),), measures=2.0
                )
            )
        for show in shows:
            show.tick(tick * TICK)
        velocities.append([show.state.velocity.astype(np.float64) for show in shows])
    plain, thrown = np.array(velocities).transpose(1, 0, 2, 3)
    np.testing.assert_array_equal(plain[:299], thrown[:299])
    changed = np.hypot(*(thrown - plain).transpose(2, 0, 1))
    assert np.median(changed[300]) > 0.001  # m/s: the second tick with it
    bends = np.hypot(*np.diff(thrown[299:330], axis=0).transpose(2, 0, 1)) / TICK
    assert bends.max() < 6.0  # m/s², and less than a quarter of it at once: accelerations lag
    assert np.hypot(*(thrown[299] - plain[299]).T).max() / TICK < 1.5


def test_states_of_dancers_tell_their_present_group():
    show = made_show()
    assert show.motion.group_states().tolist() == [1] * 5 + [2] * 4
    show.casting.regroup(np.arange(9) == 0, 1)
    assert show.motion.group_states().tolist() == [2, 1, 1, 1, 1, 2, 2, 2, 2]
