"""Strongly connected components against SciPy's, numbers included: ties between components are decided by them."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from live.graph.build.components import strong_components


@pytest.mark.parametrize("density", [0.0, 0.005, 0.01, 0.02, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("count", [1, 2, 60, 200])
def test_components_and_their_numbers_are_those_of_scipy(count, density):
    draw = np.random.default_rng(int(1000 * density) + count)
    for _ in range(10):
        table = draw.random((count, count)) < density
        label = strong_components(count, *(each.astype(np.int32) for each in np.nonzero(table)))
        expected = connected_components(csr_array(table), directed=True, connection="strong")[1]
        assert label.tolist() == expected.tolist()


def test_long_way_needs_no_recursion():
    count = 5000
    source = np.arange(count, dtype=np.int32)
    assert not strong_components(count, source, np.roll(source, -1)).any()
    assert len(set(strong_components(count, source[:-1], source[1:]).tolist())) == count
