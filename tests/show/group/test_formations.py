"""Formations of a show by name, said in words, defined live."""

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


def test_names_come_before_words_and_any_spelling_of_case_serves():
    formations = Formations([WEDGE], seed=1)
    assert formations.find("wedge") is formations.find(" WEDGE ")
    assert formations.find("star") is formations.find("star")
    with pytest.raises(PersonError, match=r"blob.*formations of this show: Wedge"):
        formations.find("blob")


def test_as_many_places_as_dancers_and_kept():
    wedge = Formations([WEDGE], seed=1).find("wedge")
    for count in (0, 1, 5, 24):
        assert wedge.places_for(count).slots.shape == (count, 2)
    assert wedge.places_for(5) is wedge.places_for(5)


def test_a_formation_defined_live_replaces_the_old_one():
    formations = Formations([WEDGE], seed=1)
    before = formations.find("wedge").places_for(6).slots
    formations.define("WEDGE", "circle")
    assert np.abs(formations.find("wedge").places_for(6).slots - before).max() > 0.5
    with pytest.raises(PersonError):
        formations.define("x", "path:M 0 0 L 1 1")  # its reader takes a second to load: not while a show runs
    assert formations.find("path:M 0 0 L 4 0").places_for(3).slots.shape == (3, 2)


def test_a_group_begins_in_words_of_its_size_or_in_a_named_formation_where_that_is():
    formations = Formations([WEDGE], seed=1)
    line = formations.starting_places(group(formation="line"))
    assert np.allclose(line[:, 1], -1.0)
    assert np.ptp(line[:, 0]) == pytest.approx(6.0)
    wedge = formations.starting_places(group(formation="wedge"))
    assert wedge[:, 1].max() == pytest.approx(2.0, abs=1e-6)


def test_whoever_finds_no_place_stands_in_rows():
    small = spec_from_table({"name": "three", "shape": "circle", "count": 3})
    places = Formations([small], seed=1).starting_places(group(formation="three"))
    assert places.shape == (7, 2)
    assert np.isfinite(places).all()
