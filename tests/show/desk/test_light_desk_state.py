"""Tests of desk state in snapshots, in the journal and across patch edits."""

from pathlib import Path

import pytest

from live.clock.ticks import TICK
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import Snapshotter, restore
from tests.fixtures.mostly_long import mostly_long
from tests.places import ROOT
from tests.show.desk.desk_show import DESK, DeskSession
from tests.show.made_show import GRAPH, PATCH

TEXT = PATCH + DESK
LOADED = LoadedShow(Path("test.toml"), parse_patch(TEXT, "test.toml"), GRAPH)


@mostly_long("beats", [1.3, 3.0, 5.5], quick=[0])
def test_show_restored_within_fade_and_count_in_continues_bit_identically(beats):
    session = DeskSession().run(5)
    session.say("/dance/scene/store", "mine")
    session.say("/dance/light/haze", 0.5, 2)
    session.say("/dance/go")
    session.say("/dance/cue", "solo")
    session.say("/dance/motion/head", 0.5)
    session.run(beats)
    source = Snapshotter(session.show)
    while (taken := source.capture(session.ticks)) is None:
        session.run(ticks=1)
    data = taken.seal()
    there = DeskSession()
    there.show, there.ticks = restore(LOADED, data), session.ticks
    assert len(data) < 150_000
    for other in (session, there):
        other.run(6)
        other.say("/dance/undo")
        other.say("/dance/scene", "mine", 1)
        other.run(9)
    assert there.show.state_hash() == session.show.state_hash()
    assert there.cues == session.cues
    assert session.ticks * TICK > 8.0


def test_patch_with_scenes_and_cues_survives_json_round_trip():
    patch = LOADED.patch
    assert Patch.model_validate_json(patch.model_dump_json()) == patch


def test_edited_patch_fades_to_new_light_and_keeps_manual_values():
    session = DeskSession().run(4)
    session.say("/dance/light/level", 0.5)
    session.run(1)
    fresh = DeskSession("[look]\nhaze = 0.2\n[[scene]]\nname = 'new'\n")
    session.desk.parameters.apply_patch(fresh.desk.parameters)
    session.desk.scenes.apply_patch(fresh.desk.scenes)
    session.run(5)
    assert session.value("/dance/light/haze") == 0.2
    assert session.value("/dance/light/level") == 0.5
    assert session.desk.scenes.names == ["start", "new"]
    session.say("/dance/panic")
    session.run(3)
    assert session.value("/dance/light/haze") == 0.2
    assert session.value("/dance/light/level") == 1.0


@pytest.mark.long
def test_running_show_applies_cues_and_scenes_of_edited_patch():
    session = DeskSession().run(5)
    session.say("/dance/standby", "up")
    session.say("/dance/motion/head", 0.5)
    edited = parse_patch(TEXT.replace("0.25", "0.35").replace('text = "lights down"', 'text = "x"'), "test.toml")
    show = session.show
    show.hot_swap.adopt(show.hot_swap.make_show(edited, show.graph))
    assert show.patch is edited
    assert session.cues["standby"] == "up"
    session.say("/dance/undo")
    assert session.value("/dance/motion/head") == 0.0
    session.say("/dance/cue", "dim")
    session.run(14)
    assert session.value("/dance/light/level") == 0.35


def test_documented_example_is_valid_and_its_cues_fire():
    page = (ROOT / "docs/how-to/picture/cues.md").read_text(encoding="utf-8")
    blocks = [block.split("```")[0] for block in page.split("```toml\n")[1:]]
    text = next(block for block in blocks if "[[cue]]" in block).replace('"groove"', '"sway"')
    session = DeskSession(text).run(1)
    for beats in (9, 48):  # the third comes by itself
        session.say("/dance/go")
        session.run(beats)
    assert session.cues["fired"] == 3
    assert session.show.refusals.count == 0, session.words
    assert session.value("/dance/light/level") == 0.6
