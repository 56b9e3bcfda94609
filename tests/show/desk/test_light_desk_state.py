"""What the desk holds goes through snapshots and an edited patch as everything else does."""

from pathlib import Path

import pytest

from live.clock.ticks import TICK
from live.show.assembly import swap_patch
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import Snapshotter, restore
from tests.places import ROOT
from tests.show.desk.desk_show import DESK, Hands
from tests.show.made_show import GRAPH, PATCH

TEXT = PATCH + DESK
LOADED = LoadedShow(Path("test.toml"), parse_patch(TEXT, "test.toml"), GRAPH)


@pytest.mark.parametrize("beats", [1.3, 3.0, 5.5])
def test_a_show_restored_within_fades_and_count_ins_goes_on_bit_by_bit(beats):
    hands = Hands().run(5)
    hands.say("/dance/scene/store", "mine")
    hands.say("/dance/light/haze", 0.5, 2)
    hands.say("/dance/go")
    hands.say("/dance/cue", "solo")
    hands.say("/dance/motion/head", 0.5)
    hands.run(beats)
    source = Snapshotter(hands.show)
    while (taken := source.capture(hands.ticks)) is None:
        hands.run(ticks=1)
    data = taken.seal()
    there = Hands()
    there.show, there.ticks = restore(LOADED, data), hands.ticks
    assert len(data) < 150_000
    for other in (hands, there):
        other.run(6)
        other.say("/dance/undo")
        other.say("/dance/scene", "mine", 1)
        other.run(9)
    assert there.show.state_hash() == hands.show.state_hash()
    assert there.cues == hands.cues
    assert hands.ticks * TICK > 8.0


def test_a_patch_with_scenes_and_cues_comes_back_from_its_journal():
    patch = LOADED.patch
    assert Patch.model_validate_json(patch.model_dump_json()) == patch


def test_an_edited_patch_fades_to_its_light_and_leaves_what_was_set_by_hand():
    hands = Hands().run(4)
    hands.say("/dance/light/level", 0.5)
    hands.run(1)
    fresh = Hands("[look]\nhaze = 0.2\n[[scene]]\nname = 'new'\n")
    hands.desk.parameters.apply_patch(fresh.desk.parameters)
    hands.desk.scenes.apply_patch(fresh.desk.scenes)
    hands.run(5)
    assert hands.value("/dance/light/haze") == 0.2
    assert hands.value("/dance/light/level") == 0.5
    assert hands.desk.scenes.names == ["start", "new"]
    hands.say("/dance/panic")
    hands.run(3)
    assert hands.value("/dance/light/haze") == 0.2
    assert hands.value("/dance/light/level") == 1.0


def test_a_running_show_takes_the_cues_and_scenes_of_an_edited_patch():
    hands = Hands().run(5)
    hands.say("/dance/standby", "up")
    hands.say("/dance/motion/head", 0.5)
    edited = parse_patch(TEXT.replace("0.25", "0.35").replace('text = "lights down"', 'text = "x"'), "test.toml")
    show = hands.show
    swap_patch(show, show.make_show(edited, show.graph), show.patch, edited)
    assert show.patch is edited
    assert hands.cues["standby"] == "up"
    hands.say("/dance/undo")
    assert hands.value("/dance/motion/head") == 0.0
    hands.say("/dance/cue", "dim")
    hands.run(14)
    assert hands.value("/dance/light/level") == 0.35


def test_the_example_of_the_documents_is_a_patch_and_its_cues_happen():
    page = (ROOT / "docs" / "cues.md").read_text(encoding="utf-8")
    blocks = [block.split("```")[0] for block in page.split("```toml\n")[1:]]
    text = next(block for block in blocks if "[[cue]]" in block).replace('"groove"', '"sway"')
    hands = Hands(text).run(1)
    for beats in (9, 48):  # the third comes by itself
        hands.say("/dance/go")
        hands.run(beats)
    assert hands.cues["fired"] == 3
    assert hands.show.refusals.count == 0, hands.words
    assert hands.value("/dance/light/level") == 0.6
