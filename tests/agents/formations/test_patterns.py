"""Patterns: even ways along lines, lattices, silhouettes, blue noise against theory, even spreading (T091, T144)."""

import math

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from tests.agents.formations.tables import HEART, RING


def made(table, count, seed=1):
    return formation_of(spec_from_table(table), count, seed)


def nearest(places):
    return cKDTree(places).query(places, k=2)[0][:, 1]


def ways_between(line, places):
    """Lengths along a line from each place to the next, by shapely."""
    drawn = shapely.LineString(line)
    at = np.sort(shapely.line_locate_point(drawn, shapely.points(places)))
    return np.append(np.diff(at), drawn.length - at[-1] + at[0])


@pytest.mark.parametrize("count", [5, 24, 61])
def test_an_ellipse_is_even_along_its_way_not_by_angle(count):
    """Against a fine sum over the ellipse itself."""
    places = made({"shape": "ellipse", "size": [8, 3]}, count).slots
    fine = np.linspace(0.0, 2.0 * math.pi, 200_001)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.stack([4 * np.sin(fine), 1.5 * np.cos(fine)]))))])
    angle = np.mod(np.arctan2(places[:, 0] / 4, places[:, 1] / 1.5), 2.0 * math.pi)
    at = np.interp(angle, fine, way)
    assert np.diff(np.append(at, way[-1])) == pytest.approx(np.full(count, way[-1] / count), rel=0.01)


@pytest.mark.parametrize("table", [{"shape": "spiral"}, {"shape": "arc", "arc_deg": 300}], ids=str)
def test_open_lines_are_even_and_their_ends_are_taken(table):
    formation = made(table, 40)
    line = formation.lines[0]
    assert formation.slots[[0, -1]] == pytest.approx(line[[0, -1]])
    gaps = ways_between(line, formation.slots)[:-1]
    assert gaps == pytest.approx(np.full(39, gaps.mean()), rel=1e-6)


def test_corners_are_taken_first_and_sides_filled_evenly():
    triangle = made({"shape": "polygon", "corners": 3}, 13)
    corners = triangle.lines[0][:3]
    assert cKDTree(triangle.slots).query(corners)[0].max() < 1e-9
    gaps = ways_between(triangle.lines[0], triangle.slots)
    side = gaps.sum() / 3
    assert sorted({round(side / gap) for gap in gaps}) == [4, 5]
    plain = made({"shape": "polygon", "corners": 3, "mark_corners": False}, 13)
    gaps = ways_between(plain.lines[0], plain.slots)
    assert gaps == pytest.approx(np.full(13, gaps.mean()), rel=1e-6)


def test_lines_of_a_drawing_share_the_dancers_by_length():
    drawing = {"shape": "polyline", "points": [[[0, 0], [6, 0]], [[0, 2], [3, 2]], [[0, 4], [1.5, 4]]]}
    places = made(drawing, 24).slots
    assert [int((places[:, 1].round(6) == z).sum()) for z in np.unique(places[:, 1].round(6))] == [13, 7, 4]


def test_lines_that_cross_or_meet_never_share_a_place():
    for points in ([[[-3, 0], [3, 0]], [[0, -2], [0, 2]]], [[[-3, 0], [3, 0]], [[0, 0], [0, 3]]]):
        for count in range(4, 30):
            formation = made({"shape": "polyline", "points": points}, count)
            length = sum(shapely.LineString(line).length for line in formation.lines)
            assert formation.min_distance > 0.4 * length / count, count


def test_weights_put_dancers_where_they_weigh():
    """Shares of dancers are those of the weights: the mass left of a dancer is her number."""
    places = made({"shape": "line", "size": [10, 1], "weights": [1, 3]}, 401).slots[:, 0]
    share = (places + 5) / 10
    mass = (share + share**2) / 2  # of the density 1 + 2 t, which is 2 in all
    assert mass == pytest.approx(np.arange(401) / 400, abs=2e-4)


def test_a_focus_draws_dancers_near():
    plain = made({"shape": "circle", "dancers": "inside"}, 60).slots
    drawn = made(
        {"shape": "circle", "dancers": "inside", "focus": [1, 1], "focus_reach": 0.8, "focus_strength": 8}, 60
    ).slots
    near = [int((np.hypot(*(places - 1.0).T) < 0.8).sum()) for places in (plain, drawn)]
    assert near[1] > 2 * near[0]


