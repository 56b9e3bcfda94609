"""Steps of selected dancers, from the score and on request: parts of a group, single dancers, places (T026)."""

from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version
from live.show.score.score_sheet import build_sheet
from live.show.score.subgroups import MAX_REQUESTED, MAX_SELECTIONS
from live.show.state.snapshot import restore
from live.show.view.status import Status
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH, made_show
from tests.show.patch.test_score_edited import patch_edit
from tests.show.state.test_snapshot import capture_from, run

OWN = ["sway", "glide", "glide", "spin", "phrase", "phrase"]
"""The steps of the group `front`, dancers 1 to 5; `back` has dancers 6 to 9."""


def dances(show, seconds, *, does=None):
    """The step of every dancer in each measure, by dancer (from 1); `does`: events by tick."""
    library, danced = show.graph.library, []
    for tick in range(1, round(64 * seconds)):
        if does and tick in does:
            show.apply(does[tick](tick * TICK))
        if show.tick(tick * TICK) or tick == 1:
            danced.append([library.steps[library.node_step[node]] for node in show.dancers.node])
    return {dancer + 1: list(steps) for dancer, steps in enumerate(zip(*danced, strict=True))}


def asks(kind, **values):
    return lambda time: kind(time=time, source="osc", **values)


def sequence(group, measure, *steps, **more):
    keys = "".join(f"{key} = {value!r}\n" for key, value in more.items())
    return f'[[sequence]]\ngroup = "{group}"\nmeasure = {measure}\nsteps = {list(steps)}\n{keys}'


def test_part_of_a_group_dances_its_sequence_and_returns_to_the_group():
    steps = dances(made_show(sequence("front & 1-2", 3, "spin x2")), 14)
    for dancer in (1, 2):
        assert steps[dancer][2:4] == ["spin", "spin"]
        assert steps[dancer][:2] == OWN[:2]
        assert steps[dancer][4:6] == OWN[4:6]
    assert [steps[dancer][:6] for dancer in (3, 4, 5)] == [OWN] * 3


@pytest.mark.long
def test_smaller_part_counts_before_larger_and_both_before_the_group():
    score = sequence("*", 1, "sway x6") + sequence("1-4", 2, "glide x4") + sequence("3", 3, "spin x2")
    steps = dances(made_show(score), 13)
    assert steps[3][:6] == ["sway", "glide", "spin", "spin", "glide", "sway"]
    assert steps[1][:6] == ["sway", "glide", "glide", "glide", "glide", "sway"]
    assert steps[5][:6] == steps[9][:6] == ["sway"] * 6


def test_selection_reaches_into_several_groups():
    steps = dances(made_show(sequence("4 + 5 + 6", 2, "spin x3")), 10)
    assert [steps[dancer][1:4] for dancer in (4, 5, 6)] == [["spin"] * 3] * 3
    assert steps[1][1:4] == OWN[1:4]


@pytest.mark.long
def test_place_counts_when_the_entry_begins():
    show = made_show(sequence("left", 3, "spin x4"))
    tick = 0
    while show.span.number < 2:
        tick += 1
        show.tick(tick * TICK)
    chosen = show.scheduler.subgroups.written[0][0].chosen.copy()
    assert 0 < chosen.sum() < 9
    library = show.graph.library
    for later in range(tick + 1, tick + 64 * 7):
        show.tick(later * TICK)
        if show.span.number in (3, 4):
            spins = library.node_step[show.dancers.node] == library.step_index("spin")
            assert spins[chosen].all()


@pytest.mark.long
def test_random_sequence_and_improvisation_of_a_part_use_their_own_steps():
    score = sequence("1-2", 1, "spin", "glide", choose="random", measures=8)
    score += '[[improvise]]\ngroup = "6 + 7"\nmeasures = 8\nsteps = {sway = 1, spin = 1}\n'
    steps = dances(made_show(score), 17)
    assert {step for dancer in (1, 2) for step in steps[dancer][:8]} == {"spin", "glide"}
    assert {step for dancer in (6, 7) for step in steps[dancer][:8]} == {"sway", "spin"}
    assert steps[1] == steps[2]
    assert steps[3][:6] == OWN


