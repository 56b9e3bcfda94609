"""Tests of the step library: nodes, travel and names."""

import pytest

from live.graph.step_library import build_library
from tests.fixtures.made_steps import SAMPLES_PER_BEAT, made_steps


def test_every_measure_is_a_node_with_travel():
    library = build_library(made_steps())
    assert library.node_count == 9
    per_measure = 4 * SAMPLES_PER_BEAT
    assert (library.node_last - library.node_first).tolist() == [per_measure] * 9
    assert library.node_first[0] == per_measure
    assert library.node_travel[2] == pytest.approx((0.0, 0.8))
    assert library.max_travel(library.steps.index("glide")) == pytest.approx(0.8)
    assert library.max_travel(library.steps.index("sway")) == 0.0
    assert (library.node_lead <= library.node_first - per_measure + 1e-9)[:7].all()


@pytest.mark.parametrize("name", ["sway", "Sway", " SWAY "])
def test_names_ignore_case_and_blanks(name):
    library = build_library(made_steps())
    assert library.step_index(name) == 0
    assert library.step_index("swaying") is None


def test_node_description_has_step_and_measure():
    library = build_library(made_steps())
    assert library.describe(2) == "glide long forward"
    assert library.describe(8) == "phrase 2/2"
