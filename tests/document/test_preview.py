"""The preview: measures of a score simulated aside are those of a real run, also after an edit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.document.preview import MAX_LOOK, PreviewEngine, first_change, preview_values
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch import Patch
from live.show.patch.section_score import ScoreSection

TEXT = """name = "x"
reserve = 0
[clock]
bpm = 120
[[group]]
name = "ember"
dancers = 3
steps = ["groove x2", "turn"]
centre = [-2.5, 0.0]
size = [2.0, 2.0]
[[group]]
name = "tide"
dancers = 3
steps = ["side step"]
centre = [2.5, 0.0]
size = [2.0, 2.0]
[[segment]]
measure = 2
measures = 3
group = "ember"
formation = "line"
[[segment]]
measure = 8
measures = 1
group = "tide"
formation = "circle"
"""


@pytest.fixture
def loaded(tmp_path: Path) -> LoadedShow:
    path = tmp_path / "show.toml"
    path.write_text(TEXT)
    return load_show(path)


def changed(loaded: LoadedShow, formation: str) -> Patch:
    first, second = loaded.patch.segment
    return loaded.patch.model_copy(update={"segment": (first, second.model_copy(update={"formation": formation}))})


def danced(loaded: LoadedShow, measure: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places and nodes of a show that is run from its beginning, at the same tick as the preview's sample."""
    show = loaded.start()
    tick = 0
    engine = PreviewEngine(loaded)
    wanted = engine.at(measure).tick
    while tick < wanted:
        tick += 1
        show.tick(tick * TICK)
    return show.dancers.drawn_hips.copy(), show.dancers.node.copy()


@pytest.mark.long
@pytest.mark.parametrize(
    "measure", [pytest.param(0.5, marks=pytest.mark.long), 3.25, pytest.param(9.0, marks=pytest.mark.long)]
)
def test_it_shows_what_the_show_dances(loaded: LoadedShow, measure: float) -> None:
    there = PreviewEngine(loaded).at(measure)
    place, node = danced(loaded, measure)
    assert np.array_equal(there.place, place)
    assert np.array_equal(there.node, node)
    assert abs(there.measure - measure) < 0.05


@pytest.mark.long
def test_measures_can_be_asked_for_in_any_order(loaded: LoadedShow) -> None:
    one, other = PreviewEngine(loaded), PreviewEngine(loaded)
    for measure in (9.5, 1.5, 6.25, 0.0):
        assert np.array_equal(one.at(measure).place, other.at(measure).place)
    assert one.measures >= 9


@pytest.mark.long
def test_a_picture_of_any_moment_is_that_of_the_run(loaded: LoadedShow) -> None:
    engine = PreviewEngine(loaded)
    engine.run_to(8.0)
    view = engine.view_at(5.5)
    place, _ = danced(loaded, 5.5)
    assert view.measure == 5
    assert np.abs(view.joint_position[:, 0, ::2] - place).max() < 0.1  # a few ticks apart
    assert np.array_equal(view.joint_position, engine.view_at(5.5).joint_position)


@pytest.mark.long
def test_an_edit_keeps_the_measures_before_it_and_gives_those_of_a_fresh_run(loaded: LoadedShow) -> None:
    engine = PreviewEngine(loaded)
    engine.run_to(10.0)
    edited = changed(loaded, "star:5")
    engine.set_patch(edited)
    assert 5 <= engine.measures < 8
    fresh = PreviewEngine(replace(loaded, patch=edited))
    for measure in (2.5, 7.5, 9.5):
        assert np.array_equal(engine.at(measure).place, fresh.at(measure).place), measure
        assert np.array_equal(engine.at(measure).node, fresh.at(measure).node), measure
    assert not np.array_equal(engine.at(9.5).place, PreviewEngine(loaded).at(9.5).place)
    assert engine.view_at(3.5).measure == 3  # from a snapshot of the patch before
    engine.set_patch(loaded.patch.model_copy(update={"seed": 5}))
    assert engine.measures == 0
    with pytest.raises(PersonError):
        engine.set_patch(changed(loaded, "nonsense"))


def test_the_first_change_is_found_and_anything_else_begins_anew(loaded: LoadedShow) -> None:
    patch = loaded.patch
    assert first_change(patch, patch) is None
    assert first_change(patch, changed(loaded, "grid")) == 8
    assert first_change(patch, patch.model_copy(update={"segment": patch.segment[1:]})) == 2
    assert first_change(patch, patch.model_copy(update={"seed": 9})) is None
    looped = patch.model_copy(update={"loop_measures": 16})
    assert first_change(looped, looped.model_copy(update={"segment": patch.segment[1:]})) == 2
    sections = (ScoreSection(name="a", measures=4, repeat=2), ScoreSection(name="b", measures=8))
    there = tuple(one.model_copy(update={"section": "b", "measure": 3}) for one in patch.segment)
    parts = patch.model_copy(update={"section": sections, "segment": there})
    assert first_change(parts, parts.model_copy(update={"segment": there[1:]})) == 11
    drawn = patch.model_copy(update={"formation": ({"name": "star", "shape": "circle"},)})
    assert first_change(patch, drawn) == MAX_LOOK  # nobody is in it
    used = drawn.model_copy(
        update={"segment": (patch.segment[0], patch.segment[1].model_copy(update={"formation": "star"}))}
    )
    assert first_change(patch, used) == 8