@pytest.mark.long
def test_part_keeps_its_random_steps_wherever_it_stands_in_the_score():
    part = sequence("1-2", 1, "spin", "glide", "sway", choose="random", measures=8)
    first = dances(made_show(part + sequence("6", 1, "spin")), 15)[1]
    assert first == dances(made_show(sequence("6", 1, "spin") + part), 15)[1]


@pytest.mark.parametrize(
    ("score", "field", "words"),
    [
        (sequence("choir & left", 1, "spin"), "sequence.1.group", "choir"),
        (sequence("12", 1, "spin"), "sequence.1.group", "no dancer 12"),
        (sequence("1-3", 1, "spin x4") + sequence("3-4", 2, "sway"), "sequence.2.group", "dancer 3 is in both"),
        (sequence("1-3", 1, "spin x4") + sequence("1 + 2 + 3", 4, "sway"), "sequence.2.group", "in both"),
        (sequence("1-3", 1, "spin x4") + sequence("1-3", 4, "sway"), "sequence.2.measure", "lasts until the end"),
        (
            '[[improvise]]\ngroup = "2-3"\n' + sequence("1-2", 6, "sway"),
            "sequence.1.group",
            "neither is part of the other",
        ),
    ],
)
def test_impossible_selection_is_refused_at_its_place(score, field, words):
    with pytest.raises(PersonError) as caught:
        made_show(score)
    assert words in str(caught.value)
    assert ".".join(str(one + 1 if isinstance(one, int) else one) for one in caught.value.key_path) == field


def test_too_many_selections_are_refused():
    names = "".join(f'p{number} = "1"\n' for number in range(MAX_SELECTIONS + 1))
    score = "".join(sequence(f"p{number}", number + 1, "sway") for number in range(MAX_SELECTIONS + 1))
    with pytest.raises(PersonError, match="different selections"):
        made_show(f"[selections]\n{names}{score}")


@pytest.mark.long
def test_call_for_a_part_ends_after_its_measures():
    steps = dances(made_show(), 15, does={64: asks(events.CallStep, name="spin", measures=2.0, group="2-3")})
    assert steps[2][1:3] == steps[3][1:3] == ["spin", "spin"]
    assert steps[1][:6] == OWN
    assert steps[2][4:6] == OWN[4:6]


@pytest.mark.long
def test_sequence_for_a_part_lasts_until_clear_and_group_call_interrupts_it():
    does = {
        64: asks(events.SetSequence, steps="spin, sway", group="front & 1-2"),
        64 * 5: asks(events.CallStep, name="glide", measures=1.0, group="*"),
        64 * 9: asks(events.Clear),
    }
    show = made_show()
    steps = dances(show, 16, does=does)
    assert steps[1][:6] == ["sway", "spin", "sway", "glide", "spin", "phrase"]
    assert steps[1] == steps[2]
    assert not show.scheduler.subgroups.requested
    assert steps[3][6:] == steps[1][6:]


@pytest.mark.long
def test_parts_can_be_divided_again():
    does = {
        64: asks(events.SetSequence, steps="spin", group="1-4"),
        64 * 4: asks(events.SetSequence, steps="glide", group="2 + 3"),
        64 * 8: asks(events.CallStep, name="sway", measures=2.0, group="3"),
    }
    show = made_show()
    steps = dances(show, 16, does=does)
    assert steps[1][1:7] == steps[4][1:7] == ["spin"] * 6
    assert steps[2][3:7] == ["glide"] * 4
    assert steps[3][3:7] == ["glide"] * 2 + ["sway"] * 2
    assert steps[3][7] == "glide"
    assert len(show.scheduler.subgroups.requested) == 3


