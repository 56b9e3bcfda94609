"""The division of groups over measures as a tree: parts by attribute, number and place, and where they join again."""

import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.show.score.division_tree import KINDS, DivisionTree, tree_lines
from tests.show.made_show import made_show

SCORE = """
[selections]
pair = "1-2"
[[sequence]]
group = "front & 1-4"
measure = 2
steps = ["spin x4"]
[[sequence]]
group = "pair"
measure = 3
steps = ["sway x2"]
[[segment]]
group = "1 + 6"
measure = 3
measures = 2
formation = "line"
"""


def observed(score, measures, *, does=None, reserve=0):
    show, tree = made_show(score, reserve=reserve), DivisionTree()
    tick = 0
    while show.span.number < measures:
        tick += 1
        for event in (does or {}).get(tick, ()):
            show.apply(event)
        show.tick(tick * TICK)
        tree.observe(show)
    return show, tree


@pytest.mark.long
def test_parts_stand_under_what_they_are_part_of():
    _, tree = observed(SCORE, 7)
    found = tree.trees(("front", "back"), 0, 6)
    trees = {kind: [branch.as_json() for branch in roots] for kind, roots in found.items()}
    front, back = trees["steps"]
    assert (front["words"], front["dancers"], front["from"], front["to"]) == ("front", [1, 2, 3, 4, 5], 1, 7)
    assert back["parts"] == []
    (part,) = front["parts"]
    assert (part["words"], part["dancers"], part["from"], part["to"]) == ("front & 1-4", [1, 2, 3, 4], 2, 5)
    (pair,) = part["parts"]
    assert (pair["words"], pair["dancers"], pair["from"], pair["to"]) == ("pair", [1, 2], 3, 4)
    motion = trees["motion"]
    assert [[(part["dancers"], part["from"], part["to"]) for part in root["parts"]] for root in motion] == [
        [([1], 3, 4)], [([6], 3, 4)],
    ]  # fmt: skip
    assert set(trees) == set(KINDS)


def larger(time, value, group):
    return events.SetParameter(time=time, source="osc", address="/dance/motion/larger", value=(value,), group=group)


@pytest.mark.long
def test_values_and_regrouped_dancers_divide_the_rows():
    does = {
        64 * 3: [larger(3.0, 0.3, "3-5")],
        64 * 5: [events.Regroup(time=5.0, source="osc", dancers="9", group="front")],
        64 * 7: [larger(7.0, 0.1, "4")],
    }
    _, tree = observed("", 6, does=does)
    values = tree.trees(("front", "back"), 0, 5)["values"]
    assert [(root.part.words, sorted(root.part.dancers), root.first, root.last) for root in values] == [
        ("front", [1, 2, 3, 4, 5], 0, 2), ("back", [6, 7, 8, 9], 0, 2),
        ("front", [1, 2, 3, 4, 5, 9], 3, 5), ("back", [6, 7, 8], 3, 5),
    ]  # fmt: skip
    assert [branch.part.words for branch in values[0].branches] == ["3-5"]
    assert [branch.part.words for branch in values[2].branches] == ["3 + 5", "4"]


@pytest.mark.long
def test_measures_from_some_on_are_observed_again():
    show, whole = observed(SCORE, 5)
    tree = whole.until(1)
    assert [root.last for root in whole.trees(("front", "back"), 0, 9)["steps"]] == [5, 5]
    assert [root.last for root in tree.trees(("front", "back"), 0, 9)["steps"]] == [1, 1]
    tree.observe(show)
    assert tree.trees(("front", "back"), 5, 5)["steps"][0].first == 5


def test_tree_in_words():
    _, tree = observed(SCORE, 7)
    lines = tree_lines(tree.trees(("front", "back"), 0, 6))
    assert lines[:3] == ["steps", "  front (1-5): measures 1-7", "    front & 1-4 (1-4): measures 2-5"]
    assert "      pair (1-2): measures 3-4" in lines
    assert "motion" in lines
    assert "values" not in lines


@pytest.mark.long
def test_reserve_belongs_to_no_row_until_somebody_comes_on():
    score = SCORE + '[[sequence]]\ngroup = "front & left"\nmeasure = 1\nsteps = ["sway x6"]\n'
    _, tree = observed(score, 5, reserve=4)
    roots = tree.trees(("front", "back"), 0, 4)["steps"]
    assert [sorted(root.part.dancers) for root in roots] == [[1, 2, 3, 4, 5], [6, 7, 8, 9]]
    assert all(branch.part.dancers <= set(range(1, 10)) for root in roots for branch in root.branches)
