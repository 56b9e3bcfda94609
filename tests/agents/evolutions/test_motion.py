"""Flows, followers, pursuers, paths and wanderers, run in the crowd."""

import numpy as np
import pytest

from live.agents.elements.element import Element
from live.agents.elements.polyline_flow import flow_grid_along, simplified_vertices
from live.base.element_kinds import (
    DRAWN,
    EVADE,
    FLOCK,
    FLOW,
    FOLLOW,
    GRID,
    OUTLINE_VERTICES,
    PATH,
    PURSUE,
    RADIAL,
    VORTEX,
    WANDER,
)
from tests.agents.elements.made_stage import StageHarness


def test_flows_have_their_declared_directions():
    agents = [[2.0, 0.0], [-1.0, 1.0]]
    uniform = StageHarness(agents, Element(FLOW, ((0.0, 0.0), (3.0, 4.0)))).wish()
    assert uniform == pytest.approx(np.tile([0.6, 0.8], (2, 1)), abs=1e-6)
    out = StageHarness(agents, Element(FLOW, flow_kind=RADIAL)).wish()
    assert out[0] == pytest.approx([1.0 - np.exp(-2.0 / 1.2), 0.0], abs=1e-6)
    inwards = StageHarness(agents, Element(FLOW, flow_kind=RADIAL, strength=-1.0)).wish()
    assert inwards == pytest.approx(-out, abs=1e-6)
    turn = StageHarness(agents, Element(FLOW, flow_kind=VORTEX)).wish()
    assert np.abs((turn * out).sum(1)).max() < 1e-6
    assert turn[0, 1] > 0.0
    limited = StageHarness(agents, Element(FLOW, ((0.0, 0.0), (3.0, 4.0)), radius=1.3)).wish()
    assert limited[0] == pytest.approx([0.12, 0.16], abs=1e-5)  # 0.3 m outside of its 1.3 m: a fifth of it


def test_vortex_moves_dancers_around_its_center():
    stage = StageHarness([[2.5, 0.0], [0.0, -2.0]], Element(FLOW, flow_kind=VORTEX, start_beat=-9.0))
    kept = stage.run(8.0)
    angle = np.unwrap(np.arctan2(kept[..., 1], kept[..., 0]), axis=0)
    assert (angle[-1] - angle[0] > 2.0).all()
    assert np.hypot(*kept[-1].T) == pytest.approx([2.5, 2.0], abs=1.0)


def test_drawn_flow_leads_dancers_along_its_line():
    t = np.linspace(0.0, np.pi, 500)
    arc = tuple(map(tuple, np.stack([-4 * np.cos(t), 3 - 4 * np.sin(t)], 1)))
    assert len(simplified_vertices(arc, OUTLINE_VERTICES)) <= OUTLINE_VERTICES
    start = [[-4.5, 2.5], [-2.0, 0.5], [-3.0, 2.8]]
    stage = StageHarness(start, Element(FLOW, arc, flow_kind=DRAWN, start_beat=-9.0))
    kept = stage.run(7.0)
    near = np.abs(np.hypot(kept[24:, :, 0], kept[24:, :, 1] - 3.0) - 4.0)
    assert near.mean() < 0.5
    assert (kept[-1, :, 0] > 1.0).all()
    assert np.abs(flow_grid_along(arc, 6.0, 4.0)).max() <= 1.0


def test_custom_flow_grid_sets_velocity():
    grid = np.zeros((24, 32, 2), np.float32)
    grid[..., 1] = 0.5
    stage = StageHarness([[1.0, 1.0]])
    stage.field.add(Element(FLOW, flow_kind=GRID), grid)
    assert stage.wish()[0] == pytest.approx([0.0, 0.5], abs=1e-5)


