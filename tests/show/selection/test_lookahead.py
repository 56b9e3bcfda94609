"""Foresight: the next measure is chosen for what comes after it, too."""

from dataclasses import replace

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.graph.motion_graph import build_graph
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.step_library import build_library
from live.show.patch.patch_reader import parse_patch
from live.show.selection.lookahead import IMPOSSIBLE, StepCosts
from live.show.show import Show
from tests.fixtures.made_steps import made_clip

PATCH = """
name = "poses"
[clock]
bpm = 120
[[group]]
name = "all"
dancers = 6
steps = ["sway", "spin", "bow"]
size = [8.0, 2.0]
"""


@pytest.fixture(scope="module")
def graph():
    """Sways that end in two poses; a spin begins only in one of them, a bow leads back from the other end."""
    steps = [
        replace(made_clip("sway"), begin_pose="low", end_pose="low"),
        replace(made_clip("sway"), begin_pose="low", end_pose="high"),
        replace(made_clip("spin"), begin_pose="high", end_pose="high"),
        replace(made_clip("bow", measures=2), begin_pose="high", end_pose="low"),
    ]
    return build_graph(build_library(steps), threshold=0.2)


def test_a_node_costs_what_goes_wrong_after_it(graph):
    """sway, spin: the sway that ends low leads to no spin, so one measure is wrong; the spin at once is wrong, too."""
    ahead = StepCosts(graph).sequence_cost((SequenceEntry(0), SequenceEntry(1)), 0)
    low, high, spin = ahead[:3]
    assert high < 0.5
    assert 0.5 < low < 2.0
    assert spin > 1.0
    assert (
        StepCosts(graph).sequence_cost((SequenceEntry(2, 2),), 1)[4] < 0.5
    )  # in the middle of a bow only its second measure fits


def test_what_is_asked_again_is_not_searched_again(graph):
    foresight = StepCosts(graph)
    wanted = (SequenceEntry(0), SequenceEntry(1))
    assert foresight.sequence_cost(wanted, 0) is foresight.sequence_cost(wanted, 0)
    for n in range(200):
        foresight.sequence_cost((SequenceEntry(0),) * (n + 1), 0)
    assert len(foresight._kept) <= 64


def test_a_single_step_is_counted_in_measures_until_it(graph):
    away = StepCosts(graph).step_distance(1)
    assert away[2] == 0.0
    assert away.min() >= 0.0
    assert away.max() <= 1.0 + IMPOSSIBLE


def test_dancers_choose_the_sway_from_which_they_can_spin(graph):
    """Both sways fit where they stand; only one lets the sequence go on. Nobody ever dances a wrong step."""
    show = Show(parse_patch(PATCH, "test.toml"), graph)
    danced = []
    for tick in range(1, 64 * 40):
        if show.tick(tick * TICK):
            steps = {show.graph.library.steps[s] for s in show.graph.library.node_step[show.dancers.node]}
            danced.append(steps)
    assert show.scheduler.detours == 0
    wanted = [{"sway"}, {"spin"}, {"bow"}, {"bow"}] * 5
    assert np.any([danced[n : n + 12] == wanted[:12] for n in range(5)])