@pytest.mark.parametrize("count", [13, 40, 49, 50, 97, 200])
@pytest.mark.parametrize("pattern", ["grid", "diagonal"])
@pytest.mark.parametrize(
    "shape", [{"shape": "circle"}, {"shape": "rectangle"}, {"shape": "path", "path": HEART}], ids=str
)
def test_a_lattice_has_one_spacing_and_its_directions(shape, pattern, count):
    formation = made({**shape, "pattern": pattern}, count)
    assert (
        nearest(formation.slots).max() < 1.5 * formation.min_distance
    )  # a corner may have none but diagonal neighbours
    steps = formation.slots - formation.slots[0]
    if pattern == "diagonal":
        steps = steps @ np.array([[1, 1], [1, -1]]) * math.sqrt(0.5)
    cells = steps / formation.min_distance
    assert np.abs(cells - cells.round()).max() < 1e-3
    region = shapely.Polygon(formation.lines[0])
    assert formation.min_distance > 0.8 * math.sqrt(region.area / count)


def test_a_grid_fills_the_rectangle_row_by_row_from_the_front():
    places = made({"shape": "rectangle", "size": [8, 5], "pattern": "grid"}, 40).slots
    assert len(np.unique(places[:, 0].round(6))) == 8
    assert (np.diff(places[:, 1].reshape(5, 8)[:, 0]) < 0).all()
    assert (np.diff(places[:, 0].reshape(5, 8), axis=1) > 0).all()
    assert places.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_silhouettes_are_circles_within_a_circle():
    places = made({"shape": "circle", "size": [8, 8], "pattern": "concentric"}, 50).slots
    radius = np.hypot(*places.T)
    rings = np.unique(radius.round(1))
    assert 4.0 in rings
    assert 3 <= len(rings) <= 5
    apart = np.diff(rings)
    assert apart == pytest.approx(np.full(len(apart), apart.mean()), abs=0.12)
    assert nearest(places).min() > 0.7 * apart.mean()


@pytest.mark.parametrize("count", [20, 50, 200])
@pytest.mark.parametrize("shape", [{"shape": "circle"}, {"shape": "star"}, {"shape": "path", "path": RING}], ids=str)
def test_blue_noise_keeps_the_distance_that_theory_allows(shape, count):
    """Relative radius (Lagae and Dutré 2006): at least 0.6 of the hexagonal spacing, which nothing can exceed."""
    formation = made({**shape, "pattern": "poisson"}, count)
    region = shapely.Polygon(formation.lines[0], holes=formation.lines[1:])
    hexagonal = math.sqrt(2 * region.area / (math.sqrt(3) * count))
    packed = math.sqrt(2 * region.buffer(hexagonal / 2).area / (math.sqrt(3) * count))
    assert 0.6 * hexagonal < formation.min_distance < packed
    random = np.random.default_rng(1).uniform(-3, 3, (4000, 2))
    random = random[shapely.contains_xy(region, random[:, 0], random[:, 1])][:count]
    assert nearest(formation.slots).std() / nearest(formation.slots).mean() < 0.25  # random places: about 0.5
    assert nearest(random).min() < 0.5 * formation.min_distance


def test_blue_noise_is_no_lattice():
    """Directions to nearest neighbours are spread over all sixths of a sixth of the circle."""
    places = made({"shape": "rectangle", "pattern": "poisson"}, 150).slots
    other = places[cKDTree(places).query(places, k=2)[1][:, 1]]
    angle = np.mod(np.arctan2(*(other - places).T), math.pi / 3) / (math.pi / 3)
    assert np.histogram(angle, 6, (0, 1))[0].min() > 8


def _energy(region, places, chance):
    """Mean squared distance to the nearest place, over that of a hexagonal lattice of as many."""
    ground = chance.uniform(region.bounds[:2], region.bounds[2:], (40_000, 2))
    ground = ground[shapely.contains_xy(region, ground[:, 0], ground[:, 1])]
    mean = (cKDTree(places).query(ground)[0] ** 2).mean()
    return mean / (5 * region.area / (18 * math.sqrt(3) * len(places)))


@pytest.mark.parametrize("shape", [{"shape": "circle"}, {"shape": "star"}, {"shape": "rectangle"}], ids=str)
def test_even_spreading_is_near_the_best_there_is(shape):
    """Quantisation energy: 1 is the hexagonal lattice without a border; blue noise has about 1.4."""
    chance = np.random.default_rng(3)
    formation = made({**shape, "dancers": "inside"}, 50)
    region = shapely.Polygon(formation.lines[0])
    scattered = made({**shape, "pattern": "poisson"}, 50)
    even, blue = (_energy(region, each.slots, chance) for each in (formation, scattered))
    assert even < 1.12
    assert even < 0.95 * blue
