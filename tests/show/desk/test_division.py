"""Values of selected dancers for motion, look, facing and ripples: parts of groups (T026, T104)."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.base.motion_parameters import ARMS, LARGER, OBEDIENCE
from live.base.picture_parameters import COLOURS_START, MAX_GROUPS, PART_COUNT, group_parameter
from live.control.events import events
from live.show.group.division import Division, dancer_words
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.patch.patch_update import patch_version
from live.show.state.snapshot import restore
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DESK, DeskSession
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.test_snapshot import capture_from, run

LARGER_AT, COLOUR, INK = "/dance/motion/larger", "/dance/group/colour", "/dance/draw/ink"


@pytest.fixture
def session():
    return DeskSession().run(4)


def larger(session):
    return [round(float(value), 6) for value in session.show.variation[LARGER]]


def colours(session):
    """The colour of every dancer in the drawing snapshot."""
    show = session.show
    view = show.view()
    show.fill(view, show.time)
    rows = view.picture[COLOURS_START : COLOURS_START + 3 * PART_COUNT].reshape(-1, 3)
    return [tuple(round(float(part), 4) for part in rows[part]) for part in view.group]


def test_selected_dancers_get_a_value_and_the_others_keep_theirs(session):
    assert session.say(LARGER_AT, 0.5, "2-3")
    assert larger(session) == [0, 0.5, 0.5, 0, 0, 0, 0, 0, 0]
    assert session.say(LARGER_AT, -0.2, "3 + 6")
    assert larger(session) == [0, 0.5, -0.2, 0, 0, -0.2, 0, 0, 0]
    assert session.say("/dance/motion/obedience", 0.9, "1-3")
    assert session.show.variation[OBEDIENCE][:4].round(6).tolist() == [0.9, 0.9, 0.9, 0.5]
    assert larger(session)[:3] == [0, 0.5, -0.2]


def test_value_of_a_group_counts_for_all_its_parts(session):
    session.say(LARGER_AT, 0.5, "3 + 6")
    session.say(LARGER_AT, 0.1, "front")
    assert larger(session) == [0.1] * 5 + [0.5, 0, 0, 0]
    session.say(LARGER_AT, 0.2)
    assert larger(session) == [0.2] * 9


@pytest.mark.long
def test_part_fades_from_its_own_value_while_its_group_fades(session):
    session.say(LARGER_AT, 0.4, "front", 4)
    session.run(4)
    session.say(LARGER_AT, -0.4, "1", 2)
    begin = larger(session)[0]
    session.run(4)
    middle = larger(session)
    session.run(16)
    assert begin > middle[0] > -0.4
    assert middle[1] > begin
    assert larger(session)[:2] == [-0.4, 0.4]


def test_colours_and_styles_of_parts_reach_the_picture(session):
    usual = colours(session)
    session.say(COLOUR, 1.0, 0.0, 0.0, "1 + 9")
    session.say(INK, 0.5, "9")
    session.run(1)
    now = colours(session)
    assert [now[dancer] == usual[dancer] for dancer in range(9)] == [False, *[True] * 7, False]
    assert now[0] == now[8] == (1.0, 0.0, 0.0)
    part = session.show.variation.division.part
    ink = [session.desk.parameters.picture[group_parameter(INK, int(row)).first] for row in part]
    assert [round(float(value), 4) for value in ink] == [0.0] * 8 + [0.5]


def test_places_count_when_the_value_is_set(session):
    position = session.show.motion.state.position
    left = position[:, 0] < 0.0
    assert 0 < left.sum() < 9
    session.say(LARGER_AT, 0.3, "left")
    session.run(16)
    assert (np.array(larger(session)) == 0.3).tolist() == left.tolist()


def test_dancer_who_changes_the_group_gets_its_values(session):
    session.say(LARGER_AT, 0.5, "1-2")
    session.say(LARGER_AT, -0.3, "back")
    session.say("/dance/regroup", "2", "back")
    assert larger(session)[:3] == [0.5, -0.3, 0.0]


@pytest.mark.long
def test_undo_and_redo_of_parts(session):
    session.say(LARGER_AT, 0.2, "1-4")
    session.run(8)
    session.say(LARGER_AT, 0.45, "2-3")
    session.run(8)
    session.say(COLOUR, 0.0, 1.0, 0.0, "3")
    session.run(8)
    session.say("/dance/undo")
    session.say("/dance/undo")
    assert larger(session)[:5] == [0.2, 0.2, 0.2, 0.2, 0]
    session.say("/dance/undo")
    assert larger(session) == [0] * 9
    for _ in range(3):
        session.say("/dance/redo")
    session.run(1)
    assert larger(session)[:5] == [0.2, 0.45, 0.45, 0.2, 0]
    assert colours(session)[2] == (0.0, 1.0, 0.0)


@pytest.mark.long
def test_panic_fades_parts_to_the_patch(session):
    session.say(LARGER_AT, 0.5, "1 + 8")
    session.say(COLOUR, 1.0, 0.0, 0.0, "8")
    before = DeskSession().run(4)
    session.run(2)
    session.say("/dance/panic")
    session.run(8)
    assert larger(session) == [0] * 9
    assert colours(session) == colours(before)


SCENES = """
[selections]
pair = "1 + 9"
[[scene]]
name = "split"
measures = 0
set = {"/dance/motion/larger" = 0.1, "/dance/motion/larger pair" = 0.5, "/dance/draw/ink 9" = 1.0}
"""


def test_scene_sets_values_of_selections_and_start_takes_them_back():
    session = DeskSession(SCENES + DESK).run(4)
    session.say("/dance/scene", "split")
    session.run(1)
    assert larger(session) == [0.5, *[0.1] * 7, 0.5]
    session.say("/dance/scene", "start", 0)
    session.run(1)
    assert larger(session) == [0] * 9
    session.say("/dance/undo")
    assert larger(session) == [0.5, *[0.1] * 7, 0.5]


def test_stored_scene_keeps_parts_and_can_be_written(session):
    session.say(LARGER_AT, 0.5, "1-3 + 9")
    session.say(COLOUR, 1.0, 0.0, 0.0, "9")
    session.run(1)
    session.say("/dance/scene/store", "mine")
    session.say(LARGER_AT, 0.0)
    session.say(COLOUR, 0.0, 0.0, 1.0)
    session.run(1)
    session.say("/dance/scene", "mine", 0)
    session.run(1)
    assert larger(session) == [0.5, 0.5, 0.5, 0, 0, 0, 0, 0, 0.5]
    assert colours(session)[8] == (1.0, 0.0, 0.0)
    written = session.desk.scenes.written("mine")
    assert written == session.desk.scenes.written()
    assert written["/dance/motion/larger 1-3"] == written["/dance/motion/larger 9"] == 0.5
    assert written["/dance/group/colour 9"] == (1.0, 0.0, 0.0)
    assert "/dance/motion/larger front" not in written


@pytest.mark.parametrize(
    ("extra", "field"),
    [
        ('[[scene]]\nname = "x"\nset = {"/dance/motion/larger 12" = 0.1}\n', "scene.1.set"),
        ('[[react]]\nto = "low"\nsets = "larger"\ngroup = "ghost & left"\n', "react.1.group"),
    ],
)
def test_unknown_selection_is_refused_at_its_place(extra, field):
    with pytest.raises(PatchError, match=field):
        DeskSession(extra)


def test_unknown_or_empty_selection_changes_nothing(session):
    before = session.desk.parameters.snapshot()
    for words in ("choir", "12", "front - front", "1 +"):
        assert not session.say(LARGER_AT, 0.5, words)
        assert not session.say("/dance/facing", "30", words)
        assert not session.say("/dance/ripple", 2.0, "left", words)
    assert np.array_equal(session.desk.parameters.snapshot(), before)


def test_more_parts_than_rows_are_refused_until_some_are_alike():
    session = DeskSession("", reserve=70).run(1)
    for dancer in range(1, PART_COUNT - 1):
        assert session.say(LARGER_AT, dancer / 200.0, str(dancer))
    assert not session.say(LARGER_AT, 0.4, "70")
    assert "parts" in session.show.refusals.last_reason
    values = larger(session)
    assert values[:62] == [round(dancer / 200.0, 6) for dancer in range(1, 63)]
    session.say(LARGER_AT, 0.0, "1-40")
    assert session.say(LARGER_AT, 0.4, "70")
    assert larger(session)[69] == 0.4
    assert larger(session)[41] == values[41]


def test_random_divisions_agree_with_a_value_for_each_dancer():
    """An independent table with one value for each dancer."""
    random = np.random.default_rng(5)
    session = DeskSession().run(1)
    values = np.zeros(9)
    group = np.array([0] * 5 + [1] * 4)
    for _ in range(150):
        dancers = np.sort(random.choice(9, random.integers(1, 6), replace=False))
        value = round(float(random.uniform(-0.3, 0.3)), 3)
        kind = random.integers(4)
        if kind == 0:
            name = int(random.integers(2))
            assert session.say(LARGER_AT, value, ("front", "back")[name])
            values[group == name] = value
        else:
            assert session.say(LARGER_AT, value, dancer_words((dancers + 1).tolist()))
            values[dancers] = value
        assert larger(session) == values.round(6).tolist()


@pytest.mark.long
def test_facing_and_ripple_of_selected_dancers(session):
    session.say("/dance/facing", "90", "2 + 7")
    session.say("/dance/ripple", 2.0, "left", "1-3")
    session.run(32)
    heading = session.show.scheduler.targets.heading
    assert np.degrees(heading[[1, 6]]) == pytest.approx([90.0, 90.0])
    delays = session.show.variation.delays
    assert delays[:3].max() > 0.1
    assert delays[3:].max() == 0.0
    session.say("/dance/undo")
    session.say("/dance/undo")
    session.say("/dance/facing", "-90", "front")
    session.run(32)
    assert np.degrees(session.show.scheduler.targets.heading[1]) == pytest.approx(-90.0)
    assert session.show.variation.delays.max() == 0.0


@pytest.mark.long
def test_edited_patch_changes_parts_only_where_it_differs(session):
    session.say(LARGER_AT, 0.5, "1")
    edited = session.show.patch.model_copy(update={"motion": replace_motion(session.show.patch, arms=0.2)})
    text = edited.model_dump_json()
    session.show.apply(events.PatchChanged(time=2.5, source="patch", patch=text, version=patch_version(text)))
    session.run(16)
    assert larger(session)[:2] == [0.5, 0.0]
    assert session.show.variation[ARMS].round(6).tolist() == [0.2] * 9


def replace_motion(patch, **values):
    return patch.motion.model_copy(update=values)


REACT = '[[react]]\nto = "low"\nsets = "larger"\ngroup = "1 + 6"\nbeats = 0\n'
LOADED = LoadedShow(Path("test.toml"), parse_patch(PATCH + REACT, "test.toml"), GRAPH)
HEARD = events.MusicHeard(
    time=1.0, source="audio", beat_time=0.9, loudness=0.5, density=0.5, brightness=0.5, low=0.4, build=0.0, drop=False,
    loudness_db=-20.0,
)  # fmt: skip
SCRIPT = {
    64: HEARD,
    130: events.SetParameter(time=2.0, source="osc", address=LARGER_AT, value=(0.4,), group="left", measures=3.0),
    260: events.SetParameter(time=4.0, source="osc", address=COLOUR, value=(0.0, 1.0, 0.5), group="2-4", measures=4.0),
    300: replace(HEARD, time=4.7, low=0.9),
    400: events.Regroup(time=6.2, source="osc", dancers="3", group="back"),
    500: events.Undo(time=7.8, source="osc"),
}


def test_music_moves_values_of_a_selection():
    show = LOADED.start()
    run(show, 1, 70, SCRIPT)
    values = show.variation[LARGER]
    assert values[0] == values[5] > 0.0
    assert not values[[1, 2, 3, 4, 6, 7, 8]].any()


@mostly_long("tick", [100, 170, 280, 420, 520], quick=[4])
def test_restored_parts_continue_bit_identically(tick):
    show = LOADED.start()
    run(show, 1, tick, SCRIPT)
    at, data = capture_from(show, tick, SCRIPT)
    restored = restore(LOADED, data)
    assert run(restored, at + 1, at + 300, SCRIPT) == run(show, at + 1, at + 300, SCRIPT)
    assert np.array_equal(restored.desk.parameters.snapshot(), show.desk.parameters.snapshot())
    assert np.array_equal(restored.variation.division.part, show.variation.division.part)


def test_groups_leave_rows_for_parts():
    assert PART_COUNT >= 2 * MAX_GROUPS
    division = Division(np.array([0, 0, 1], np.int32), 2)
    copies = []
    parts = division.divide(
        np.array([True, False, True]), lambda old, new: copies.append((old, new)), lambda part, other: False
    )
    assert parts == [2, 3]
    assert copies == [(0, 2), (1, 3)]
    assert division.parts_of([0]) == [0, 2]
    assert dancer_words([1, 2, 3, 5, 7, 8]) == "1-3 + 5 + 7-8"


@mostly_long("seed", [1, 2, 3], quick=[])
def test_random_edits_of_selections_undone_and_redone_in_order(seed):
    random = np.random.default_rng(seed)
    session = DeskSession(SCENES + DESK).run(4)
    kept = [(larger(session), colours(session))]
    for _ in range(25):
        dancers = dancer_words(np.sort(random.choice(9, random.integers(1, 5), replace=False) + 1).tolist())
        words = (dancers, "front", "left", "*")[random.integers(4)]
        kind = random.integers(5)
        if kind == 0:
            session.say("/dance/scene", ("split", "low", "start")[random.integers(3)], 0)
        elif kind == 1:
            session.say(COLOUR, *random.uniform(0.0, 1.0, 3).round(2).tolist(), words)
        else:
            session.say(LARGER_AT, round(float(random.uniform(-0.4, 0.4)), 2), words)
        session.run(3)
        kept.append((larger(session), colours(session)))
    done = [before for before, after in itertools.pairwise(kept) if before != after]
    for wanted in reversed(done):
        before = larger(session), colours(session)
        while (larger(session), colours(session)) == before:  # an edit without effect here is one as well
            session.say("/dance/undo")
            session.run(1)
        assert (larger(session), colours(session)) == wanted
    for _ in range(30):
        session.say("/dance/redo")
    session.run(1)
    assert (larger(session), colours(session)) == kept[-1]
