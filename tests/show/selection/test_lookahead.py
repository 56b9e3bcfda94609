"""Lookahead: the cost of the next measure includes the measures after it."""

from dataclasses import replace

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.graph.motion_graph import build_graph
from live.graph.search.sequence_spec import SequenceEntry
from live.graph.step_library import build_library
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from live.show.selection.lookahead import IMPOSSIBLE, StepCosts
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


def test_node_cost_includes_wrong_steps_after_it(graph):
    """For sway, spin: a sway that ends low leads to no spin (one wrong measure); an immediate spin is wrong, too."""
    ahead = StepCosts(graph).sequence_cost((SequenceEntry(0), SequenceEntry(1)), 0)
    low, high, spin = ahead[:3]
    assert high < 0.5
    assert 0.5 < low < 2.0
    assert spin > 1.0
    assert (
        StepCosts(graph).sequence_cost((SequenceEntry(2, 2),), 1)[4] < 0.5
    )  # in the middle of a bow only its second measure fits


def test_sequence_costs_are_cached_and_bounded(graph):
    foresight = StepCosts(graph)
    wanted = (SequenceEntry(0), SequenceEntry(1))
    assert foresight.sequence_cost(wanted, 0) is foresight.sequence_cost(wanted, 0)
    for n in range(200):
        foresight.sequence_cost((SequenceEntry(0),) * (n + 1), 0)
    assert len(foresight._kept) <= 64


def test_step_distance_counts_measures_to_the_step(graph):
    away = StepCosts(graph).step_distance(1)
    assert away[2] == 0.0
    assert away.min() >= 0.0
    assert away.max() <= 1.0 + IMPOSSIBLE


def test_dancers_choose_sway_that_leads_to_spin(graph):
    """Both sways fit in place; only one lets the sequence continue. No dancer ever dances a wrong step."""
    show = assemble(parse_patch(PATCH, "test.toml"), graph)
    danced = []
    for tick in range(1, 64 * 40):
        if show.tick(tick * TICK):
            steps = {show.graph.library.steps[s] for s in show.graph.library.node_step[show.dancers.node]}
            danced.append(steps)
    assert show.scheduler.detours == 0
    wanted = [{"sway"}, {"spin"}, {"bow"}, {"bow"}] * 5
    assert np.any([danced[n : n + 12] == wanted[:12] for n in range(5)])
