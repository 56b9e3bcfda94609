"""Tests of the output editor: points, dragging, refused moves and undo."""

import numpy as np
import pytest

from live.render.outputs.output import FULL_WINDOW, MAX_MESH_POINTS, Output
from live.render.outputs.warp import check_mesh, regular_mesh, warp_grid
from live.render.outputs.warp_editor import MAX_UNDO_STEPS, WarpEditor

PINNED = Output(corners=((0.1, 0.1), (0.9, 0.0), (1.0, 1.0), (0.0, 0.9)))


def test_dragged_corner_moves_and_drag_is_one_undo_step():
    editing = WarpEditor(Output())
    assert editing.grab((0.98, 0.03), 16 / 9)
    assert editing.chosen == 1
    editing.drag((0.9, 0.1))
    editing.drag((0.85, 0.12))
    editing.release()
    editing.drag((0.1, 0.9))  # nobody holds it any more
    assert editing.output.corners == ((0.0, 0.0), (0.85, 0.12), (1.0, 1.0), (0.0, 1.0))
    assert editing.is_changed
    editing.undo()
    assert editing.output.corners == FULL_WINDOW  # one drag is one step


def test_grab_away_from_points_selects_nothing():
    editing = WarpEditor(Output())
    assert not editing.grab((0.5, 0.5), 1.0)
    editing.drag((0.2, 0.2))
    assert editing.output == Output()


def test_point_is_selected_and_nudged_by_keys():
    editing = WarpEditor(Output())
    editing.next()
    editing.next()
    editing.next(-1)
    editing.nudge(-0.01, 0.02)
    assert editing.output.corners[1] == pytest.approx((0.99, 0.02))
    for _ in range(4):
        editing.next()
    assert editing.chosen == 1


def test_move_that_crosses_corners_is_refused_with_reason():
    editing = WarpEditor(Output())
    editing.grab((0.0, 0.0), 1.0)
    editing.drag((0.4, 0.4))
    good = editing.output
    editing.drag((1.5, 1.5))
    assert editing.output == good
    assert "corners" in editing.problem
    editing.drag((0.3, 0.2))
    assert editing.problem == ""
    editing.undo()
    assert editing.output == Output()


def test_every_step_is_undone():
    editing = WarpEditor(PINNED)
    chance = np.random.default_rng(7)
    states = [editing.output]
    for _ in range(60):
        match chance.integers(6):
            case 0:
                editing.toggle_mesh()
            case 1:
                editing.refine(int(chance.choice([-1, 1])))
            case 2:
                editing.reset()
            case _:
                editing.next(int(chance.integers(1, 4)))
                editing.nudge(*chance.uniform(-0.03, 0.03, 2))
        check_mesh(editing.output.mesh)
        if editing.output != states[-1]:
            states.append(editing.output)
    assert len(states) > 30
    for expected in reversed(states[:-1]):
        while editing.output == states[-1]:
            editing.undo()
        assert editing.output == expected
        states.pop()
    editing.undo()
    assert editing.output == PINNED


def test_new_mesh_is_regular_within_corners():
    editing = WarpEditor(PINNED)
    editing.toggle_mesh()
    assert editing.output.mesh == regular_mesh(3, 3)
    points = np.array(editing.points).reshape(3, 3, 2)
    np.testing.assert_allclose(points[[0, 0, 2, 2], [0, 2, 2, 0]], PINNED.corners, atol=1e-12)
    editing.grab(tuple(points[1, 1]), 1.0)
    assert editing.chosen == 4
    editing.drag((0.5, 0.6))
    np.testing.assert_allclose(editing.points[4], (0.5, 0.6), atol=1e-9)
    editing.toggle_mesh()
    assert len(editing.points) == 4


def test_refined_mesh_keeps_shape():
    editing = WarpEditor(Output())
    editing.toggle_mesh()
    editing.chosen = 4
    editing.nudge(0.05, -0.03)
    shares = np.linspace(0, 1, 21)
    before = warp_grid(editing.output.mesh, shares, shares)
    editing.refine(2)
    assert len(editing.output.mesh) == 5
    assert np.abs(warp_grid(editing.output.mesh, shares, shares) - before).max() < 0.012
    for _ in range(30):
        editing.refine(1)
    assert len(editing.output.mesh) == MAX_MESH_POINTS


def test_undo_stack_is_bounded():
    editing = WarpEditor(Output())
    for _ in range(3 * MAX_UNDO_STEPS):
        editing.nudge(1e-4, 0.0)
    assert len(editing._undo_stack) == MAX_UNDO_STEPS
