"""Tests of formations of a show: lookup by name, notation and live definition."""

import numpy as np
import pytest

from live.agents.formations.formation_spec import spec_from_table
from live.base.errors import PersonError
from live.show.group.formations import Formations
from live.show.patch.section_motion import GroupSection

WEDGE = spec_from_table({"name": "Wedge", "shape": "polyline", "points": [[-3, -2], [0, 2], [3, -2]]})


def group(**values):
    return GroupSection(
        name="a", steps=("sway",), **{"dancers": 7, "centre": (1.0, -1.0), "size": (6.0, 3.0), **values}
    )


def test_names_precede_notation_and_ignore_case():
    formations = Formations([WEDGE], seed=1)
    assert formations.find("wedge") is formations.find(" WEDGE ")
    assert formations.find("star") is formations.find("star")
    with pytest.raises(PersonError, match=r"blob.*formations of this show: Wedge"):
        formations.find("blob")


def test_places_match_dancer_count_and_are_cached():
    wedge = Formations([WEDGE], seed=1).find("wedge")
    for count in (0, 1, 5, 24):
        assert wedge.places_for(count).slots.shape == (count, 2)
    assert wedge.places_for(5) is wedge.places_for(5)


def test_live_definition_replaces_formation():
    formations = Formations([WEDGE], seed=1)
    before = formations.find("wedge").places_for(6).slots
    formations.define("WEDGE", "circle")
    assert np.abs(formations.find("wedge").places_for(6).slots - before).max() > 0.5
    with pytest.raises(PersonError):
        formations.define("x", "path:M 0 0 L 1 1")  # its reader takes a second to load: not while a show runs
    assert formations.find("path:M 0 0 L 4 0").places_for(3).slots.shape == (3, 2)


def test_starting_places_scale_notation_and_keep_named_formation():
    formations = Formations([WEDGE], seed=1)
    line = formations.starting_places(group(formation="line"))
    assert np.allclose(line[:, 1], -1.0)
    assert np.ptp(line[:, 0]) == pytest.approx(6.0)
    wedge = formations.starting_places(group(formation="wedge"))
    assert wedge[:, 1].max() == pytest.approx(2.0, abs=1e-6)


def test_dancers_without_place_stand_in_rows():
    small = spec_from_table({"name": "three", "shape": "circle", "count": 3})
    places = Formations([small], seed=1).starting_places(group(formation="three"))
    assert places.shape == (7, 2)
    assert np.isfinite(places).all()
