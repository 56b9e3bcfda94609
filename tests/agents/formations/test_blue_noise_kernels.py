"""Formation kernels against plain numpy and shapely."""

import math

import numpy as np
import pytest
import shapely

from live.agents.formations.blue_noise_kernels import eliminate, lattice_points_in_polygon, lloyd_relax

NOBODY = np.zeros((0, 2))


def neighbor_weights(points, others, scale, reach, least):
    distance = np.maximum(np.hypot(*(points[:, None] - others[None]).transpose(2, 0, 1)) * scale, least)
    return np.where(distance < reach, (1 - np.minimum(distance / reach, 1)) ** 8, 0.0)


@pytest.mark.parametrize("mirrored", [False, True])
def test_elimination_removes_the_most_crowded_point_each_time(mirrored):
    """Independent version of Yuksel 2015: all weights are recomputed after every removal."""
    chance = np.random.default_rng(5)
    points = chance.uniform(0, 4, (40, 2))
    image = points * (-1, 1) if mirrored else NOBODY
    fixed = np.array([[2.0, 2.0]])
    scale = chance.uniform(0.8, 1.2, 40)
    reach, least = 1.3, 0.2
    pair = 0.5 * (scale[:, None] + scale[None])
    weights = neighbor_weights(points, points, pair, reach, least)
    np.fill_diagonal(weights, 0.0)
    if mirrored:
        weights += neighbor_weights(points, image, pair, reach, 0.0) * np.where(np.eye(40), 8, 1)
    base = 8 * neighbor_weights(points, fixed, scale[:, None], reach, 0.0)[:, 0]
    alive = np.ones(40, bool)
    while alive.sum() > 15:
        total = np.where(alive, base + np.where(alive[None], weights, 0.0).sum(axis=1), -1.0)
        alive[total.argmax()] = False
    out = np.zeros(40)
    eliminate(points, np.ascontiguousarray(image), fixed, scale, 15, reach, least, out)
    assert (out >= 0).tolist() == alive.tolist()


def test_lloyd_relaxation_moves_sites_to_cell_centroids():
    chance = np.random.default_rng(6)
    ground, density = chance.uniform(0, 1, (300, 2)), chance.uniform(0.5, 2, 300)
    sites = chance.uniform(0, 1, (7, 2))
    expected = sites.copy()
    for _ in range(3):
        near = np.hypot(*(ground[:, None] - expected[None]).transpose(2, 0, 1)).argmin(axis=1)
        for site in range(5):
            own = near == site
            expected[site] += 1.4 * (np.average(ground[own], axis=0, weights=density[own]) - expected[site])
    nearest = np.zeros(300, np.int64)
    lloyd_relax(ground, density, sites, 5, 3, 1.4, np.zeros((7, 3)), nearest)
    assert sites == pytest.approx(expected)
    assert (nearest == near).all()


def test_lloyd_relaxation_without_ground_changes_nothing():
    for ground, sites in ((NOBODY, np.ones((2, 2))), (np.ones((3, 2)), NOBODY.copy())):
        if len(sites) == 0:
            continue
        before = sites.copy()
        lloyd_relax(
            ground,
            np.ones(len(ground)),
            sites,
            len(sites),
            2,
            1.0,
            np.zeros((len(sites), 3)),
            np.zeros(len(ground), np.int64),
        )
        assert (sites == before).all()


@pytest.mark.parametrize("seed", range(12))
def test_lattice_points_in_polygon_match_shapely(seed):
    chance = np.random.default_rng(seed)
    angle = np.sort(chance.uniform(0, 2 * math.pi, 17))
    outer = np.stack([np.sin(angle), np.cos(angle)], axis=1) * chance.uniform(1.5, 4, 17)[:, None]
    region = shapely.Polygon(outer).difference(shapely.Point(0.2, 0.1).buffer(0.7))
    if region.geom_type != "Polygon":
        pytest.skip("the hole cut the shape in two")
    rings = [shapely.get_coordinates(ring) for ring in (region.exterior, *region.interiors)]
    edges = np.concatenate([np.concatenate([ring[:-1], ring[1:]], axis=1) for ring in rings])
    bounds = np.array([region.bounds[1], region.bounds[3]])
    step, drop, x0, z0 = chance.uniform(0.2, 0.6), chance.uniform(0.2, 0.6), 0.05, 0.13
    i, j = np.meshgrid(np.arange(-40, 41), np.arange(-40, 41))
    grid = np.stack([x0 + step * i, z0 + drop * j], axis=-1).reshape(-1, 2)
    expected = grid[shapely.intersects_xy(region, grid[:, 0], grid[:, 1])]
    out = np.zeros((2000, 2))
    found = lattice_points_in_polygon(edges, bounds, step, drop, x0, z0, np.zeros(len(edges)), out)
    assert found == len(expected)
    order = np.lexsort((expected[:, 0], -expected[:, 1]))
    assert out[:found] == pytest.approx(expected[order])
    short = np.zeros((3, 2))
    assert lattice_points_in_polygon(edges, bounds, step, drop, x0, z0, np.zeros(len(edges)), short) == found
    assert (short == out[:3]).all()


def test_lattice_points_on_border_are_included():
    corners = np.array([[-2.0, -1.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0]])
    edges = np.concatenate([corners[:-1], corners[1:]], axis=1)
    out = np.zeros((30, 2))
    assert lattice_points_in_polygon(edges, np.array([-1.0, 1.0]), 1.0, 1.0, 0.0, 0.0, np.zeros(4), out) == 15
