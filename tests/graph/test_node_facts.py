"""Tests of measured node facts: reproducible, and equal to the values cached by the test fixtures."""

import numpy as np

from live.graph.node_features import Moments, NodeFacts, node_facts
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps
from tests.fixtures.remembered import cached_node_facts

WINDOW = 0.1875


def assert_same(one: NodeFacts, other: NodeFacts) -> None:
    for name in NodeFacts.__slots__:
        if name != "moments":
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    for name in Moments.__slots__:
        assert np.array_equal(getattr(one.moments, name), getattr(other.moments, name)), name


def test_facts_of_same_steps_are_bit_identical():
    assert_same(node_facts(build_library(made_steps()), WINDOW), node_facts(build_library(made_steps()), WINDOW))


def test_cached_facts_depend_on_library_and_window():
    libraries = [build_library(made_steps()), build_library([*made_steps(), made_clip("glide on", way=(0.1, 0.2))])]
    for _ in range(2):
        for library in libraries:
            for window in (WINDOW, 2.0 * WINDOW):
                assert_same(cached_node_facts(library, window), node_facts(library, window))


def test_changing_returned_facts_does_not_change_cache():
    library = build_library(made_steps())
    mine = cached_node_facts(library, WINDOW)
    mine.warp_curve[:] = 7.0
    assert_same(cached_node_facts(library, WINDOW), node_facts(library, WINDOW))
