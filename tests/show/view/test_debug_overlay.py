"""Debug overlay: lines show agents, predictions and locked feet of visible dancers, within capacity."""

import numpy as np

from live.clock.ticks import TICK
from live.motion.pose.foot_lock_kernels import HELD
from live.show.view import debug_overlay as guides
from live.show.view.debug_overlay import AGENT_COLOUR, CROSS_M, FEET, LOCKED_COLOUR, RING, RING_M, draw_guides
from tests.show.made_show import made_show


def run_show(ticks, **options):
    """A show after so many ticks, its view, and the guides in it (n, 10)."""
    show = made_show(**options)
    for tick in range(1, ticks + 1):
        show.tick(tick * TICK)
    view = show.view()
    show.fill(view, ticks * TICK)
    draw_guides(show, view)
    return show, view, view.guide[: view.guide_count]


def with_color(guide, colour):
    return guide[np.abs(guide[:, 6:] - np.float32(colour)).max(axis=1) < 1e-6]


def test_line_joins_each_dancer_to_her_agent():
    show, view, guide = run_show(200)
    strokes = with_color(guide, AGENT_COLOUR)
    count = len(view.group)
    assert len(strokes) == 3 * count  # a line and the two of a cross
    np.testing.assert_allclose(strokes[:count, (0, 2)], view.joint_position[:, 0][:, (0, 2)], atol=1e-5)
    np.testing.assert_allclose(strokes[:count, (3, 5)], show.state.position, atol=1e-5)
    arms = (strokes[count:, 3:6] - strokes[count:, :3])[:, (0, 2)]
    np.testing.assert_allclose(np.hypot(*arms.T), 2 * CROSS_M, rtol=1e-4)


def test_square_marks_each_locked_foot():
    show, view, guide = run_show(200)
    held = show.dancers.lock.state[:, :, HELD] > 0.0
    strokes = with_color(guide, LOCKED_COLOUR)
    assert held.any()
    assert len(strokes) == 4 * held.sum()
    middle = strokes[:, (0, 2)].mean(axis=0)
    feet = np.concatenate([view.joint_position[held[:, side], joint][:, (0, 2)] for side, joint in enumerate(FEET)])
    np.testing.assert_allclose(middle, feet.mean(axis=0), atol=1e-4)


def test_ring_marks_each_prediction_and_reddens_with_error():
    show, view, guide = run_show(280)  # the second measure, decided a beat before it began
    target = show.scheduler.last_target
    rings = guide[-RING * len(view.group) :].reshape(RING, len(view.group), 10)
    np.testing.assert_allclose(rings[..., (0, 2)].mean(axis=0), target, atol=1e-4)
    np.testing.assert_allclose(np.hypot(*(rings[0, :, (0, 2)] - target.T)), RING_M, rtol=1e-3)
    off = np.hypot(*(target - show.dancers.present.end_position()).T)
    order = np.argsort(off)
    assert (np.diff(rings[0, order, 6]) >= -1e-6).all()  # the farther the redder


def test_dancers_in_reserve_have_no_guides():
    _, view, guide = run_show(100, reserve=3)
    assert len(with_color(guide, AGENT_COLOUR)) == 3 * view.present.sum() < 3 * len(view.group)


def test_guides_are_limited_to_capacity(monkeypatch):
    monkeypatch.setattr(guides, "GUIDE_CAPACITY", 20)
    _, view, guide = run_show(280)
    assert view.guide_count == len(guide) == 20
    assert not view.guide[20:].any()
