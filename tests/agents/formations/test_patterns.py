"""Patterns: even spacing, lattices, silhouettes, blue noise against theory, even spreading (T091, T144)."""

import math

import numpy as np
import pytest
import shapely
from scipy.spatial import cKDTree

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from tests.agents.formations.tables import HEART, RING


def build_formation(table, count, seed=1):
    return formation_of(spec_from_table(table), count, seed)


def nearest(places):
    return cKDTree(places).query(places, k=2)[0][:, 1]


def gaps_along(line, places):
    """Lengths along a line from each place to the next, by shapely."""
    drawn = shapely.LineString(line)
    at = np.sort(shapely.line_locate_point(drawn, shapely.points(places)))
    return np.append(np.diff(at), drawn.length - at[-1] + at[0])


@pytest.mark.parametrize("count", [5, 24, 61])
def test_ellipse_places_are_even_by_arc_length(count):
    """Against a fine sum over the ellipse itself."""
    places = build_formation({"shape": "ellipse", "size": [8, 3]}, count).slots
    fine = np.linspace(0.0, 2.0 * math.pi, 200_001)
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(np.stack([4 * np.sin(fine), 1.5 * np.cos(fine)]))))])
    angle = np.mod(np.arctan2(places[:, 0] / 4, places[:, 1] / 1.5), 2.0 * math.pi)
    at = np.interp(angle, fine, way)
    assert np.diff(np.append(at, way[-1])) == pytest.approx(np.full(count, way[-1] / count), rel=0.01)


@pytest.mark.parametrize("table", [{"shape": "spiral"}, {"shape": "arc", "arc_deg": 300}], ids=str)
def test_open_line_places_are_even_and_include_ends(table):
    formation = build_formation(table, 40)
    line = formation.lines[0]
    assert formation.slots[[0, -1]] == pytest.approx(line[[0, -1]])
    gaps = gaps_along(line, formation.slots)[:-1]
    assert gaps == pytest.approx(np.full(39, gaps.mean()), rel=1e-6)


def test_corners_are_occupied_and_sides_filled_evenly():
    triangle = build_formation({"shape": "polygon", "corners": 3}, 13)
    corners = triangle.lines[0][:3]
    assert cKDTree(triangle.slots).query(corners)[0].max() < 1e-9
    gaps = gaps_along(triangle.lines[0], triangle.slots)
    side = gaps.sum() / 3
    assert sorted({round(side / gap) for gap in gaps}) == [4, 5]
    plain = build_formation({"shape": "polygon", "corners": 3, "mark_corners": False}, 13)
    gaps = gaps_along(plain.lines[0], plain.slots)
    assert gaps == pytest.approx(np.full(13, gaps.mean()), rel=1e-6)


def test_dancers_are_divided_among_lines_by_length():
    drawing = {"shape": "polyline", "points": [[[0, 0], [6, 0]], [[0, 2], [3, 2]], [[0, 4], [1.5, 4]]]}
    places = build_formation(drawing, 24).slots
    assert [int((places[:, 1].round(6) == z).sum()) for z in np.unique(places[:, 1].round(6))] == [13, 7, 4]


def test_crossing_lines_never_share_a_place():
    for points in ([[[-3, 0], [3, 0]], [[0, -2], [0, 2]]], [[[-3, 0], [3, 0]], [[0, 0], [0, 3]]]):
        for count in range(4, 30):
            formation = build_formation({"shape": "polyline", "points": points}, count)
            length = sum(shapely.LineString(line).length for line in formation.lines)
            assert formation.min_distance > 0.4 * length / count, count


def test_weights_set_dancer_density_along_line():
    """Dancers are distributed by the weights: the mass to the left of a dancer is proportional to its index."""
    places = build_formation({"shape": "line", "size": [10, 1], "weights": [1, 3]}, 401).slots[:, 0]
    share = (places + 5) / 10
    mass = (share + share**2) / 2  # of the density 1 + 2 t, which is 2 in all
    assert mass == pytest.approx(np.arange(401) / 400, abs=2e-4)


def test_focus_increases_dancer_density_nearby():
    plain = build_formation({"shape": "circle", "dancers": "inside"}, 60).slots
    drawn = build_formation(
        {"shape": "circle", "dancers": "inside", "focus": [1, 1], "focus_reach": 0.8, "focus_strength": 8}, 60
    ).slots
    near = [int((np.hypot(*(places - 1.0).T) < 0.8).sum()) for places in (plain, drawn)]
    assert near[1] > 2 * near[0]


