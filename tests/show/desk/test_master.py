"""Tests of the output master: fade in beats, freeze, test cards and flash limit."""

import numpy as np
import pytest

from live.control.events.event_json import event_from_json, event_to_json
from live.control.registry.registry import REGISTRY
from live.show.state.snapshot import Snapshotter, restore
from tests.show.desk.desk_show import DeskSession
from tests.show.desk.test_light_desk_state import LOADED


def current_view(session):
    view = session.show.view()
    session.show.fill(view, session.show.time)
    return view


def brightness(session):
    return current_view(session).brightness


def test_picture_fades_over_beats_and_returns_smoothly():
    session = DeskSession()
    session.say("/dance/output/fade", 0.0, 8.0)
    session.run(4)
    assert brightness(session) == pytest.approx(0.5, abs=0.02)
    assert session.desk.status_lines(session.show.danced_beats)[0] == "faded to 50%"
    session.run(4.1)
    assert brightness(session) == 0.0
    session.run(40)
    assert brightness(session) == 0.0
    session.say("/dance/output/fade", 0.6, 0.0)
    session.run(ticks=1)
    assert 0.0 < brightness(session) < 0.6  # never as a flash
    session.run(0.25)
    assert brightness(session) == pytest.approx(0.6)


def test_fade_duration_follows_tempo():
    slow, fast = DeskSession(), DeskSession()
    for session, tempo in ((slow, 60.0), (fast, 180.0)):
        session.say("/dance/clock/tempo", tempo)
        session.run(ticks=1)
        session.say("/dance/output/fade", 0.0, 6.0)
        session.run(ticks=64)
    assert slow.desk.master.level > 0.9
    assert fast.desk.master.level == pytest.approx(0.5, abs=0.02)


@pytest.mark.long
def test_scene_panic_and_undo_do_not_end_fade_out():
    session = DeskSession()
    session.say("/dance/output/fade", 0.0, 0.0)
    session.run(1)
    for call in (("/dance/scene", "start"), ("/dance/panic",), ("/dance/undo",), ("/dance/light/level", 1.0)):
        session.say(*call)
        session.run(4)
        assert brightness(session) == 0.0


def test_light_requires_blackout_off_and_fade_up():
    session = DeskSession()
    session.say("/dance/output/fade", 0.5, 0.0)
    session.say("/dance/blackout", 1)
    session.run(4)
    assert brightness(session) < 0.01
    session.say("/dance/blackout", 0)
    session.run(4)
    assert brightness(session) == pytest.approx(0.5, abs=0.01)


def test_frozen_picture_is_constant_while_dance_continues():
    session = DeskSession()
    session.run(3)
    view = current_view(session)
    before = view.joint_position.copy(), view.beat, view.picture.copy()
    session.say("/dance/output/freeze", 1)
    session.say("/dance/light/level", 0.3)
    session.run(5)
    session.show.fill(view, session.show.time)
    np.testing.assert_array_equal(view.joint_position, before[0])
    assert view.beat == before[1]
    np.testing.assert_array_equal(view.picture, before[2])
    session.say("/dance/blackout", 1)
    session.run(4)
    session.show.fill(view, session.show.time)
    assert view.brightness < 0.01
    assert view.beat == before[1]
    session.say("/dance/output/freeze", 0)
    session.show.fill(view, session.show.time)
    assert view.beat > before[1] + 8.9
    assert np.abs(view.joint_position - before[0]).max() > 0.01


def test_freeze_does_not_change_dance_state():
    plain, frozen = DeskSession(), DeskSession()
    frozen.say("/dance/output/freeze", 1)
    frozen.say("/dance/output/flashes", 1)
    for session in (plain, frozen):
        session.run(9)
    assert frozen.show.state_hash() == plain.show.state_hash()
    assert current_view(frozen).flash_limit_lifted
    assert not current_view(plain).flash_limit_lifted


def take_snapshot(session):
    """The first snapshot that can be taken."""
    source = Snapshotter(session.show)
    while (taken := source.capture(session.ticks)) is None:
        session.run(ticks=1)
    return taken.seal()


def test_frozen_picture_is_kept_in_new_view_and_snapshot():
    """As for an engine that takes over, with a show that ran in parallel or with one restored from a snapshot."""
    session = DeskSession()
    session.run(3)
    before = current_view(session)
    session.say("/dance/output/freeze", 1)
    session.say("/dance/output/card", "Left", "grid")
    session.say("/dance/output/card", "*", "name")
    session.say("/dance/output/card", "right", "off")
    session.say("/dance/output/fade", 0.5, 0.0)
    session.run(9)
    session.say("/dance/output/freeze", 1)  # frozen is frozen
    for show in (session.show, restore(LOADED, take_snapshot(session))):
        view = show.view()
        show.fill(view, show.time)
        assert view.beat == before.beat
        np.testing.assert_array_equal(view.joint_position, before.joint_position)
        np.testing.assert_array_equal(view.picture, before.picture)
        assert view.brightness == pytest.approx(0.5)
        assert show.desk.master.cards == {"*": "name", "right": "off"}
    session.say("/dance/output/freeze", 0)
    assert current_view(session).beat > before.beat + 8.9


def test_removed_cards_are_deleted_and_card_count_is_limited():
    session = DeskSession()
    for number in range(100):
        session.say("/dance/output/card", f"output {number}", "grid")
    assert len(session.desk.master.cards) == 64
    session.say("/dance/output/card", "output 99", "off")
    assert len(session.desk.master.cards) == 63
    session.say("/dance/output/card", "*", "off")
    assert session.desk.master.cards == {}


def test_status_reports_freeze_and_flash_limit():
    session = DeskSession()
    assert session.desk.facts(0.0)["master"] == {"level": 1.0, "frozen": False, "flashes": False}
    session.say("/dance/output/freeze", 1)
    session.say("/dance/output/flashes", 1)
    assert session.desk.status_lines(session.show.danced_beats)[:2] == (
        "FROZEN: the picture stands still", "flashes are not limited",
    )  # fmt: skip


@pytest.mark.parametrize(
    "call",
    [
        ("/dance/output/fade", (0.5, 3.0)), ("/dance/output/freeze", (1,)), ("/dance/output/flashes", (0,)),
        ("/dance/output/card", ("left", "focus")),
    ],
)  # fmt: skip
def test_output_events_survive_json_round_trip(call):
    event = REGISTRY.call(*call, 1.5, "osc")
    assert event_from_json(event_to_json(event)) == event
