"""What a choreographer is told of the score's evolutions before they are danced."""

from live.show.group.dry_run import MAX_WARNINGS, dry_run_warnings
from tests.show.made_show import made_show


def notes(segments):
    return dry_run_warnings(made_show(segments))


def test_a_score_that_can_be_danced_needs_no_words():
    assert notes("") == []
    assert notes('[[segment]]\nmeasure = 2\nmeasures = 6\nformation = "line"\ngroup = "front"\n') == []


def test_a_way_that_no_step_reaches_is_told_with_its_measure():
    (note,) = notes('[[segment]]\nmeasure = 3\nmeasures = 1\ngroup = "1"\npath = [[0, 0], [0, -5]]\n')
    assert note.startswith("measure 3: a dancer has 5.0 m to go, their steps reach 1.2")
    assert "more measures" in note


def test_who_would_meet_is_told():
    note, *_ = notes('[[segment]]\nmeasure = 2\nmeasures = 9\ngroup = "1-2"\nformation = "line"\nmatch = "number"\n'
                    'way = "straight"\nmirror = true\n')  # fmt: skip
    assert "dancers 1 and 2 would come as near as" in note


def test_no_more_than_a_few_of_each_kind():
    many = "".join(
        f'[[segment]]\nmeasure = {m}\nmeasures = 1\ngroup = "1"\npath = [[0, 0], [{5 * (-1) ** m}, 0]]\n'
        for m in range(1, 20)
    )
    told = notes(many)
    assert len(told) == MAX_WARNINGS + 1
    assert told[-1] == f"... and {19 - MAX_WARNINGS} more of this kind"


def test_of_each_segment_the_nearest_two_are_told_and_how_many_more():
    crossing = '[[segment]]\nmeasure = {}\nmeasures = 4\nformation = "{}"\nmatch = "number"\nway = "straight"\n'
    told = notes(crossing.format(1, "line") + "mirror = true\n" + crossing.format(6, "line"))
    near = [note for note in told if "would come as near" in note]
    assert len(near) == 2
    for note, begins in zip(near, (1, 6), strict=True):
        assert f"the segment that begins in measure {begins};" in note
        assert "more pair" in note
