"""Tests of dry-run warnings about the evolutions of a score."""

from live.show.group.dry_run import MAX_WARNINGS, dry_run_warnings
from tests.show.made_show import made_show


def warnings_of(segments):
    return dry_run_warnings(made_show(segments))


def test_danceable_score_gives_no_warnings():
    assert warnings_of("") == []
    assert warnings_of('[[segment]]\nmeasure = 2\nmeasures = 6\nformation = "line"\ngroup = "front"\n') == []


def test_unreachable_path_gives_warning_with_measure():
    (note,) = warnings_of('[[segment]]\nmeasure = 3\nmeasures = 1\ngroup = "1"\npath = [[0, 0], [0, -5]]\n')
    assert note.startswith("measure 3: a dancer has 5.0 m to go, their steps reach 1.")
    assert "more measures" in note


def test_near_collision_gives_warning():
    note, *_ = warnings_of(
        '[[segment]]\nmeasure = 2\nmeasures = 9\ngroup = "1-2"\nformation = "line"\nmatch = "number"\n'
        'way = "straight"\nmirror = true\n'
    )
    assert "dancers 1 and 2 would come as near as" in note


def test_warnings_of_one_kind_are_limited():
    many = "".join(
        f'[[segment]]\nmeasure = {m}\nmeasures = 1\ngroup = "1"\npath = [[0, 0], [{5 * (-1) ** m}, 0]]\n'
        for m in range(1, 20)
    )
    told = warnings_of(many)
    assert len(told) == MAX_WARNINGS + 1
    assert told[-1] == f"... and {19 - MAX_WARNINGS} more of this kind"


def test_each_segment_reports_nearest_pair_and_count_of_others():
    crossing = '[[segment]]\nmeasure = {}\nmeasures = 4\nformation = "{}"\nmatch = "number"\nway = "straight"\n'
    told = warnings_of(crossing.format(1, "line") + "mirror = true\n" + crossing.format(6, "line"))
    near = [note for note in told if "would come as near" in note]
    assert len(near) == 2
    for note, begins in zip(near, (1, 6), strict=True):
        assert f"the segment that begins in measure {begins};" in note
        assert "more pair" in note


def test_groups_that_cross_are_planned_together():
    """The two rows change places: nobody meets, and no more words are needed (T147)."""
    assert (
        warnings_of(
            '[[segment]]\nmeasure = 2\nmeasures = 8\ngroup = "front"\nformation = "line"\n'
            '[[segment]]\nmeasure = 2\nmeasures = 8\ngroup = "back"\nformation = "square"\n'
            '[[formation]]\nname = "square"\nshape = "grid"\nsize = [3.0, 1.5]\ncentre = [0.0, 2.5]\n'
        )
        == []
    )


def test_places_of_two_groups_that_overlap_are_told_with_how_many_fit():
    same = '[[segment]]\nmeasure = 2\nmeasures = 8\ngroup = "{}"\nformation = "line"\n'
    (note,) = warnings_of(same.format("1-4") + same.format("6-9"))
    assert "places of two groups overlap, 4 pairs of dancers would touch there: 4 of these 8 dancers fit" in note
    assert "move one of the formations" in note


def test_formation_too_small_for_its_group_is_told_with_how_many_fit():
    told = warnings_of(
        '[[segment]]\nmeasure = 2\nmeasures = 8\ngroup = "front"\nformation = "tight"\n'
        '[[formation]]\nname = "tight"\nshape = "line"\nsize = [1.1, 1.1]\n'
    )
    assert any("bodies touch" in note for note in told)
    assert any("3 of these 5 dancers fit without touching" in note for note in told)
