"""A running show's stage and set are edited: they act from the next free measure, replay, restore and can be undone."""

from pathlib import Path
from typing import Any

import pytest

from live.clock.ticks import TICK
from live.control.events.groups import Enter, SetStage
from live.show.journal.journal import read_journal
from live.show.journal.replay import load_journal, run_from, start_before
from live.show.patch.patch_reader import read_patch
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.render_scene import set_items
from tests.app.services.test_document_service import EditedShow
from tests.fixtures.mostly_long import mostly_long
from tests.show.patch.edited_night import write_patch_folder

PATCH = """# A stage.
name = "staged"
steps = "moves"
reserve = 3
[clock]
bpm = 120
[stage]
width = 12.0     # metres
depth = 8.0

[[gate]]
name = "wing"
at = [-6, 0]
[[gate]]
name = "door"
at = [6, 0]
width = 2.0

[[obstacle]]
name = "tree"
at = [3.5, -2.5]

[[item]]
name = "podium"
form = "steps"
at = [0, -3.4]
size = [6.0, 1.2, 1.6]

[[group]]
name = "ember"
dancers = 3
steps = ["groove"]
[[group]]
name = "tide"
dancers = 3
steps = ["side step"]

[[segment]]
measure = 2
measures = 2
formation = "line"
group = "ember"

[[segment]]
measure = 30
measures = 2
formation = "circle"

[[at]]
measure = 40
call = "/dance/enter"
values = [1, "ember", "door"]
"""


@pytest.fixture
def night(tmp_path: Path) -> EditedShow:
    return EditedShow(write_patch_folder(tmp_path, PATCH))


def edit(do: str, *at: str | int, value: Any = None) -> dict[str, Any]:
    return {"do": do, "at": list(at), "value": value}


def surroundings(night: EditedShow) -> dict[str, list[float]]:
    around = night.show.motion.surroundings
    walls = {name: around.walls[row].tolist() for row, name in enumerate(around.wall_names)}
    return walls | {name: around.obstacles[row, :3].tolist() for row, name in enumerate(around.obstacle_names)}


def gates(night: EditedShow) -> list[tuple[str, float, float, float]]:
    return [(gate.name, gate.x, gate.z, gate.width) for gate in night.show.motion.entrances.gates]


def stage(night: EditedShow) -> list[float]:
    return (2.0 * night.show.motion.stage_area.half).tolist()


EDITS = {
    "width": edit("set", "stage", "width", value=14),
    "both": edit("resize", "stage", value={"width": 13, "depth": 9}),
    "gate moved": edit("move", "gate", "wing", value={"at": [0, -4]}),
    "gate wider": edit("resize", "gate", 2, value=3),
    "gate new": edit("insert", "gate", value={"name": "back", "at": [0, -4]}),
    "gate gone": edit("delete", "gate", "wing"),
    "gate named": edit("rename", "gate", "door", value="window"),
    "obstacle moved": edit("move", "obstacle", "tree", value=[4, -3]),
    "obstacle larger": edit("resize", "obstacle", "tree", value=0.8),
    "obstacle copied": edit("copy", "obstacle", 1, value={"at": [-5, 3]}),
    "obstacle gone": edit("delete", "obstacle", "tree"),
    "obstacle named": edit("rename", "obstacle", "tree", value="oak"),
    "wall": edit("insert", "obstacle", value={"name": "wall", "at": [5, -3.5], "wall_to": [5, 3.5]}),
    "item moved": edit("move", "item", "podium", value=[1, -3]),
    "item higher": edit("set", "item", 1, "size", 2, value=2.0),
    "item new": edit("insert", "item", value={"form": "cylinder", "at": [4, -3]}),
    "item gone": edit("delete", "item", "podium"),
}


SHORT = ("both", "gate named", "obstacle moved", "item gone")
"""Edits of the short run of tests: one of each kind."""


@mostly_long("name", [pytest.param(name, marks=[pytest.mark.long] * (name not in SHORT)) for name in EDITS], quick=[])
def test_each_edit_acts_undoes_replays_and_resumes_like_a_fresh_show(night: EditedShow, name: str) -> None:
    night.run(4.5)
    before = (stage(night), gates(night), surroundings(night), set_items(night.show.patch))
    (answer,) = night.send(EDITS[name])
    assert {"revision", "waits"} & set(answer) == {"revision"}, answer
    night.run(2.0)
    wanted = read_patch(night.path)
    assert night.show.patch == wanted
    fresh = EditedShow(write_patch_folder(_folder(night, "fresh"), night.path.read_text()))
    after = (stage(night), gates(night), surroundings(night), set_items(night.show.patch))
    assert after == (stage(fresh), gates(fresh), surroundings(fresh), set_items(fresh.show.patch))
    assert after != before
    night.run(2.0)
    resumed, tick = restored_in(night, fresh)
    for _ in range(20):
        night.run(0.1)
        while tick < night.engine.ticks.index:
            tick += 1
            resumed.tick(tick * TICK)
        assert resumed.state_hash() == night.show.state_hash()
    assert "revision" in night.undo()
    assert night.path.read_text() == PATCH
    night.run(4.0)
    assert (stage(night), gates(night), surroundings(night), set_items(night.show.patch)) == before
    assert night.replay_differences() == ()


