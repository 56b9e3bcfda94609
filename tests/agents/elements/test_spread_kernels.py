"""Spreading (T109): fast, even, without grid patterns, per group; the mesh potential against scipy."""

import numpy as np
import pytest
from scipy.fft import dctn, idctn

from live.agents.elements import spread_kernels as kernels
from live.agents.elements.element import Element
from live.base.element_kinds import SPREADER
from tests.agents.elements.made_stage import StageHarness


def variance_to_mean_ratio(position, columns, rows, inset=(0.0, 0.0)):
    half = (6.0 - inset[0], 4.0 - inset[1])
    edges = [np.linspace(-h, h, n + 1) for h, n in zip(half, (columns, rows), strict=True)]
    counts = np.histogram2d(position[:, 0], position[:, 1], edges)[0]
    return counts.var() / counts.mean()


def test_potential_solves_poisson_equation_with_reflecting_edges():
    nx, nz, dx, dz, s = 12, 7, 0.9, 1.1, 0.8
    mesh = np.zeros((3, kernels.MAX_MESH_NODES, kernels.MAX_MESH_NODES), np.float32)
    source = np.random.default_rng(0).normal(size=(nz, nx))
    source -= source.mean()
    mesh[0, :nz, :nx] = source
    cosines = np.zeros((2, kernels.MAX_MESH_NODES + 1, kernels.MAX_MESH_NODES, kernels.MAX_MESH_NODES), np.float32)
    kernels.fill_cosines(cosines)
    kernels.solve_poisson(mesh, nx, nz, cosines, dx, dz, s)
    wave = np.add.outer((np.pi * np.arange(nz) / (nz * dz)) ** 2, (np.pi * np.arange(nx) / (nx * dx)) ** 2)
    wave[0, 0] = 1.0
    expected = dctn(source) * np.exp(-0.5 * s * s * wave) / wave
    expected[0, 0] = 0.0
    assert mesh[0, :nz, :nx] == pytest.approx(idctn(expected), abs=1e-4)


@pytest.mark.parametrize("separation", [0.7, 1.5])
def test_clump_fills_stage_evenly_without_grid_pattern(separation):
    chance = np.random.default_rng(5)
    x, z = np.meshgrid(np.linspace(-5.6, -2.2, 6), np.linspace(-3.5, 3.5, 8))
    clump = np.stack([x.ravel(), z.ravel()], 1) + chance.uniform(-0.04, 0.04, (48, 2))
    stage = StageHarness(clump, Element(SPREADER, start_beat=-9.0, separation=separation))
    kept = stage.run(12.0)
    assert all(variance_to_mean_ratio(p, 3, 2) < 0.5 for p in kept[56:])  # from 7 s on
    late = kept[72:]
    assert np.mean([variance_to_mean_ratio(p, 3, 2) for p in late]) < 0.25
    assert np.mean([variance_to_mean_ratio(p, 5, 3, (1.0, 1.0)) for p in late]) < 0.5
    assert np.abs(kept).max(axis=(0, 1)) == pytest.approx([6.0, 4.0], abs=0.8)  # the edges are reached, not crossed
    assert np.hypot(*np.diff(late, axis=0).T).mean() / 0.125 > 0.1  # and the dancers keep moving


def test_mirrored_crowd_spreads_mirrored():
    chance = np.random.default_rng(7)
    places = chance.uniform([-6, -4], [6, 4], (20, 2)).astype(np.float32)
    area = np.array([-6.0, 6.0, -4.0, 4.0])
    wishes = []
    for sign in (1.0, -1.0):
        mesh = np.zeros((3, kernels.MAX_MESH_NODES, kernels.MAX_MESH_NODES), np.float32)
        cosines = np.zeros((2, kernels.MAX_MESH_NODES + 1, kernels.MAX_MESH_NODES, kernels.MAX_MESH_NODES), np.float32)
        kernels.fill_cosines(cosines)
        wish = np.zeros((20, 2))
        start, order = np.zeros(kernels.MAX_CELLS**2 + 1, np.int32), np.zeros(20, np.int32)
        position = np.ascontiguousarray(places * np.array([sign, 1.0], np.float32))
        kernels.spread(position, np.arange(20, dtype=np.int32), 20, area, mesh, cosines, start, order, wish)
        wishes.append(wish)
    assert wishes[1] == pytest.approx(wishes[0] * [-1.0, 1.0], abs=1e-3)


def test_two_groups_spread_independently():
    chance = np.random.default_rng(3)
    start = chance.uniform([-5, -3], [-1, 3], (32, 2))
    groups = np.array([1, 2] * 16)
    elements = [Element(SPREADER, start_beat=-9.0, groups=bit, separation=0.7) for bit in (1, 2)]
    end = StageHarness(start, *elements, groups=groups).run(10.0)[-1]
    for bit in (1, 2):
        assert variance_to_mean_ratio(end[groups == bit], 2, 2) <= 0.6


def test_single_dancer_moves_to_center():
    end = StageHarness([[-5.0, 3.0]], Element(SPREADER, start_beat=-9.0, strength=1.0)).run(8.0)[-40:, 0]
    assert np.hypot(*end.mean(0)) < 2.0
    assert np.isfinite(StageHarness(np.zeros((7, 2)), Element(SPREADER)).wish()).all()
