"""Escape margins against plain arrays."""

import numpy as np

from live.agents.separation.collision_prediction_kernels import escape_margins


def test_escape_margin_is_worst_plus_mean_shortfall():
    chance = np.random.default_rng(4)
    ways, others = chance.normal(size=(8, 30, 2)), chance.normal(size=(5, 8, 3))
    others[..., 2] = np.abs(others[..., 2])
    out = np.empty(30)
    escape_margins(out, ways, others, 0.15)
    away = np.linalg.norm(ways[None] - others[:, :, None, :2], axis=-1) - others[:, :, None, 2]
    lack = np.maximum(0.15 - away, 0.0).max(axis=0)
    np.testing.assert_allclose(out, lack.max(axis=0) + lack.mean(axis=0), atol=1e-12)
    assert len(np.unique(out)) > 20


def test_escape_margin_without_neighbors_is_zero():
    out = np.ones(3)
    escape_margins(out, np.zeros((8, 3, 2)), np.zeros((0, 8, 3)), 0.15)
    assert (out == 0.0).all()