def _folder(night: EditedShow, name: str) -> Path:
    folder = night.path.parent / name
    folder.mkdir()
    return folder


def restored_in(night: EditedShow, fresh: EditedShow) -> tuple[Show, int]:
    """Return the night's show in its present state, made of the parts of a show of the edited patch, and its tick."""
    source = Snapshotter(night.show)
    while (taken := source.capture(night.engine.ticks.index)) is None:
        night.run(0.02)
    return restore(fresh.loaded, taken.seal()), night.engine.ticks.index


def faults(night: EditedShow, *edits: dict[str, Any]) -> list[tuple[str, int, float | None, str]]:
    """Return field, line, measure and words of all faults of the last edit."""
    return [(one["field"], one["line"], one["measure"], one["what"]) for one in night.send(*edits)[-1]["refused"]]


def line_of(words: str, nth: int = 1) -> int:
    lines = [number for number, line in enumerate(PATCH.splitlines(), start=1) if line.startswith(words)]
    return lines[nth - 1]


@pytest.mark.long
def test_a_stage_that_strands_dancers_is_refused_with_all_of_them(night: EditedShow) -> None:
    """The circle of 8 x 5 m has six places, 2.5 m around the middle; three stand on the line of 8 m."""
    night.run(1.0)
    assert faults(night, edit("resize", "stage", value=[4.0, 4.0])) == [
        ("segment.1.formation", line_of("formation"), 2,
         "2 dancers of 'line' would stand outside the stage of 4 x 4 m"),
        ("segment.2.formation", line_of("formation", 2), 30,
         "6 dancers of 'circle' would stand outside the stage of 4 x 4 m"),
    ]  # fmt: skip
    answer = night.send(edit("set", "stage", "depth", value=4.5))[0]["refused"]
    assert [one["remedy"] for one in answer] == ["a stage of at least 4.4 x 5 m, or a smaller formation"]
    assert faults(night, edit("resize", "stage", value=[2.0, 2.0]))[0] == (
        "stage", line_of("[stage]"), None, "6 dancers have no room on 2 x 2 m",
    )  # fmt: skip
    assert night.path.read_text() == PATCH
    night.run(3.0)
    assert stage(night) == [12.0, 8.0]


def test_an_obstacle_where_dancers_stand_is_refused(night: EditedShow) -> None:
    night.run(1.0)
    found = faults(night, edit("move", "obstacle", "tree", value=[-4, 0]))
    assert ("segment.1.formation", line_of("formation"), 2, "a dancer of 'line' would stand in 'tree'") in found
    wall = {"name": "wall", "at": [-6, 0.2], "wall_to": [6, 0.2]}
    found = faults(night, edit("insert", "obstacle", value=wall))
    assert found == [
        ("segment.1.formation", line_of("formation"), 2, "3 dancers of 'line' would stand in 'wall'"),
        ("group.1.formation", line_of("[[group]]"), None, "2 dancers of 'ember' would begin in 'wall'"),
        ("group.2.formation", line_of("[[group]]", 2), None, "2 dancers of 'tide' would begin in 'wall'"),
    ]
    assert night.path.read_text() == PATCH


@pytest.mark.long
def test_an_entrance_in_use_cannot_be_removed_and_its_new_name_is_used(night: EditedShow) -> None:
    night.run(1.0)
    (fault,) = night.send(edit("delete", "gate", "door"))[0]["refused"]
    assert (fault["field"], fault["line"], fault["measure"]) == ("at.1.values", line_of("values"), 40)
    assert fault["what"] == "call /dance/enter: no gate is called 'door' (there are: wing)"
    night.send(edit("rename", "gate", "door", value="window"))
    assert 'values = [1, "ember", "window"]' in night.path.read_text()


@pytest.mark.long
def test_an_undo_gives_back_what_was_odd_before(tmp_path: Path) -> None:
    """The circle stands around the tree from the beginning: this is no fault of an edit, nor of its undo."""
    text = PATCH.replace("at = [3.5, -2.5]", "at = [0, 2.5]")
    night = EditedShow(write_patch_folder(tmp_path, text))
    night.run(1.0)
    assert "revision" in night.send(edit("delete", "obstacle", "tree"))[0]
    assert "refused" in night.send(edit("insert", "obstacle", value={"name": "oak", "at": [0, 2.5]}))[0]
    assert "revision" in night.undo()
    assert "revision" in night.send(edit("set", "stage", "width", value=13))[0]


