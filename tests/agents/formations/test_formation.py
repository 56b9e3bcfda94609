"""Formations: exact counts, places on or inside the shape, symmetry, determinism, soloists, sections, headings."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from live.agents.formations.formation import SOLOIST, check_formation, formation_of
from live.agents.formations.formation_spec import spec_from_table
from tests.agents.formations.tables import AREAS, EVERYTHING, LINES, PATTERNS

few = settings(max_examples=25, deadline=None)


def build_formation(table, count, seed=1):
    return formation_of(spec_from_table(table), count, seed)


def smallest_distance(places):
    distances = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    np.fill_diagonal(distances, np.inf)
    return distances.min() if len(places) > 1 else np.inf


@few
@given(table=st.sampled_from(EVERYTHING), count=st.integers(0, 200), seed=st.integers(0, 2**31 - 1))
def test_formation_has_one_finite_place_per_dancer(table, count, seed):
    formation = build_formation(table, count, seed)
    assert formation.slots.shape == (count, 2)
    assert np.isfinite(formation.slots).all()
    assert np.isfinite(formation.heading).all()
    assert (formation.unplaced_dancers, formation.empty_places) == (0, 0)
    assert len(formation.marks) == count
    assert formation.min_distance == pytest.approx(smallest_distance(formation.slots), rel=1e-9)
    assert formation.min_distance > 0


@few
@given(table=st.sampled_from(LINES), count=st.integers(1, 120))
def test_places_of_line_formations_lie_on_lines(table, count):
    formation = build_formation(table, count)
    drawn = shapely.MultiLineString([shapely.LineString(line) for line in formation.lines])
    assert shapely.distance(drawn, shapely.points(formation.slots)).max() < 1e-6


@few
@given(area=st.sampled_from(AREAS), pattern=st.sampled_from(PATTERNS), count=st.integers(1, 150))
def test_places_of_area_formations_lie_inside(area, pattern, count):
    formation = build_formation({**area, **pattern}, count)
    region = shapely.Polygon(formation.lines[0], holes=formation.lines[1:])
    assert shapely.distance(region, shapely.points(formation.slots)).max() < 1e-6


MIRRORS = [
    {"mirror": "left-right"},
    {"mirror": "front-back"},
    {"mirror": [[-2, -3], [2, 3]]},
    {"mirror": 30, "mirror_at": [1, -0.5]},
]
CENTRES = [[0, 0], [1.25, -0.5], [20, 30]]  # in the middle of the stage, beside it, wholly on one side of every line
MIRRORED = st.sampled_from([*LINES, *({**area, **pattern} for area in AREAS for pattern in PATTERNS)])


def axis_distance(points, table):
    """Distance of points (K, 2) from the symmetry line of a table [m], from its definition."""
    mirror, at = table["mirror"], np.array(table.get("mirror_at", (0.0, 0.0)), float)
    angle = {"left-right": 0.0, "front-back": 0.5 * math.pi}.get(mirror) if isinstance(mirror, str) else None
    if isinstance(mirror, list):
        at = np.array(mirror[0], float)
        angle = math.atan2(mirror[1][0] - mirror[0][0], mirror[1][1] - mirror[0][1])
    angle = math.radians(mirror) if angle is None else angle
    return (points - at) @ np.array([math.cos(angle), -math.sin(angle)])


@pytest.mark.long
@few
@given(
    table=MIRRORED,
    mirror=st.sampled_from(MIRRORS),
    centre=st.sampled_from(CENTRES),
    count=st.integers(0, 90),
    heading=st.sampled_from(["along", "outwards", "public"]),
    soloists=st.sampled_from([{}, {"soloists": 1}, {"soloists": 2, "soloist_place": "centre", "soloist_gap": 0.5}]),
)
def test_mirrored_formation_equals_its_reflection(table, mirror, centre, count, heading, soloists):
    """T092; places and headings, except the heading to the audience, which is the same for all dancers."""
    table = {**table, **mirror, **soloists, "centre": centre, "heading": heading}
    formation = build_formation(table, count)
    assert len(formation.slots) == count
    if count == 0:
        return
    line = formation.symmetry
    assert abs(line.signed_distance(formation.slots)) == pytest.approx(abs(axis_distance(formation.slots, table)))
    reflected = line.reflect(formation.slots)
    distance = np.hypot(*(reflected[:, None] - formation.slots[None]).transpose(2, 0, 1))
    partner = distance.argmin(axis=1)
    assert distance.min(axis=1).max() < 2e-4
    assert sorted(partner) == list(range(count))
    alone = partner == np.arange(count)  # who is their own partner stands exactly on the axis
    assert alone.any() or count % 2 == 0
    assert abs(axis_distance(formation.slots[alone], table)).max(initial=0.0) < 1e-12
    if heading == "along" and not table.get("pattern") and abs(line.signed_distance(formation.slots)).min() > 1e-3:
        way = np.stack([np.sin(formation.heading), np.cos(formation.heading)], axis=1)
        assert way[partner] == pytest.approx(line.reflect_directions(way), abs=1e-6)


def test_symmetry_line_leads_through_the_middle_of_the_stage_and_not_of_the_shape():
    beside = {"shape": "circle", "size": [2, 2], "centre": [3, 1]}
    slots = build_formation(
        {**beside, "mirror": "left-right"}, 8
    ).slots  # nothing stands on the left: the right is kept
    assert np.sort(np.sign(slots[:, 0])).tolist() == [-1.0] * 4 + [1.0] * 4
    assert np.hypot(abs(slots[:, 0]) - 3, slots[:, 1] - 1) == pytest.approx(np.ones(8), abs=1e-3)
    through = build_formation({**beside, "mirror": "left-right", "mirror_at": [3, 0]}, 8).slots
    assert np.hypot(*(through - (3, 1)).T) == pytest.approx(np.ones(8), abs=1e-3)
    points = build_formation({**beside, "mirror": [[3, -1], [3, 4]]}, 8).slots
    assert points.tobytes() == through.tobytes()


@pytest.mark.parametrize("keep", ["left", "right"])
def test_either_side_is_reflected(keep):
    """Two corners on the left and three on the right: the kept ones are there twice."""
    drawn = {"shape": "polyline", "points": [[[-4, 0], [-2, 0]], [[1, -2], [3, 2]]], "mirror": "left-right"}
    slots = build_formation({**drawn, "mirror_keep": keep}, 6).slots
    kept = shapely.LineString(drawn["points"][0 if keep == "left" else 1])
    own = np.stack([abs(slots[:, 0]) * (-1 if keep == "left" else 1), slots[:, 1]], axis=1)
    assert shapely.distance(kept, shapely.points(own)).max() < 1e-9


@pytest.mark.parametrize(
    ("soloists", "count", "across", "along"),
    [(1, 9, [0.0], [4.0]), (2, 10, [-0.5, 0.5], [4.0, 4.0]), (3, 9, [-1.0, 0.0, 1.0], [4.0] * 3), (3, 1, [0.0], [1.0])],
)
def test_soloists_stand_at_the_end_of_the_axis(soloists, count, across, along):
    """Around the axis x = 0, though the circle lies beside it; in front of the others by their gap."""
    circle = {"shape": "circle", "size": [4, 4], "centre": [3, 1], "mirror": "left-right", "soloist_gap": 1.0}
    slots = build_formation({**circle, "soloists": soloists}, count).slots[: len(across)]
    assert slots[:, 0].tolist() == across
    assert slots[:, 1] == pytest.approx(along, abs=1e-3)
    turned = {**circle, "centre": [1, 3], "mirror": "front-back", "soloists": 1}
    assert build_formation(turned, 9).slots[0] == pytest.approx([4.0, 0.0], abs=1e-3)


@pytest.mark.parametrize("table", EVERYTHING, ids=str)
def test_equal_arguments_give_bit_identical_places(table):
    spec = spec_from_table(table)
    first = formation_of(spec, 33, 7)
    formation_of(spec, 34, 8)
    again = formation_of(spec_from_table(dict(table)), 33, 7)
    assert first.slots.tobytes() == again.slots.tobytes()
    assert first.heading.tobytes() == again.heading.tobytes()


def test_seed_changes_blue_noise_but_not_grid():
    scattered = {"shape": "circle", "pattern": "poisson"}
    assert np.abs(build_formation(scattered, 30, 1).slots - build_formation(scattered, 30, 2).slots).max() > 0.1
    lattice = {"shape": "circle", "pattern": "grid"}
    assert (build_formation(lattice, 30, 1).slots == build_formation(lattice, 30, 2).slots).all()


@pytest.mark.parametrize("count", [1, 2, 7, 24, 50])
@pytest.mark.parametrize("shape", ["grid", "line", "circle"])
def test_grid_line_and_circle_keep_their_original_layout(shape, count):
    place = {"centre": (1.0, -0.5), "size": (8.0, 8.0)}
    slots = build_formation({"shape": shape, **place}, count).slots - (1.0, -0.5)
    if shape == "line":
        across = np.zeros(1) if count == 1 else np.linspace(-4.0, 4.0, count)
        assert slots == pytest.approx(np.stack([across, np.zeros(count)], 1), abs=2e-3)
    elif shape == "circle":  # the first dancer is nearest to the public
        angle = 2.0 * np.pi * np.arange(count) / count
        assert slots == pytest.approx(4.0 * np.stack([np.sin(angle), np.cos(angle)], 1), abs=2e-3)
    else:  # staggered rows over the whole depth, each row even
        rows = np.unique(slots[:, 1])
        assert len(rows) == min(max(1, round(np.sqrt(count))), count)
        assert len(rows) < 2 or (rows[0], rows[-1]) == pytest.approx((-4.0, 4.0))
        for row in rows:
            gaps = np.diff(np.sort(slots[slots[:, 1] == row, 0]))
            assert len(gaps) == 0 or np.ptp(gaps) < 1e-9


def test_count_density_and_spacing_set_number_of_places():
    circle = {"shape": "circle", "size": [6, 6]}
    few_places = build_formation({**circle, "count": 20}, 24)
    assert (len(few_places.slots), few_places.unplaced_dancers, few_places.empty_places) == (20, 4, 0)
    assert "4 dancers have no place" in few_places.warnings[0]
    many = build_formation({**circle, "count": 20}, 17)
    assert (many.unplaced_dancers, many.empty_places) == (0, 3)
    assert "3 places stay empty" in many.warnings[0]
    dense = build_formation({**circle, "pattern": "grid", "density": 2.0}, 5)
    assert len(dense.slots) == round(2.0 * math.pi * 9)
    spaced = build_formation({**circle, "spacing": 0.75}, 5)
    assert len(spaced.slots) == round(math.pi * 6 / 0.75)
    assert len(build_formation({"shape": "line", "size": [6, 1], "spacing": 1.0}, 0).slots) == 7


@pytest.mark.parametrize("pattern", [each for each in PATTERNS if each["pattern"] != "weighted"], ids=str)
def test_area_formation_keeps_spacing_approximately(pattern):
    formation = build_formation({"shape": "circle", "size": [9, 9], **pattern, "spacing": 1.0}, 0)
    assert 0.75 < formation.min_distance < 1.2


def test_soloist_stands_in_front_of_all_dancers():
    formation = build_formation({"shape": "arc", "soloists": 1, "soloist_gap": 2.0}, 13)
    assert formation.soloist.tolist() == [True] + [False] * 12
    assert formation.marks[0] == SOLOIST
    assert formation.slots[0] == pytest.approx([0.0, formation.slots[1:, 1].max() + 2.0])


@pytest.mark.parametrize("pattern", PATTERNS, ids=str)
@pytest.mark.parametrize("soloists", [1, 3])
def test_dancers_keep_gap_to_soloists_in_center(pattern, soloists):
    table = {"shape": "circle", **pattern, "soloists": soloists, "soloist_place": "centre", "soloist_gap": 1.0}
    formation = build_formation(table, 30)
    alone, others = formation.slots[:soloists], formation.slots[soloists:]
    assert len(others) == 30 - soloists
    assert alone.mean(axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert np.hypot(*(others[:, None] - alone[None]).transpose(2, 0, 1)).min() > 0.99
    assert soloists == 1 or smallest_distance(alone) == pytest.approx(1.0)


def test_sections_on_a_line_are_contiguous():
    formation = build_formation({"shape": "circle", "sections": [3, 5, 4], "section_names": ["a", "b", "c"]}, 12)
    assert formation.section.tolist() == [0] * 3 + [1] * 5 + [2] * 4
    assert formation.marks == ("a",) * 3 + ("b",) * 5 + ("c",) * 4
    gap = np.hypot(*np.diff(formation.slots, axis=0).T)
    assert gap == pytest.approx(np.full(11, gap[0]), rel=1e-3)


@pytest.mark.parametrize("pattern", ["grid", "poisson", "concentric"])
def test_sections_in_an_area_are_blocks_of_given_size(pattern):
    """The convex hulls of the sections overlap by less than 2% of their area."""
    formation = build_formation({"shape": "rectangle", "pattern": pattern, "sections": [10, 20, 10]}, 40)
    assert np.bincount(formation.section).tolist() == [10, 20, 10]
    hulls = [shapely.MultiPoint(formation.slots[formation.section == n]).convex_hull for n in range(3)]
    overlap = sum(hulls[a].intersection(hulls[b]).area for a, b in ((0, 1), (1, 2), (0, 2)))
    assert overlap < 0.02 * sum(hull.area for hull in hulls)


def test_sections_scale_to_other_dancer_counts():
    assert np.bincount(build_formation({"shape": "line", "sections": [1, 2, 1]}, 21).section).tolist() == [5, 11, 5]


def test_heading_modes_give_expected_angles():
    circle = {"shape": "circle", "size": [6, 6], "centre": [1, 1]}
    places = build_formation(circle, 8).slots - 1.0
    outwards = np.arctan2(places[:, 0], places[:, 1])
    assert build_formation(circle, 8).heading == pytest.approx(np.zeros(8))
    faced = {way: build_formation({**circle, "heading": way}, 8).heading for way in ("outwards", "centre", "along")}
    assert np.cos(faced["outwards"] - outwards) == pytest.approx(np.ones(8))
    assert np.cos(faced["centre"] - outwards) == pytest.approx(-np.ones(8))
    assert np.abs(np.cos(faced["along"] - outwards)).max() < 0.02
    angle = build_formation({**circle, "heading": "angle", "heading_deg": 270}, 8).heading
    assert angle == pytest.approx(np.full(8, -math.pi / 2))


def test_rotated_formation_has_rotated_places():
    straight = build_formation({"shape": "arc"}, 9).slots
    turned = build_formation({"shape": "arc", "rotation_deg": 90}, 9).slots
    assert turned == pytest.approx(np.stack([straight[:, 1], -straight[:, 0]], axis=1), abs=1e-9)  # (0, 1) → (1, 0)


def test_warning_names_scale_that_resolves_contact():
    crowded = build_formation({"shape": "circle", "size": [2, 2]}, 20)
    assert "bodies touch" in crowded.warnings[0]
    factor = float(crowded.warnings[0].split("make it ")[1].split()[0])
    assert build_formation({"shape": "circle", "size": [2 * factor, 2 * factor]}, 20).warnings == ()


def test_checked_spec_never_raises_for_any_count():
    for table in EVERYTHING:
        spec = spec_from_table(table)
        check_formation(spec)
        for count in (0, 1, 2, 3):
            assert len(formation_of(spec, count, 5).slots) == count
