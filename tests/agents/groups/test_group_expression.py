"""Group expressions: grammar, stage regions and partition (T104)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.agents.groups.group_expression import (
    MAX_DEPTH,
    MAX_LENGTH,
    BinaryOperation,
    NumberRange,
    Word,
    depends_on_positions,
    parse,
    partition,
    select_dancers,
)
from live.agents.groups.roster import PLACE_WORDS, Roster
from live.base.errors import PersonError

ROSTER = Roster.create(
    8, {1: ["soloist"], 2: ["tall"], 3: ["tall", "red"], 4: ["red"]}, chorus="all - soloist", near="front & chorus"
)
PLACES = np.array([[-5, 3], [-2, -1], [-1, 1], [0, 0], [1, -3], [2, 2], [3.2, -2], [5, 3.5]])


def numbers(expression, positions=PLACES):
    """The numbers of the selected dancers, from 1."""
    return [int(n) + 1 for n in np.flatnonzero(select_dancers(expression, ROSTER, positions))]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("", [1, 2, 3, 4, 5, 6, 7, 8]),
        ("everyone", [1, 2, 3, 4, 5, 6, 7, 8]),
        ("3", [3]),
        ("2-4", [2, 3, 4]),
        ("2 - 4", [2]),
        ("tall + 7", [2, 3, 7]),
        ("tall & red", [3]),
        ("tall - red", [2]),
        ("chorus", [2, 3, 4, 5, 6, 7, 8]),
        ("left", [1, 2, 3]),
        ("right", [4, 5, 6, 7, 8]),
        ("front", [1, 3, 4, 6, 8]),
        ("back", [2, 5, 7]),
        ("centre", [2, 3, 4, 6]),
        ("Left & Back", [2]),
        ("near", [3, 4, 6, 8]),
        ("1-3 - 2 + 5", [1, 3, 5]),
        ("tall + red & left", [2, 3]),
        ("(tall + red) & left", [2, 3]),
        ("(tall + red) & right", [4]),
    ],
)
def test_expression_selects_expected_dancers(expression, expected):
    assert numbers(expression) == expected


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        ("nobody", "no group and no dancer is called 'nobody'"),
        ("9", "there is no dancer 9"),
        ("4-2", "do not exist"),
        ("0", "do not exist"),
        ("tall +", "missing at the end"),
        ("(tall", "bracket"),
        ("tall red", "one too many"),
        ("& tall", "stands where"),
        ("tall ? red", "cannot be read from '\\? red'"),
        ("x" * (MAX_LENGTH + 1), "characters"),
        ("(" * (MAX_DEPTH + 1) + "1" + ")" * (MAX_DEPTH + 1), "brackets"),
        ("left", "are not known"),
    ],
)
def test_invalid_expression_is_refused_with_reason(expression, says):
    with pytest.raises(PersonError, match=says):
        select_dancers(expression, ROSTER, None)


def test_recursive_group_is_refused():
    roster = Roster.create(2, a="b + 1", b="a")
    with pytest.raises(PersonError, match="a → b → a"):
        select_dancers("a", roster)


@pytest.mark.parametrize("word", [*PLACE_WORDS, "all", "everyone"])
def test_group_name_overrides_reserved_word(word):
    roster = Roster.create(3, **{word: "2-3"})
    assert select_dancers(word, roster, np.zeros((3, 2))).tolist() == [False, True, True]


def test_position_dependence_is_found_through_group_names():
    assert depends_on_positions("1 + near", ROSTER)
    assert not depends_on_positions("chorus - 3", ROSTER)
    assert not depends_on_positions("", ROSTER)


def expressions():
    atoms = st.sampled_from(["1", "2-5", "tall", "red", "soloist", "left", "front", "centre", "chorus"])
    return st.recursive(
        atoms, lambda inner: st.builds("({} {} {})".format, inner, st.sampled_from("+-&"), inner), max_leaves=8
    )


def evaluate_sets(node, positions):
    """Independent evaluation with sets of numbers."""
    if isinstance(node, BinaryOperation):
        left, right = evaluate_sets(node.left, positions), evaluate_sets(node.right, positions)
        return {"+": left | right, "&": left & right, "-": left - right}[node.sign]
    if isinstance(node, NumberRange):
        return set(range(node.first, node.last + 1))
    assert isinstance(node, Word)
    return {
        "tall": {2, 3}, "red": {3, 4}, "soloist": {1}, "chorus": set(range(2, 9)), "left": {1, 2, 3},
        "front": {1, 3, 4, 6, 8}, "centre": {2, 3, 4, 6},
    }[node.word]  # fmt: skip


@given(expressions())
def test_expressions_match_set_operations(expression):
    assert set(numbers(expression)) == evaluate_sets(parse(expression), PLACES)


@pytest.mark.long
@given(st.text(max_size=60))
def test_any_text_is_selected_or_refused(text):
    try:
        mask = select_dancers(text, ROSTER, PLACES)
    except PersonError:
        return
    assert mask.shape == (8,)


@given(st.lists(expressions(), max_size=4), st.integers(0, 255))
def test_partition_includes_each_dancer_exactly_once(parts, bits):
    within = np.array([bits >> n & 1 for n in range(8)], bool)
    masks = partition(parts, ROSTER, PLACES, within=within)
    assert len(masks) == len(parts) + 1
    assert (np.sum(masks, axis=0) == within).all()
    again = [mask for part in masks for mask in partition(["left", "tall"], ROSTER, PLACES, within=part)]
    assert (np.sum(again, axis=0) == within).all()
