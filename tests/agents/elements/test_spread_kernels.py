"""Spreading (T109): fast, even, without grid patterns, per group; the mesh potential against scipy."""

import math

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


@pytest.mark.parametrize(("nx", "nz"), [(12, 7), (4, 3), (224, 160), (60, 4)])
def test_potential_solves_poisson_equation_with_reflecting_edges(nx, nz):
    dx, dz = 0.9, 1.1
    unit = 1 << kernels.level_count(nx, nz)
    nx, nz = -(-nx // unit) * unit, -(-nz // unit) * unit
    mesh = np.zeros((3, 2 * nx * nz), np.float32)
    source = np.random.default_rng(0).normal(size=(nz, nx))
    source -= source.mean()
    mesh[0, : nz * nx] = source.ravel()
    kernels.solve_poisson(mesh, nx, nz, dx, dz)
    along = (2.0 * np.sin(np.pi * np.arange(nx) / (2 * nx)) / dx) ** 2
    across = (2.0 * np.sin(np.pi * np.arange(nz) / (2 * nz)) / dz) ** 2
    laplace = np.add.outer(across, along)
    laplace[0, 0] = np.inf
    expected = idctn(dctn(source) / laplace)
    found = mesh[1, : nz * nx].reshape(nz, nx)
    assert np.std(found - found.mean() - expected) < 0.01 * np.std(expected)


@pytest.mark.parametrize("variances", [(1.0, 1.0), (0.7, 2.3), (0.0, 0.0)])
def test_blur_has_its_variances_and_keeps_the_sum(variances):
    field, other = np.zeros((2, 41, 51), np.float32)
    field[20, 25] = 1.0
    kernels.blur(field.reshape(-1), other.reshape(-1), 51, 41, *variances)
    assert field.sum() == pytest.approx(1.0, abs=1e-5)
    spread = [(field.sum(axis) * (np.arange(n) - n // 2) ** 2).sum() for axis, n in ((0, 51), (1, 41))]
    assert spread == pytest.approx(variances, abs=1e-3)


@pytest.mark.parametrize(("width", "depth"), [(12.0, 8.0), (245.0, 163.0), (200.0, 0.5), (0.5, 30.0), (1e-3, 1e-3)])
@pytest.mark.parametrize("members", [1, 48, 10_000])
def test_mesh_fits_its_room(width, depth, members):
    s = kernels.SMOOTHING * math.sqrt(width * depth / members)
    capacity = kernels.NODES_PER_DANCER * members + kernels.SPARE_NODES
    nx, nz = kernels.mesh_size(width, depth, s, capacity)
    unit = 1 << kernels.level_count(nx, nz)
    assert nx % unit == nz % unit == 0
    assert sum(nx * nz >> (2 * level) for level in range(kernels.level_count(nx, nz) + 1)) <= capacity
    if max(width, depth) < 2.0 * min(width, depth):
        assert max(width / nx, depth / nz) <= 1.0001 * s


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
        nodes = kernels.NODES_PER_DANCER * 20 + kernels.SPARE_NODES
        mesh, start = np.zeros((3, nodes), np.float32), np.zeros(nodes, np.int32)
        wish, order = np.zeros((20, 2)), np.zeros(20, np.int32)
        position = np.ascontiguousarray(places * np.array([sign, 1.0], np.float32))
        kernels.fill_spread_field(position, np.arange(20, dtype=np.int32), 20, area, mesh, start, order)
        kernels.spread(20, area, mesh, start, order, wish, 0, 20)
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
