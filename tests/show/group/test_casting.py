"""Tests of casting: selection expressions, regrouping and group masks."""

import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.element_kinds import EVERYBODY
from live.base.errors import PersonError
from live.show.group.casting import Casting
from live.show.group.elements import BITS, GroupMasks
from live.show.patch.patch_reader import parse_patch

PATCH = """
name = "test"
reserve = 2
selections = { pair = "ember & 1-2", rest = "all - pair" }
[[group]]
name = "Ember"
dancers = 4
steps = ["sway"]
attributes = ["Tall"]
soloists = 1
[[group]]
name = "front row"
dancers = 3
steps = ["sway"]
"""
PLACES = np.array([(-3, 0), (3, 0), (0, 3), (0, -3), (-1, 1), (1, 1), (2, 2), (9, 9), (9, 9)], float)


@pytest.fixture
def casting():
    return Casting(parse_patch(PATCH, "test.toml"))


@pytest.mark.parametrize(
    ("words", "dancers"),
    [
        ("*", range(1, 10)),
        ("", range(1, 10)),
        ("ember", (1, 2, 3, 4, 8, 9)),
        ("EMBER", (1, 2, 3, 4, 8, 9)),
        ("front row", (5, 6, 7)),
        ("pair", (1, 2)),
        ("rest & tall", (3, 4)),
        ("soloist", (1,)),
        ("tall & left + 7", (1, 7)),
        ("2-5 - 3", (2, 4, 5)),
    ],
)
def test_selection_expression_selects_dancers(casting, words, dancers):
    assert (np.flatnonzero(casting.select(words, PLACES)) + 1).tolist() == list(dancers)


@pytest.mark.parametrize("words", ["nobody", "ember &", "99", "pair pair", "((1)"])
def test_invalid_selection_is_refused(casting, words):
    with pytest.raises(PersonError):
        casting.select(words, PLACES)


def test_regrouping_changes_groups_and_selections(casting):
    who = np.zeros(9, np.bool_)
    who[[1, 4]] = True
    casting.regroup(who, 1)
    assert casting.group.tolist() == [0, 1, 0, 0, 1, 1, 1, 0, 0]
    assert (np.flatnonzero(casting.select("pair", PLACES)) + 1).tolist() == [1]


def test_each_selection_has_one_bit_and_follows_regrouping(casting):
    addressees = GroupMasks(casting)
    assert addressees.mask("*", PLACES, 0) == EVERYBODY
    ember, again = addressees.mask("ember", PLACES, 0), addressees.mask(" Ember ", PLACES, 0)
    assert ember == again == 1
    left = addressees.mask("left", PLACES, ember)
    assert left != ember
    bits = addressees.bits
    assert (np.flatnonzero(bits & np.uint64(left)) + 1).tolist() == [1, 5]
    who = np.zeros(9, np.bool_)
    who[0] = True
    casting.regroup(who, 1)
    addressees.update_groups(PLACES + 100.0)
    assert (np.flatnonzero(bits & np.uint64(ember)) + 1).tolist() == [2, 3, 4, 8, 9]
    assert (np.flatnonzero(bits & np.uint64(left)) + 1).tolist() == [1, 5]  # places were asked about once


def test_mask_bits_are_reused_and_limited(casting):
    addressees = GroupMasks(casting)
    used = 0
    for number in range(BITS):
        used |= addressees.mask(f"{number % 9 + 1} & left + {number // 9 + 1}", PLACES, used)
    assert used == EVERYBODY
    with pytest.raises(PersonError, match="64 groups"):
        addressees.mask("right", PLACES, used)
    assert addressees.mask("right", PLACES, used & ~4) == 4


@pytest.mark.long
@given(st.text(max_size=60))
def test_arbitrary_text_is_selected_or_refused(words):
    casting = Casting(parse_patch(PATCH, "test.toml"))
    with contextlib.suppress(PersonError):
        assert casting.select(words, PLACES).shape == (9,)
