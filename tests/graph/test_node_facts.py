"""What is measured of steps: the same each time; and what the tests remember of it is what would be measured."""

import numpy as np

from live.graph.node_features import Moments, NodeFacts, node_facts
from live.graph.step_library import build_library
from tests.fixtures.made_steps import made_clip, made_steps
from tests.fixtures.remembered import remembered

WINDOW = 0.1875


def assert_same(one: NodeFacts, other: NodeFacts) -> None:
    for name in NodeFacts.__slots__:
        if name != "moments":
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
    for name in Moments.__slots__:
        assert np.array_equal(getattr(one.moments, name), getattr(other.moments, name)), name


def test_the_same_steps_are_measured_alike_to_the_bit():
    assert_same(node_facts(build_library(made_steps()), WINDOW), node_facts(build_library(made_steps()), WINDOW))


def test_what_is_remembered_is_of_that_library_and_window_alone():
    libraries = [build_library(made_steps()), build_library([*made_steps(), made_clip("glide on", way=(0.1, 0.2))])]
    for _ in range(2):
        for library in libraries:
            for window in (WINDOW, 2.0 * WINDOW):
                assert_same(remembered(library, window), node_facts(library, window))


def test_who_changes_what_was_remembered_changes_it_for_nobody_else():
    library = build_library(made_steps())
    mine = remembered(library, WINDOW)
    mine.warp_curve[:] = 7.0
    assert_same(remembered(library, WINDOW), node_facts(library, WINDOW))
