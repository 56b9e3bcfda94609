"""Formation specs: invalid fields are refused by name; tables and expressions round-trip to the same spec."""

import math
import tomllib

import numpy as np
import pytest

from live.agents.formations.formation import check_formation, formation_of
from live.agents.formations.formation_notation import parse_formation
from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.base.errors import PersonError

NAN, FAR = math.nan, 1e30

REFUSED = [
    ({"shape": "heptagon"}, "shape"),
    ({"shape": ["star"]}, "shape"),
    ({"colour": 1}, "unknown key 'colour'"),
    ({"shape": "circle", "size": [NAN, 3]}, "size"),
    ({"shape": "circle", "size": [0, 3]}, "size"),
    ({"shape": "circle", "size": [1e9, 3]}, "size"),
    ({"shape": "circle", "size": 3}, "size"),
    ({"shape": "circle", "size": [[3, 3]]}, "size"),
    ({"shape": "circle", "centre": [math.inf, 0]}, "centre"),
    ({"shape": "circle", "rotation_deg": "ten"}, "rotation_deg"),
    ({"shape": "circle", "rotation_deg": NAN}, "rotation_deg"),
    ({"shape": "circle", "count": -1}, "count"),
    ({"shape": "circle", "count": 3.5}, "count"),
    ({"shape": "circle", "count": True}, "count"),
    ({"shape": "circle", "count": 10, "spacing": 1.0}, "only one of"),
    ({"shape": "circle", "density": 1.0}, "density"),
    ({"shape": "circle", "pattern": "poisson", "density": 90.0, "size": [100, 100]}, "density"),
    ({"shape": "star", "corners": 1}, "corners"),
    ({"shape": "star", "inner": 0.0}, "inner"),
    ({"shape": "text"}, "text"),
    ({"shape": "text", "text": "LIVE?"}, "'?' is not in the font"),
    ({"shape": "text", "text": "A" * 41}, "text"),
    ({"shape": "text", "text": "I", "dancers": "inside"}, "dancers"),
    ({"shape": "line", "dancers": "inside"}, "dancers"),
    ({"shape": "line", "pattern": "grid"}, "dancers"),
    ({"shape": "circle", "pattern": "grid", "dancers": "on"}, "pattern"),
    ({"shape": "circle", "pattern": "weighted"}, "pattern"),
    ({"shape": "circle", "pattern": "grid", "focus": [0, 0]}, "pattern"),
    ({"shape": "circle", "dancers": "inside", "weights": [1, 2]}, "weights"),
    ({"shape": "line", "weights": [0, 0]}, "weights"),
    ({"shape": "line", "weights": [1, NAN]}, "weights"),
    ({"shape": "line", "sections": [-1, 3]}, "sections"),
    ({"shape": "line", "sections": [2, 3], "section_names": ["a"]}, "section_names"),
    ({"shape": "path"}, "path"),
    ({"shape": "path", "path": "no path"}, "path"),
    ({"shape": "path", "path": "M 0 0"}, "path"),
    ({"shape": "path", "path": "M 0 0 L 0 0"}, "path"),
    ({"shape": "path", "path": "M 0 0 L 1e400 0"}, "path"),
    ({"shape": "path", "path": "M 0 0 A 1"}, "path"),
    ({"shape": "path", "path": "M 0 0 L 5 5 L 5 0 L 0 5 Z", "dancers": "inside"}, "crosses or touches itself"),
    ({"shape": "path", "path": "M 0 0 L 5 0 L 0 0 Z", "dancers": "inside"}, "path"),
    ({"shape": "polyline"}, "points"),
    ({"shape": "polyline", "points": [[0, 0]]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [0, 0]]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [0.001, 0]]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [NAN, 1]]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [FAR, 1]]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [1, 2, 3]]}, "points"),
    ({"shape": "polyline", "points": "draw"}, "points"),
    ({"shape": "polyline", "points": [0, 1]}, "points"),
    ({"shape": "polyline", "points": [[0, 0], [2, 2], [2, 0], [0, 2]], "dancers": "inside"}, "crosses or touches"),
    ({"shape": "polygon", "points": [[0, 0], [0.01, 0], [0, 0.01]], "pattern": "grid"}, "points"),
    ({"shape": "polygon", "points": [[[0, 0], [1, 0], [0, 1]], [[0, 0], [1, 0], [0, 1]]]}, "points"),
    ({"points": [[0, 0], [1, 0]]}, "if none is written"),
    ({"shape": "circle", "mirror": "up-down"}, "mirror"),
    ({"shape": "circle", "mirror": [[0, 0], [0, 0]]}, "mirror"),
    ({"shape": "circle", "mirror": 400}, "a direction from -360 to 360 degrees"),
    ({"shape": "circle", "mirror": [[0, 0], [0, 1]], "mirror_at": [0, 0]}, "mirror_at"),
    ({"shape": "circle", "mirror_at": [0, 0]}, "mirror_at"),
    ({"shape": "circle", "mirror": 10, "mirror_at": [0, 2000]}, "mirror_at"),
    ({"shape": "circle", "mirror": [[40, 0], [40, 1]], "mirror_keep": "right"}, "nothing lies on the side"),
    ({"shape": "circle", "mirror": "left-right", "mirror_keep": "front"}, "mirror_keep"),
    ({"shape": "grid", "mirror": "left-right"}, "mirror"),
    ({"shape": "grid", "pattern": "poisson"}, "pattern"),
    ({"shape": "circle", "soloists": 1, "soloist_place": "centre", "soloist_gap": 9}, "soloist_gap"),
    ({"shape": "circle", "soloists": 1000}, "soloists"),
    ({"shape": "circle", "heading": "north"}, "heading"),
    ({"shape": "circle", "name": 7}, "name"),
    ({"shape": "circle", "mark_corners": "yes"}, "mark_corners"),
    ({"shape": "polyline", "points": [[0, 0], [1, 1]], "closed": "no"}, "closed"),
]


