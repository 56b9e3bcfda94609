"""Hints about elements after which nothing moves their dancers: where, and segments to paste as they are."""

import re
import textwrap
import time
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from live.agents.evolutions.slot_assignment import assign, distances
from live.clock.ticks import TICK
from live.rehearse.lint import lint_show
from live.rehearse.open_ends import MAX_HINTS, ScoreEnds, next_formation_hints
from live.show.group.agent_run import agent_places
from live.show.group.dry_run import dry_run_warnings
from live.show.loader import load_show
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import PATCH, made_show

CROSS = '[[element]]\nkind = "cross"\nmeasure = 2\nmeasures = 3\nat = [0.0, -3.5]\nto = [0.0, 3.5]\n'
SECTIONS = '[[section]]\nname = "a"\nmeasures = 6\n[[section]]\nname = "b"\nmeasures = 3\n'
ATTRACT = '[[element]]\nkind = "attract"\nmeasure = {}\nmeasures = {}\ngroup = "{}"\n'


def ends_of(extra, *, loop=None):
    text = ("" if loop is None else f"loop_measures = {loop}\n") + PATCH + extra
    show = made_show(extra)
    return [(one.begin, one.end, one.next, one.room) for one in
            ScoreEnds(parse_patch(text, "made.toml"), show.casting, show.state.position).open()]  # fmt: skip


def blocks(hint):
    """The suggested segments of a hint, as TOML."""
    return [textwrap.dedent(each) for each in re.findall(r"    \[\[segment\]\].*?(?=\n    \[\[|\Z)", hint, re.S)]


@mostly_long(
    "follows",
    [
        '[[segment]]\nmeasure = 5\nformation = "circle"\n',
        '[[segment]]\nmeasure = 8\nformation = "circle"\ngroup = "front"\n',
        '[[segment]]\nmeasure = 7\nformation = "circle"\ngroup = "left"\n',
        '[[element]]\nkind = "wander"\nmeasure = 8.5\n',
        '[[element]]\nkind = "spread"\nmeasure = 1\nmeasures = 40\n',
        '[[at]]\nmeasure = 6\nbeat = 3\ncall = "/dance/formation"\nvalues = ["circle", 2]\n',
        '[[at]]\nmeasure = 6\ncall = "/dance/attract"\nvalues = [1, 0]\n',
        '[[improvise]]\nmeasure = 3\nmeasures = 8\n[[improvise.motion]]\ncall = "/dance/formation"\n'
        'values = ["star", 3]\n',
    ],
    quick=[3, 4, 5, 6],
)
def test_something_follows(follows):
    assert (1, 4, 4) not in [one[:3] for one in ends_of(CROSS + follows)]


@mostly_long(
    "other",
    [
        "",
        '[[segment]]\nmeasure = 9\nformation = "circle"\n',
        '[[segment]]\nmeasure = 1\nmeasures = 2\nformation = "circle"\n',
        '[[at]]\nmeasure = 6\ncall = "/dance/light/level"\nvalues = [0.5]\n',
        '[[at]]\nmeasure = 3\ncall = "/dance/attract"\nvalues = [1, 0]\n',
        "[[improvise]]\nmeasure = 3\nmeasures = 8\n",
    ],
    quick=[0, 3, 4, 5],
)
def test_nothing_follows_within_four_measures(other):
    assert ends_of(CROSS + other) == [(1, 4, 4, 4 if "9" in other else 8)]


def test_what_moves_other_dancers_is_no_matter():
    back = '[[segment]]\nmeasure = 5\nformation = "circle"\ngroup = "back"\n'
    assert ends_of(CROSS + 'group = "front"\n' + back) == [(1, 4, 4, 8)]
    assert ends_of(CROSS + back) == []


@pytest.mark.long
def test_score_that_begins_again_follows_itself():
    assert ends_of(CROSS, loop=20) == [(1, 4, 4, 8)]
    assert ends_of(CROSS, loop=6) == []  # it comes again after three measures
    assert ends_of(CROSS, loop=9) == [(1, 4, 4, 5)]
    assert ends_of(ATTRACT.format(2, 7, "*"), loop=8) == []
    late = ATTRACT.format(16, 5, "*")
    assert ends_of(late, loop=20) == [(15, 20, 0, 8)]
    assert ends_of(late + '[[segment]]\nmeasure = 3\nformation = "line"\n', loop=20) == []


def test_room_ends_with_the_section():
    cross = CROSS.replace("measure = 2", 'section = "a"\nmeasure = 1')
    show = made_show(SECTIONS + cross)
    (one,) = ScoreEnds(show.patch, show.casting, show.state.position).open()
    assert (one.end, one.room) == (3, 3)
    (hint,) = next_formation_hints(show)
    for block in blocks(hint):
        (entry,) = tomllib.loads(block)["segment"]
        assert (entry["section"], entry["measure"]) == ("a", 4)
        assert entry["measures"] <= 3


def test_elements_that_end_together_are_one():
    both = ATTRACT.format(2, 3, "*") + "at = [2.0, 0.0]\n" + ATTRACT.format(3, 2, "*")
    assert ends_of(both) == [(1, 4, 4, 8)]
    assert len(ends_of(ATTRACT.format(2, 3, "front") + ATTRACT.format(3, 2, "back"))) == 2