@pytest.mark.long
def test_a_wall_moves_whole_and_an_item_keeps_its_height(night: EditedShow) -> None:
    night.send(edit("insert", "obstacle", value={"name": "wall", "at": [5, -3], "wall_to": [5, 3]}))
    night.send(edit("move", "obstacle", "wall", value=[5.5, -2.5]), edit("resize", "item", 1, value=3.0))
    night.send(edit("set", "item", 1, "name", value=None), edit("move", "item", 1, value=[0.5, -3.0]))
    patch = read_patch(night.path)
    assert (patch.obstacle[1].at, patch.obstacle[1].wall_to) == ((5.5, -2.5), (5.5, 3.5))
    assert (patch.item[0].size, patch.item[0].at, patch.item[0].name) == ((3.0, 1.2, 3.0), (0.5, -3.0), None)
    assert "refused" in night.send(edit("move", "obstacle", "wall", value=[1, "left"]))[0]
    assert "refused" in night.send(edit("insert", "item", value={"at": [0, 0], "name": ""}))[0]


@pytest.mark.long
def test_who_is_called_enters_through_the_nearest_entrance_left(night: EditedShow) -> None:
    """Called through the wing on the left, which is removed before the line."""
    night.run(2.5)
    night.inbox.put(Enter(time=2.5, source="test", count=1.0, gate="wing"))
    night.send(edit("delete", "gate", "wing"))
    night.run(2.0)
    entered = night.show.motion.state.position[6]
    assert entered[0] > 3.0
    assert night.replay_differences() == ()


@pytest.mark.long
def test_a_size_set_live_gives_way_to_an_edit(night: EditedShow) -> None:
    night.run(1.0)
    night.inbox.put(SetStage(time=1.0, source="test", width=9.0, depth=7.0))
    night.run(1.0)
    night.send(edit("set", "obstacle", "tree", "radius", value=0.6))
    night.run(3.0)
    assert stage(night) == [9.0, 7.0]  # the edit of another table leaves it
    night.send(edit("set", "stage", "width", value=20))
    night.run(3.0)
    assert stage(night) == [20.0, 8.0]
    night.inbox.put(SetStage(time=7.0, source="test", width=23.0, depth=7.0))  # 4 m more than the new size is possible
    night.run(1.0)
    assert stage(night) == [23.0, 7.0]
    assert night.replay_differences() == ()


@pytest.mark.long
def test_dancers_walk_into_a_smaller_stage(tmp_path: Path) -> None:
    score = PATCH[PATCH.index("[[segment]]") : PATCH.index("[[at]]")]
    night = EditedShow(write_patch_folder(tmp_path, PATCH.replace(score, "")))
    night.run(2.5)
    assert abs(night.show.state.position[:6, 0]).max() > 2.5
    night.send(edit("resize", "stage", value=[4.0, 4.0]))
    night.run(20.0)
    assert abs(night.show.state.position[:6]).max() < 2.01
    assert night.show.motion.stage_area.border.tolist() == [2.0, 2.0]


@pytest.mark.long
def test_a_new_name_of_an_obstacle_or_gate_is_used_in_every_call(tmp_path: Path) -> None:
    calls = """
[[at]]
measure = 50
call = "/dance/obstacle"
values = ["tree", 4, -3, 0.5]
[[cue]]
name = "clear"
calls = [["/dance/obstacle/remove", "tree"], ["/dance/leave", "ember", "door"], ["/dance/performer", "tree", 0, 0]]
[[midi.map]]
note = 60
control = "/dance/obstacle/remove"
values = { name = "tree" }
"""
    night = EditedShow(write_patch_folder(tmp_path, PATCH + calls))
    answers = night.send(
        edit("rename", "obstacle", "tree", value="oak"),
        edit("rename", "gate", "door", value="window"),
        edit("rename", "item", "podium", value="stairs"),
    )
    assert all("revision" in answer for answer in answers), answers
    expected = (PATCH + calls).replace('"tree"', '"oak"').replace('"door"', '"window"').replace('"podium"', '"stairs"')
    expected = expected.replace('["/dance/performer", "oak"', '["/dance/performer", "tree"')  # a person, no obstacle
    assert night.path.read_text() == expected


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["both", *(pytest.param(f"{one} gone", marks=pytest.mark.long) for one in ("gate", "obstacle"))]
)
def test_another_engine_goes_on_after_the_edit(night: EditedShow, name: str) -> None:
    """From a snapshot in the journal, as when the first engine has died."""
    night.run(2.5)
    night.send(EDITS[name])
    night.run(8.0)
    night.writer.close(night.engine.ticks.index)
    journal, problems = read_journal(night.journal), list[str]()
    loaded = load_journal(journal)
    start = start_before(journal, loaded, 5, problems)
    assert start.show.patch == read_patch(night.path)
    result = run_from(start, journal, loaded=loaded)
    assert (problems, result.differences) == ([], ())
    assert result.measures >= 1