@pytest.mark.long
def test_group_request_takes_its_parts_along():
    does = {
        64: asks(events.SetSequence, steps="spin", group="1-2"),
        64 * 4: asks(events.SetSequence, steps="glide", group="front"),
    }
    steps = dances(made_show(), 12, does=does)
    assert steps[1][3:5] == steps[3][3:5] == ["glide", "glide"]


@pytest.mark.long
def test_request_for_a_group_counts_before_its_written_parts():
    does = {64 * 3: asks(events.CallStep, name="glide", measures=2.0, group="front")}
    steps = dances(made_show(sequence("1-2", 1, "spin x8")), 14, does=does)
    assert steps[1][:6] == ["spin", "spin", "glide", "glide", "spin", "spin"]


@pytest.mark.long
def test_improvisation_of_a_part_can_be_switched():
    does = {
        64: asks(events.Improvise, on=True, group="1-3"),
        64 * 9: asks(events.Improvise, on=False, group="1-3"),
    }
    show = made_show('[[sequence]]\nmeasures = 16\nsteps = ["sway"]\n')
    steps = dances(show, 14, does=does)
    assert set(steps[1][1:5]) - {"sway"}
    assert steps[4][:6] == ["sway"] * 6
    assert steps[1][5] == "sway"
    assert not show.scheduler.subgroups.requested


@pytest.mark.long
def test_cue_now_continues_for_its_measures_with_the_part():
    steps = dances(made_show(), 14, does={40: asks(events.StepNow, name="spin", group="1-2", measures=2.0)})
    assert steps[1][1:3] == steps[2][1:3] == ["spin", "spin"]
    assert steps[3][1:3] == OWN[1:3]


def test_sequence_of_a_part_can_be_undone_and_redone():
    show = made_show()
    show.tick(TICK)
    for event in (
        events.SetSequence(time=0.1, source="osc", steps="spin, sway", group="1-2"),
        events.SetSequence(time=5.1, source="osc", steps="glide", group="2"),
    ):
        show.apply(event)
    both = show.scheduler.subgroups.sequences
    assert [row[2] for row in both] == [(0,), (1,)]
    show.apply(events.Undo(time=6.0, source="osc"))
    assert [row[2] for row in show.scheduler.subgroups.sequences] == [(0, 1)]
    show.apply(events.Redo(time=6.1, source="osc"))
    assert sorted(row[2:] for row in show.scheduler.subgroups.sequences) == sorted(row[2:] for row in both)


def test_nobody_and_too_many_parts_are_refused_without_effect():
    show = made_show("", reserve=60)
    show.tick(TICK)
    before = show.refusals.count
    show.apply(events.CallStep(time=0.1, source="osc", name="spin", group="front - front"))
    assert show.refusals.count == before + 1
    for dancer in range(1, MAX_REQUESTED + 2):
        show.apply(events.CallStep(time=0.1, source="osc", name="spin", group=str(dancer)))
    assert show.refusals.count == before + 2
    assert "subgroups" in show.refusals.last_reason
    assert len(show.scheduler.subgroups.requested) == MAX_REQUESTED


@pytest.mark.long
def test_edit_adds_and_removes_steps_of_parts():
    first, second = sequence("1-2", 1, "spin x16"), sequence("2", 5, "glide x12")
    does = {64 * 5: patch_edit(first + second), 64 * 11: patch_edit(second)}
    steps = dances(made_show(first), 17, does=does)
    assert steps[1][:6] == ["spin"] * 6
    assert steps[2][:8] == ["spin"] * 4 + ["glide"] * 4
    assert "spin" not in steps[1][6:8] or steps[1][6:8] == steps[3][6:8]


@pytest.mark.long
def test_subgroups_that_an_edit_removes_end_with_it():
    first, second = sequence("1-2", 1, "spin x16"), sequence("7", 1, "glide x16")
    show = made_show(first + second)
    edit = patch_edit(second)
    removed = None
    for tick in range(1, 64 * 9):
        if tick == 64 * 5:
            show.apply(edit(tick * TICK))
        show.tick(tick * TICK)
        subgroups = show.scheduler.subgroups
        danced = {each.words for each in subgroups.active}
        if tick > 64 * 3 and removed is None and danced == {"7"}:
            removed = tick
        if tick > 64 * 3:
            assert {each.words for each in subgroups.active} <= {row[0].words for row in subgroups.written}
            assert np.flatnonzero(subgroups.of_dancer >= 0).tolist() == ([0, 1, 6] if removed is None else [6])
    assert removed is not None