@pytest.mark.long
def test_it_tells_who_meets_and_whose_way_is_too_long(loaded: LoadedShow) -> None:
    segment = loaded.patch.segment[1]
    right, left = (segment.model_copy(update={"formation": None, "group": group, "path": path}) for group, path in (
        ("ember", ((-2.5, 0.0), (2.5, 5.0))), ("tide", ((2.5, 0.0), (2.5, 5.0))),  # to the same places
    ))  # fmt: skip
    far = loaded.patch.model_copy(update={"segment": (right, left)})
    values = preview_values(PreviewEngine(replace(loaded, patch=far)), 8, 9)
    assert {one["dancer"] for one in values["too_far"]} == {1, 2, 3, 4, 5, 6}
    assert all(one["measure"] == 8 and one["distance"] > one["reach"] for one in values["too_far"])
    pairs = {tuple(one["dancers"]) for one in values["meetings"]}
    assert any(a <= 3 < b for a, b in pairs)
    assert [one["measure"] for one in values["measures"]] == [8, 9, 10]
    assert len(values["ways"]) == 6
    assert any("m to go" in note for note in values["notes"])
    with pytest.raises(PersonError, match="the first one comes last"):
        preview_values(PreviewEngine(loaded), 5, 4)


@pytest.mark.long
def test_groups_of_the_same_measures_are_planned_together(loaded: LoadedShow) -> None:
    """Two groups that change sides, as they are edited: nobody meets, and the ways are bent (T147)."""
    segment = loaded.patch.segment[1]
    swapped = tuple(
        segment.model_copy(update={"group": group, "formation": "square", "measures": 6, "mirror": mirror})
        for group, mirror in (("ember", None), ("tide", True))
    )
    square = {"name": "square", "shape": "places", "points": [[2.5, -1.0], [2.5, 0.1], [2.5, 1.2]]}
    together = loaded.patch.model_copy(update={"segment": swapped, "formation": (square,)})
    engine = PreviewEngine(replace(loaded, patch=together))
    plan = engine.plan(8, 13)
    assert plan.too_near == ()
    assert np.abs(plan.ways[0, :3, 0] - plan.ways[-1, :3, 0]).min() > 3.0  # they have changed sides
    apart = np.hypot(*np.moveaxis(plan.ways[:, :3, None] - plan.ways[:, None, 3:], -1, 0))
    assert apart.min() > 0.69
    assert preview_values(engine, 8, 13)["meetings"] == []


def test_the_ways_of_an_edited_segment_are_planned_without_a_run(loaded: LoadedShow) -> None:
    engine = PreviewEngine(loaded)
    before = engine.plan(8, 8)
    after = engine.plan(8, 8, changed(loaded, "line"))
    assert before.ways.shape == after.ways.shape
    assert np.array_equal(before.ways[:, :3], after.ways[:, :3])  # the other group
    assert np.abs(before.ways[-1, 3:] - after.ways[-1, 3:]).max() > 0.3
    assert engine.patch is loaded.patch


DIVIDED = """
[[sequence]]
measure = 3
group = "1-2"
steps = ["turn x4"]
[[sequence]]
measure = 4
group = "{}"
steps = ["side step"]
"""


@pytest.mark.long
def test_division_is_a_tree_over_measures_also_after_an_edit(tmp_path: Path) -> None:
    path = tmp_path / "show.toml"
    path.write_text(TEXT + DIVIDED.format(2))
    loaded = load_show(path)
    engine = PreviewEngine(loaded)

    def tree(engine: PreviewEngine) -> list[tuple[object, ...]]:
        (ember, _) = preview_values(engine, 1, 8)["division"]["steps"]
        assert (ember["words"], ember["dancers"], ember["from"], ember["to"]) == ("ember", [1, 2, 3], 1, 8)
        return [
            (part["words"], part["from"], part["to"], [(one["words"], one["from"], one["to"]) for one in part["parts"]])
            for part in ember["parts"]
        ]

    assert tree(engine) == [("1-2", 3, 6, [("2", 4, 4)])]
    path.write_text(TEXT + DIVIDED.format(3))
    edited = load_show(path)
    beside = engine.branch(edited.patch)
    assert tree(beside) == tree(PreviewEngine(edited)) == [("1-2", 3, 6, []), ("3", 4, 4, [])]
    assert tree(engine) == [("1-2", 3, 6, [("2", 4, 4)])]


@pytest.mark.long
def test_other_music_of_the_same_tempo_leaves_the_preview_as_it_is(loaded: LoadedShow) -> None:
    engine = PreviewEngine(loaded)
    engine.run_to(4.0)
    for values, measures in (({"file": "new.ogg"}, 4), ({"bpm": 90.0}, 0)):
        music = loaded.patch.music.model_copy(update=values)
        engine.set_patch(loaded.patch.model_copy(update={"music": music}))
        assert engine.measures == measures
        assert engine.patch.music == music
    assert PreviewEngine(loaded).at(2.0).tick < engine.at(2.0).tick
