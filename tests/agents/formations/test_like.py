"""Formations that are like another one."""

import math

import numpy as np
import pytest

from live.agents.formations.formation import formation_of
from live.agents.formations.formation_spec import spec_from_table
from live.agents.formations.like import specs_from_tables
from live.agents.material.room import LEAST_GAP, room_of
from live.base.errors import PersonError

HALL = [[-5, -3.5], [5, -3.5], [5, -0.5], [-1, -0.5], [-1, 3.5], [-5, 3.5]]


def made(*tables, count=20, ahead=()):
    """The formation of the last table."""
    return formation_of(specs_from_tables(tables, ahead)[-1], count, 1)


def test_it_has_the_places_of_the_other_one_in_any_order_of_the_file():
    first, second = specs_from_tables([{"name": "b", "like": "A"}, {"name": "a", "shape": "star", "sections": [5, 15]}])
    one, other = formation_of(first, 20), formation_of(second, 20)
    assert one.slots == pytest.approx(other.slots)
    assert one.section.tolist() == other.section.tolist()
    assert one.name == "b"


def test_an_edit_of_the_other_one_changes_it():
    tables = [{"name": "a", "shape": "star"}, {"name": "b", "like": "a", "scale": 2}]
    assert specs_from_tables(tables)[1] == specs_from_tables(tables)[1]
    assert specs_from_tables(tables)[1] != specs_from_tables([{"name": "a", "shape": "line"}, tables[1]])[1]


@pytest.mark.long
def test_words_a_line_and_a_region_by_name():
    bow = {"name": "bow", "shape": "arc", "size": [8, 3]}
    along = made(bow, {"name": "x", "like": "rectangle grid", "along": "bow", "heading": "along"}, count=12)
    assert np.ptp(along.slots, axis=0)[0] < 11.0
    hall = {"name": "hall", "shape": "polygon", "points": HALL}
    squeezed = made({"name": "x", "like": "circle poisson", "into": "hall"}, hall, {"name": "y", "like": "x"}, count=20)
    assert room_of((tuple(map(tuple, HALL)),)).contains(squeezed.slots, 2e-3).all()
    assert squeezed.min_distance > LEAST_GAP


def test_headings_turn_with_the_group_unless_all_face_the_public():
    out = {"name": "out", "shape": "circle", "heading": "outwards"}
    turned = made(out, {"name": "x", "like": "out", "rotation_deg": 90}, count=8)
    away = turned.slots - turned.slots.mean(axis=0)
    assert np.cos(turned.heading - np.arctan2(away[:, 0], away[:, 1])) == pytest.approx(np.ones(8))
    mirrored = made(out, {"name": "x", "like": "out", "mirror": 30}, count=8)
    away = mirrored.slots - mirrored.slots.mean(axis=0)
    assert np.cos(mirrored.heading - np.arctan2(away[:, 0], away[:, 1])) == pytest.approx(np.ones(8))
    assert not made({"name": "x", "like": "circle", "rotation_deg": 90}).heading.any()
    inwards = made({"name": "x", "like": "circle", "scale": 2, "heading": "centre"}, count=4)
    assert math.cos(inwards.heading[0] - math.atan2(*-inwards.slots[0])) == pytest.approx(1.0)


def test_more_dancers_than_have_room_wait():
    small = made({"name": "x", "like": "circle poisson", "into": [[0, 0], [2, 0], [2, 2], [0, 2]]}, count=15)
    assert len(small.slots) + small.unplaced_dancers == 15
    assert small.min_distance > LEAST_GAP
    assert f"room for {len(small.slots)} dancers; {15 - len(small.slots)} have no place" in small.warnings[0]


def test_other_numbers_of_dancers_follow_those_computed_ahead():
    tables = [{"name": "a", "shape": "circle", "pattern": "poisson"}, {"name": "x", "like": "a", "into": HALL}]
    exact, near = made(*tables, count=20), made(*tables, count=20, ahead=(20,))
    assert np.array_equal(exact.slots, near.slots)
    for count in (1, 2, 17, 23):
        other = made(*tables, count=count, ahead=(20,))
        assert len(other.slots) == count
        assert room_of((tuple(map(tuple, HALL)),)).contains(other.slots, 2e-3).all()
        assert count == 1 or other.min_distance > LEAST_GAP


@pytest.mark.parametrize(("tables", "words"), [
    ([{"name": "x", "like": "y"}, {"name": "y", "like": "x"}], "leads back to itself"),
    ([{"name": "x", "like": "x"}], "leads back to itself"),
    ([{"name": "x", "like": "nix"}], "like: unknown formation 'nix'"),
    ([{"name": "x", "like": "star", "shape": "line"}], "like and shape: leave one out"),
    ([{"name": "x", "scale": 2}], "transforms another formation"),
    ([{"name": "x", "like": "star", "scale": 0}], "0.01 to 100"),
    ([{"name": "x", "like": "star", "scale": 2, "size": [2, 2]}], "leave one out"),
    ([{"name": "x", "like": "star", "along": [[0, 0], [1, 1]], "into": HALL}], "leave one out"),
    ([{"name": "x", "like": "star", "along": "text:AB"}], "not one line"),
    ([{"name": "x", "like": "star", "into": "grid"}], "no closed line"),
    ([{"name": "x", "like": "star", "into": [[0, 0], [2, 2], [2, 0], [0, 2]]}], "crosses or touches itself"),
    ([{"name": "x", "like": "star", "into": [[0, "a"], [2, 2], [2, 0]]}], "two numbers"),
    ([{"name": "x", "like": "star", "neighbours": "some"}], "keep, any"),
    ([{"name": "x", "like": "star", "counts_ahead": [3]}], "unknown key"),
], ids=str)  # fmt: skip
def test_what_cannot_be_is_refused_with_formation_and_key(tables, words):
    with pytest.raises(PersonError, match=words):
        formation_of(specs_from_tables(tables)[0], 12)


def test_alone_it_says_that_there_is_no_other_one():
    with pytest.raises(PersonError, match="like: names another formation"):
        formation_of(spec_from_table({"name": "x", "like": "wave"}), 12)
