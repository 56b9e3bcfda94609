"""The last hand on the picture: fade in beats, freeze, and who may flash."""

import numpy as np
import pytest

from live.control.events.event_json import event_from_json, event_to_json
from live.control.registry.registry import REGISTRY
from live.show.state.snapshot import Snapshotter, restore
from tests.show.desk.desk_show import Hands
from tests.show.desk.test_light_desk_state import LOADED


def seen(hands):
    view = hands.show.view()
    hands.show.fill(view, hands.show.time)
    return view


def brightness(hands):
    return seen(hands).brightness


def test_the_picture_fades_in_beats_and_comes_back():
    hands = Hands()
    hands.say("/dance/output/fade", 0.0, 8.0)
    hands.run(4)
    assert brightness(hands) == pytest.approx(0.5, abs=0.02)
    assert hands.desk.status_lines(hands.show.danced_beats)[0] == "faded to 50%"
    hands.run(4.1)
    assert brightness(hands) == 0.0
    hands.run(40)
    assert brightness(hands) == 0.0
    hands.say("/dance/output/fade", 0.6, 0.0)
    hands.run(ticks=1)
    assert 0.0 < brightness(hands) < 0.6  # never as a flash
    hands.run(0.25)
    assert brightness(hands) == pytest.approx(0.6)


def test_beats_are_those_of_the_music():
    slow, fast = Hands(), Hands()
    for hands, tempo in ((slow, 60.0), (fast, 180.0)):
        hands.say("/dance/clock/tempo", tempo)
        hands.run(ticks=1)
        hands.say("/dance/output/fade", 0.0, 6.0)
        hands.run(ticks=64)
    assert slow.desk.master.level > 0.9
    assert fast.desk.master.level == pytest.approx(0.5, abs=0.02)


def test_neither_scene_nor_panic_nor_undo_brings_the_light_back():
    hands = Hands()
    hands.say("/dance/output/fade", 0.0, 0.0)
    hands.run(1)
    for call in (("/dance/scene", "start"), ("/dance/panic",), ("/dance/undo",), ("/dance/light/level", 1.0)):
        hands.say(*call)
        hands.run(4)
        assert brightness(hands) == 0.0


def test_a_blackout_and_a_fade_are_both_needed_for_light():
    hands = Hands()
    hands.say("/dance/output/fade", 0.5, 0.0)
    hands.say("/dance/blackout", 1)
    hands.run(4)
    assert brightness(hands) < 0.01
    hands.say("/dance/blackout", 0)
    hands.run(4)
    assert brightness(hands) == pytest.approx(0.5, abs=0.01)


def test_a_frozen_picture_stands_still_while_the_dance_goes_on():
    hands = Hands()
    hands.run(3)
    view = seen(hands)
    before = view.joint_position.copy(), view.beat, view.picture.copy()
    hands.say("/dance/output/freeze", 1)
    hands.say("/dance/light/level", 0.3)
    hands.run(5)
    hands.show.fill(view, hands.show.time)
    np.testing.assert_array_equal(view.joint_position, before[0])
    assert view.beat == before[1]
    np.testing.assert_array_equal(view.picture, before[2])
    hands.say("/dance/blackout", 1)
    hands.run(4)
    hands.show.fill(view, hands.show.time)
    assert view.brightness < 0.01
    assert view.beat == before[1]
    hands.say("/dance/output/freeze", 0)
    hands.show.fill(view, hands.show.time)
    assert view.beat > before[1] + 8.9
    assert np.abs(view.joint_position - before[0]).max() > 0.01


def test_freezing_changes_nothing_of_the_dance():
    plain, frozen = Hands(), Hands()
    frozen.say("/dance/output/freeze", 1)
    frozen.say("/dance/output/flashes", 1)
    for hands in (plain, frozen):
        hands.run(9)
    assert frozen.show.state_hash() == plain.show.state_hash()
    assert seen(frozen).flash_limit_lifted
    assert not seen(plain).flash_limit_lifted


def kept(hands):
    """A snapshot, as soon as one can be taken."""
    source = Snapshotter(hands.show)
    while (taken := source.capture(hands.ticks)) is None:
        hands.run(ticks=1)
    return taken.seal()


def test_who_goes_on_with_a_frozen_show_sees_the_picture_that_stood():
    """As another engine does after this one ended: with a show that has run along, or with one out of a snapshot."""
    hands = Hands()
    hands.run(3)
    before = seen(hands)
    hands.say("/dance/output/freeze", 1)
    hands.say("/dance/output/card", "Left", "grid")
    hands.say("/dance/output/card", "*", "name")
    hands.say("/dance/output/card", "right", "off")
    hands.say("/dance/output/fade", 0.5, 0.0)
    hands.run(9)
    hands.say("/dance/output/freeze", 1)  # frozen is frozen
    for show in (hands.show, restore(LOADED, kept(hands))):
        view = show.view()
        show.fill(view, show.time)
        assert view.beat == before.beat
        np.testing.assert_array_equal(view.joint_position, before.joint_position)
        np.testing.assert_array_equal(view.picture, before.picture)
        assert view.brightness == pytest.approx(0.5)
        assert show.desk.master.cards == {"*": "name", "right": "off"}
    hands.say("/dance/output/freeze", 0)
    assert seen(hands).beat > before.beat + 8.9


def test_cards_that_are_taken_away_are_forgotten():
    hands = Hands()
    for number in range(100):
        hands.say("/dance/output/card", f"output {number}", "grid")
    assert len(hands.desk.master.cards) == 64
    hands.say("/dance/output/card", "output 99", "off")
    assert len(hands.desk.master.cards) == 63
    hands.say("/dance/output/card", "*", "off")
    assert hands.desk.master.cards == {}


def test_what_the_status_tells():
    hands = Hands()
    assert hands.desk.facts(0.0)["master"] == {"level": 1.0, "frozen": False, "flashes": False}
    hands.say("/dance/output/freeze", 1)
    hands.say("/dance/output/flashes", 1)
    assert hands.desk.status_lines(hands.show.danced_beats)[:2] == (
        "FROZEN: the picture stands still", "flashes are not limited",
    )  # fmt: skip


@pytest.mark.parametrize(
    "call",
    [
        ("/dance/output/fade", (0.5, 3.0)), ("/dance/output/freeze", (1,)), ("/dance/output/flashes", (0,)),
        ("/dance/output/card", ("left", "focus")),
    ],
)  # fmt: skip
def test_the_journal_keeps_them(call):
    event = REGISTRY.call(*call, 1.5, "osc")
    assert event_from_json(event_to_json(event)) == event