@mostly_long("group", ["*", "front", "front + 7"], quick=[1])
def test_suggestions_can_be_pasted_and_the_hint_is_gone(group):
    cross = f'{CROSS}group = "{group}"\n'
    (hint,) = next_formation_hints(made_show(cross))
    count = {"*": 9, "front": 5, "front + 7": 6}[group]
    assert hint.startswith(f"measure 5: after the 'cross' of measure 2, {count} dancers stand where it left them")
    former = [words for one in lint_show(made_show(cross)) for words in one.warnings]
    assert len(blocks(hint)) == 2
    for block in blocks(hint):
        (entry,) = tomllib.loads(block)["segment"]
        assert entry["measure"] == 5
        assert entry.get("group", "*") == group
        assert next_formation_hints(made_show(cross + block)) == []
        told = [words for one in lint_show(made_show(cross + block)) for words in one.warnings]
        assert [words for words in told if words not in former] == []


def test_formations_of_the_show_are_suggested_too():
    own = '[[formation]]\nname = "my \\"own\\""\nshape = "places"\npoints = {}\n'
    show = made_show(CROSS)
    there = agent_places(show, {4})[4].round(2).tolist()
    (hint,) = next_formation_hints(made_show(CROSS + own.format(there)))
    assert tomllib.loads(blocks(hint)[0])["segment"][0]["formation"] == 'my "own"'


@pytest.mark.long
def test_same_score_gives_the_same_hints_and_few_of_them():
    many = "".join(ATTRACT.format(1 + 6 * number, 2, "*") for number in range(MAX_HINTS + 3))
    hints = next_formation_hints(made_show(many))
    assert len(hints) == MAX_HINTS + 1
    assert hints[-1].startswith("... and 3 more elements")
    assert next_formation_hints(made_show(many)) == hints


def test_a_score_without_elements_costs_nothing():
    assert next_formation_hints(made_show('[[segment]]\nmeasure = 2\nformation = "circle"\n')) == []


def test_nothing_within_reach_is_said():
    corner = ATTRACT.format(1, 6, "*") + "at = [5.0, 3.0]\n"
    (hint,) = next_formation_hints(made_show(SECTIONS.replace("measures = 3", "measures = 1") + corner))
    assert hint.startswith("measure 7: after the 'attract' of measure 1, 9 dancers")
    assert hint.endswith("no formation that the show knows is within reach in a measure")


@mostly_long("extra", [CROSS, CROSS.replace("measures = 3", "measures = 8"), ATTRACT.format(2, 6, "*")], quick=[])
def test_agents_alone_stand_about_where_the_show_leads(extra):
    """As a set: dancers may have passed each other on another side."""
    alone = agent_places(made_show(extra), {4, 10})
    show, tick = made_show(extra), 0
    for measure in (4, 10):
        while show.span.number < measure:
            tick += 1
            show.tick(tick * TICK)
        there = show.state.position
        slot = assign(alone[measure], there)
        assert distances(alone[measure], there)[np.arange(len(slot)), slot].mean() < 0.5


@pytest.mark.long
def test_dry_run_begins_where_elements_have_led_the_dancers():
    """A way that is short from there, and too long from where they were before, is no cause for a note."""
    gather = '[[element]]\nkind = "attract"\nmeasure = 1\nmeasures = 12\nat = [3.0, 0.0]\ngroup = "1"\n'
    go = '[[segment]]\nmeasure = {}\nmeasures = 2\ngroup = "1"\nformation = "there"\n'
    there = '[[formation]]\nname = "there"\nshape = "places"\npoints = [[3.5, 0.0], [9.0, 9.0]]\n'
    far = [words for words in dry_run_warnings(made_show(there + go.format(1))) if "to go" in words]
    assert far
    assert [words for words in dry_run_warnings(made_show(gather + there + go.format(13))) if "to go" in words] == []
    away = there.replace("[3.5, 0.0]", "[-5.5, -3.5]")
    assert [words for words in dry_run_warnings(made_show(gather + away + go.format(13))) if "to go" in words]


@pytest.mark.long
def test_shipped_suggestions_lint_clean():
    """Those for a show with a reserve and partners: pasted, they add no note."""
    path = PATCHES / "release" / "show.toml"
    loaded = load_show(path)
    hints = next_formation_hints(loaded.start(begin=False))
    assert hints
    former = [words for one in lint_show(loaded.start(begin=False)) for words in one.warnings]
    for block in (block for hint in hints for block in blocks(hint)):
        edited = parse_patch(path.read_text() + "\n" + block + "\n", str(path))
        show = replace(loaded, patch=edited).start(begin=False)
        told = [words for one in lint_show(show) for words in one.warnings]
        assert [words for words in told if words not in former] == []


@pytest.mark.long
def test_live_check_prints_hints_and_succeeds(tmp_path):
    show = tmp_path / "show.toml"
    show.write_text('name = "x"\n[[group]]\nname = "a"\ndancers = 6\nsteps = ["walk"]\n' + CROSS)
    result = run_live("check", str(show))
    assert result.returncode == 0, result.stderr
    hint = result.stdout[: result.stdout.index("ok ")]
    assert hint.startswith("hint: measure 5: after the 'cross' of measure 2, 6 dancers stand where it left them")
    assert len(blocks(hint)) == 2
    show.write_text(show.read_text() + blocks(hint)[0])
    again = run_live("check", str(show))
    assert again.stdout.startswith("ok ")


def test_long_scores_are_looked_at_quickly():
    """Two thousand entries: what takes long is the dance of the first measures. The bound is loose."""
    rows = "".join(
        ATTRACT.format(measure, 1, "front") + f'[[segment]]\nmeasure = {measure}\nmeasures = 1\ngroup = "back"\n'
        for measure in range(1, 1000)
    )
    show = made_show(rows)
    begin = time.perf_counter()
    assert [one.end for one in ScoreEnds(show.patch, show.casting, show.state.position).open()] == []
    assert time.perf_counter() - begin < 5.0