@pytest.mark.parametrize("count", [13, 40, 49, 50, 97, 200])
@pytest.mark.parametrize("pattern", ["grid", "diagonal"])
@pytest.mark.parametrize(
    "shape", [{"shape": "circle"}, {"shape": "rectangle"}, {"shape": "path", "path": HEART}], ids=str
)
def test_lattice_has_one_spacing_and_fixed_directions(shape, pattern, count):
    formation = build_formation({**shape, "pattern": pattern}, count)
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


def test_grid_fills_rectangle_by_rows_from_front():
    places = build_formation({"shape": "rectangle", "size": [8, 5], "pattern": "grid"}, 40).slots
    assert len(np.unique(places[:, 0].round(6))) == 8
    assert (np.diff(places[:, 1].reshape(5, 8)[:, 0]) < 0).all()
    assert (np.diff(places[:, 0].reshape(5, 8), axis=1) > 0).all()
    assert places.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_concentric_pattern_in_circle_forms_rings():
    places = build_formation({"shape": "circle", "size": [8, 8], "pattern": "concentric"}, 50).slots
    radius = np.hypot(*places.T)
    rings = np.unique(radius.round(1))
    assert 4.0 in rings
    assert 3 <= len(rings) <= 5
    apart = np.diff(rings)
    assert apart == pytest.approx(np.full(len(apart), apart.mean()), abs=0.12)
    assert nearest(places).min() > 0.7 * apart.mean()


@pytest.mark.parametrize("count", [20, 50, 200])
@pytest.mark.parametrize("shape", [{"shape": "circle"}, {"shape": "star"}, {"shape": "path", "path": RING}], ids=str)
def test_blue_noise_distance_is_within_theoretical_bounds(shape, count):
    """Relative radius (Lagae and Dutré 2006): at least 0.6 of the hexagonal spacing, which is the upper bound."""
    formation = build_formation({**shape, "pattern": "poisson"}, count)
    region = shapely.Polygon(formation.lines[0], holes=formation.lines[1:])
    hexagonal = math.sqrt(2 * region.area / (math.sqrt(3) * count))
    packed = math.sqrt(2 * region.buffer(hexagonal / 2).area / (math.sqrt(3) * count))
    assert 0.6 * hexagonal < formation.min_distance < packed
    random = np.random.default_rng(1).uniform(-3, 3, (4000, 2))
    random = random[shapely.contains_xy(region, random[:, 0], random[:, 1])][:count]
    assert nearest(formation.slots).std() / nearest(formation.slots).mean() < 0.25  # random places: about 0.5
    assert nearest(random).min() < 0.5 * formation.min_distance


def test_blue_noise_has_no_lattice_directions():
    """Directions to nearest neighbors, modulo 60°, are spread over all six bins."""
    places = build_formation({"shape": "rectangle", "pattern": "poisson"}, 150).slots
    other = places[cKDTree(places).query(places, k=2)[1][:, 1]]
    angle = np.mod(np.arctan2(*(other - places).T), math.pi / 3) / (math.pi / 3)
    assert np.histogram(angle, 6, (0, 1))[0].min() > 8


def _energy(region, places, chance):
    """Mean squared distance to the nearest place, relative to a hexagonal lattice of equal count."""
    ground = chance.uniform(region.bounds[:2], region.bounds[2:], (40_000, 2))
    ground = ground[shapely.contains_xy(region, ground[:, 0], ground[:, 1])]
    mean = (cKDTree(places).query(ground)[0] ** 2).mean()
    return mean / (5 * region.area / (18 * math.sqrt(3) * len(places)))


@pytest.mark.parametrize("shape", [{"shape": "circle"}, {"shape": "star"}, {"shape": "rectangle"}], ids=str)
def test_even_spreading_has_near_optimal_quantization_energy(shape):
    """Quantization energy: 1 is the hexagonal lattice without a border; blue noise has about 1.4."""
    chance = np.random.default_rng(3)
    formation = build_formation({**shape, "dancers": "inside"}, 50)
    region = shapely.Polygon(formation.lines[0])
    scattered = build_formation({**shape, "pattern": "poisson"}, 50)
    even, blue = (_energy(region, each.slots, chance) for each in (formation, scattered))
    assert even < 1.12
    assert even < 0.95 * blue
