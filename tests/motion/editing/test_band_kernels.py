"""Band matrices against numpy's dense solver."""

import numpy as np
import pytest

from live.motion.editing.band_kernels import factor_band, solve_band


@pytest.mark.parametrize(("count", "width"), [(1, 1), (5, 8), (30, 7), (61, 6)])
def test_solution_is_that_of_the_dense_matrix(count, width):
    chance = np.random.default_rng(count)
    half = np.triu(np.tril(chance.normal(size=(count, count))), -(width // 2))
    dense = half @ half.T + np.eye(count)
    band = np.zeros((count, width))
    for j in range(count):
        for d in range(min(width, count - j)):
            band[j, d] = dense[j + d, j]
    values = chance.normal(size=(3, count))
    solution = values.copy()
    factor_band(band)
    solve_band(band, solution)
    assert np.allclose(solution, np.linalg.solve(dense, values.T).T, atol=1e-9)