@pytest.mark.parametrize(("table", "words"), REFUSED, ids=str)
def test_invalid_spec_is_refused_by_field_name(table, words):
    with pytest.raises(PersonError) as refused:
        check_formation(spec_from_table(table))
    assert words in str(refused.value)
    assert "\n" not in refused.value.message
    assert len(refused.value.message) < 500


def test_error_message_names_the_formation():
    with pytest.raises(PersonError, match="formation 'gate': size"):
        FormationSpec(name="gate", size=(math.nan, 1.0))
    with pytest.raises(PersonError, match=r"show.toml: a table expected"):
        spec_from_table([1], "show.toml")


def test_toml_table_parses_to_spec():
    text = 'shape = "polyline"\npoints = [[-3, 0], [0, -2], [3, 0]]\nsections = [2, 3]\nmirror = [[0, -4], [0, 4]]\n'
    spec = spec_from_table(tomllib.loads(text))
    assert spec.points == (((-3, 0), (0, -2), (3, 0)),)
    assert spec.mirror == ((0, -4), (0, 4))


@pytest.mark.parametrize(
    ("words", "shape", "inside", "pattern"),
    [
        ("circle", "circle", False, "even"),
        ("  star poisson ", "star", True, "poisson"),
        ("circle inside", "circle", True, "even"),
        ("grid", "grid", False, "even"),
        ("star:7", "star", False, "even"),
        ("triangle concentric", "polygon", True, "concentric"),
        ("text:LIVE ON", "text", False, "even"),
        ("path:M 0 0 L 3 3", "path", False, "even"),
    ],
)
def test_formation_expression_parses_to_spec(words, shape, inside, pattern):
    spec = parse_formation(words)
    assert (spec.shape, spec.inside, spec.distribution) == (shape, inside, pattern)
    assert len(formation_of(spec, 10).slots) == 10


def test_formation_expression_sets_shape_parameters():
    assert parse_formation("star:7").corners == 7
    assert parse_formation("hexagon").corners == 6
    assert parse_formation("spiral:1.5").turns == 1.5
    assert parse_formation("text:LIVE ON").text == "LIVE ON"


@pytest.mark.parametrize(
    "words", ["", "  ", "blob", "circle blue", "circle:5", "star:many", "star:2", "text:", "path:x"]
)
def test_invalid_formation_expression_is_refused(words):
    with pytest.raises(PersonError):
        check_formation(parse_formation(words))


def test_places_stand_where_they_are_written():
    table = {"shape": "places", "points": [[-1, 0.5], [1, 0], [0, 2]], "headings_deg": [90, 0, -90], "centre": [1, 0]}
    formation = formation_of(spec_from_table(table), 3)
    assert formation.slots.tolist() == [[0, 0.5], [2, 0], [1, 2]]
    assert np.degrees(formation.heading) == pytest.approx([90, 0, -90])
    fewer, more = (formation_of(spec_from_table(table), count) for count in (2, 5))
    assert len(fewer.slots) == 2
    assert fewer.empty_places == 0
    assert more.unplaced_dancers == 2
    assert "2 dancers have no place" in more.warnings[0]
    turned = formation_of(spec_from_table({**table, "centre": [0, 0], "rotation_deg": 90}), 3)
    assert np.degrees(turned.heading) == pytest.approx([-180, 90, 0])
    assert formation_of(spec_from_table({"shape": "places", "points": [[2, 1]]}), 1).slots.tolist() == [[2, 1]]


@pytest.mark.parametrize(
    ("more", "field"),
    [
        ({"points": []}, "points"),
        ({"points": [[[0, 0], [1, 1]], [[2, 2], [3, 3]]]}, "points"),
        ({"points": [[0, NAN]]}, "points"),
        ({"headings_deg": [1]}, "headings_deg"),
        ({"headings_deg": [1, NAN]}, "headings_deg"),
        ({"count": 3}, "count"),
        ({"mirror": "left-right"}, "mirror"),
        ({"heading": "along"}, "heading"),
        ({"shape": "polyline", "headings_deg": [0, 0]}, "headings_deg"),
    ],
)
def test_places_that_cannot_stand_are_refused_by_name(more, field):
    with pytest.raises(PersonError, match=f"formation: {field}"):
        spec_from_table({"shape": "places", "points": [[0, 0], [1, 1]], **more})