@pytest.mark.parametrize("wedge", [False, True])
def test_followers_line_up_behind_their_leader(wedge):
    walk = Element(FLOW, ((0.0, 0.0), (1.0, 0.0)), strength=0.5, groups=1, start_beat=-9.0)
    follow = Element(FOLLOW, target=0, groups=2, wedge=wedge, start_beat=-9.0, separation=0.6)
    start = [[-3.0, 0.0], [-4.0, 2.0], [-2.0, 1.0], [-5.0, -1.0], [-3.0, -2.0]]
    stage = StageHarness(start, walk, follow, groups=[1, 2, 2, 2, 2], size=(16.0, 8.0))
    end = stage.run(10.0)[-1]
    assert (end[1:, 0] < end[0, 0]).all()
    aside = np.abs(end[1:, 1] - end[0, 1])
    if wedge:
        assert len(set(np.sign(end[1:, 1] - end[0, 1]))) == 2
        assert aside.min() > 0.4
    else:
        assert aside.max() < 0.9
        assert (np.diff(end[:, 0]) < -0.4).all()  # in the order of their numbers


def test_group_follows_first_dancer_of_target_group():
    stage = StageHarness([[3.0, 0.0], [-3.0, 0.0]], Element(FOLLOW, target_group=4, groups=2), groups=[1 << 4, 2])
    assert stage.wish()[1, 0] > 0.9
    assert (stage.wish()[0] == 0.0).all()


def test_pursuer_approaches_and_evader_retreats():
    groups = [1, 2]
    hunt = Element(PURSUE, target_group=1, groups=1, start_beat=-9.0, separation=0.5)
    stage = StageHarness([[-4.0, 0.0], [0.0, 0.5]], hunt, groups=groups)
    kept = stage.run(3.0)
    assert np.hypot(*(kept[-1, 0] - kept[-1, 1])) < 1.6
    evade = Element(EVADE, target_group=0, groups=2)
    wish = StageHarness([[-1.0, 0.0], [0.0, 0.0], [5.0, 0.0]], evade, groups=[1, 2, 2]).wish()
    assert wish[1, 0] == pytest.approx(np.exp(-1.0 / 2.5), abs=1e-5)
    assert wish[2, 0] == pytest.approx(np.exp(-6.0 / 2.5), abs=1e-5)
    assert (wish[0] == 0.0).all()


def test_element_with_missing_target_moves_no_dancer():
    elements = [Element(kind, target=7) for kind in (FOLLOW, PURSUE, EVADE)]
    elements += [Element(kind, target_group=9) for kind in (FOLLOW, PURSUE, EVADE)]
    stage = StageHarness([[0, 0], [1, 1]], *elements)
    assert (stage.wish() == 0.0).all()
    assert (stage.field.influence == 0.0).all()


def test_closed_path_loops_and_open_path_stops_at_end():
    square = ((-3.0, -2.0), (3.0, -2.0), (3.0, 2.0), (-3.0, 2.0))
    stage = StageHarness([[0.0, -2.5]], Element(PATH, square, closed=True, start_beat=-9.0))
    kept = stage.run(18.0)[:, 0]
    angle = np.unwrap(np.arctan2(kept[:, 1] / 2, kept[:, 0] / 3))
    assert angle[-1] - angle[0] > 5.0
    ended = StageHarness([[-3.0, -2.5]], Element(PATH, square, start_beat=-9.0)).run(18.0)[-1, 0]
    assert np.hypot(*(ended - square[-1])) < 0.15


def test_flock_sets_weights_and_wanderers_keep_moving():
    stage = StageHarness([[0, 0]], Element(FLOCK, alignment=0.7, cohesion=0.3, start_beat=7.5))
    stage.wish(8.0)
    faded = 1.0 - 0.5**4  # half a beat after its start
    assert stage.wants.alignment[0] == pytest.approx(0.7 * faded)
    assert stage.wants.cohesion[0] == pytest.approx(0.3 * faded)
    wander = StageHarness([[0, 0], [3, 1]], Element(WANDER, start_beat=-9.0))
    kept = wander.run(20.0)
    assert np.hypot(*np.diff(kept[16:], axis=0).T).mean() / 0.125 > 0.8
    assert np.abs(kept).max(axis=(0, 1)) == pytest.approx([5.0, 3.5], abs=1.01)