def test_status_tells_which_dancers_have_something_of_their_own():
    show = made_show(sequence("front & 1-2", 1, "spin x16"))
    for tick in range(1, 64 * 3):
        show.tick(tick * TICK)
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    assert status.snapshot(show.time)["division"] == [
        {"kind": "steps", "group": "front", "words": "front & 1-2", "dancers": [1, 2]}
    ]


def test_sheet_shows_parts_below_what_they_are_parts_of():
    score = sequence("1", 3, "spin") + sequence("6-9 & left", 2, "sway") + sequence("1-3", 1, "sway x4")
    show = made_show(score + sequence("1 + 6", 6, "glide"))
    tracks = [(track.name, track.depth) for track in build_sheet(show).tracks]
    assert tracks[1:] == [("front", 0), ("1-3", 1), ("1", 2), ("back", 0), ("6-9 & left", 1), ("1 + 6", 0)]


@pytest.mark.long
def test_group_that_becomes_a_canon_follows_the_score_of_the_running_show():
    """Its programs are new; they read the running show's playhead."""
    canon = PATCH.replace('steps = ["glide", "sway", "spin"]\nchoose = "random"', 'like = "front"')
    score = sequence("back", 8, "spin x2")
    text = parse_patch(canon + score, "test.toml").model_dump_json()
    edit = asks(events.PatchChanged, patch=text, version=patch_version(text))
    steps = dances(made_show(score), 21, does={64 * 5: edit})
    assert steps[6][7:9] == ["spin", "spin"]


SCORE = (
    '[[section]]\nname = "a"\nmeasures = 3\nrepeat = 2\n'
    + sequence("left", 1, "spin", "sway", section="a", measures=3, choose="random")
    + sequence("2", 2, "glide", section="a")
)
LOADED = LoadedShow(Path("test.toml"), parse_patch(PATCH + SCORE, "test.toml"), GRAPH)
SCRIPT = {
    90: events.SetSequence(time=1.4, source="osc", steps="spin, glide", group="right & front"),
    300: events.CallStep(time=4.6, source="osc", name="sway", group="5 + 6", measures=3.0),
    400: events.Improvise(time=6.2, source="osc", on=True, group="7-8"),
    500: events.SetFacing(time=7.8, source="osc", facing="90", group="left"),
    560: events.SetRipple(time=8.7, source="osc", beats=2.0, group="1-6"),
    700: events.Undo(time=10.9, source="osc"),
}


@mostly_long("tick", [40, 110, 233, 310, 420, 600, 720], quick=[0])
def test_restored_subgroups_continue_bit_identically(tick):
    show = LOADED.start()
    run(show, 1, tick, SCRIPT)
    at, data = capture_from(show, tick, SCRIPT)
    restored = restore(LOADED, data)
    assert run(restored, at + 1, at + 300, SCRIPT) == run(show, at + 1, at + 300, SCRIPT)
    assert np.array_equal(restored.scheduler.subgroups.of_dancer, show.scheduler.subgroups.of_dancer)


def test_sheet_shows_a_track_for_each_part():
    sheet = build_sheet(made_show("loop_measures = 6\n", top=True))
    assert [track.name for track in sheet.tracks if track.group >= 0] == ["front", "back"]
    show = made_show(sequence("front & 1-2", 3, "spin x2") + sequence("left", 5, "sway"))
    tracks = {track.name: track for track in build_sheet(show).tracks}
    assert [(box.first, box.last, box.label) for box in tracks["front & 1-2"].boxes] == [(2, 3, "spin")]
    assert tracks["front & 1-2"].group == 0
    assert tracks["left"].group == -1
