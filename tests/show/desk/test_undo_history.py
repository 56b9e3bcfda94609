"""Tests of undo and redo: each kind of edit is reversible; playback commands are not edits."""

import pytest

from live.control.events.event import ControlEvent
from live.control.events.events import EVENT_TYPES
from live.control.registry.registry import REGISTRY
from live.show.desk.undo_history import MAX_EDITS
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DESK, DeskSession


@pytest.fixture
def session():
    return DeskSession(DESK + '[[mocap]]\nname = "anna"\nattracts = "front"\n').run(5)


def editable_state(session):
    """All editable state, by part."""
    event = ControlEvent(time=0.0, source="test")
    taken = {name: part.edited_values(event) for name, part in session.desk.undo_history._parts.items()}
    return {name: now if isinstance(now, dict) else now.tolist() for name, now in taken.items()}


CALLS = (
    ("/dance/light/level", 0.3), ("/dance/motion/head", 0.5, "front"), ("/dance/camera", "side"),
    ("/dance/look", "dusk", 0), ("/dance/scene", "low", 0), ("/dance/scene/store", "mine"),
    ("/dance/formation/define", "mine", "circle"), ("/dance/sequence", "sway, spin", "front"),
    ("/dance/facing", "centre"), ("/dance/ripple", 1.0), ("/dance/obstacle", "rock", 3.0, 3.0, 0.5),
    ("/dance/wall", "fence", -3.0, 3.5, 3.0, 3.5), ("/dance/standby", "up"),
    ("/dance/mocap/anna/dancer", "back & 6"), ("/dance/mocap/anna/shown", 0), ("/dance/mocap/anna/mirrored", 1),
    ("/dance/mocap/anna/place", 0.1, -0.7, 33.3, 1.1), ("/dance/mocap/anna/canon", "back", 1.5),
    ("/dance/mocap/anna/obstacle", 1), ("/dance/mocap/anna/attract", -0.3),
)  # fmt: skip


@mostly_long("call", CALLS, quick=[2, 5], ids=lambda call: call[0])
def test_each_edit_can_be_undone_and_redone(session, call):
    before = editable_state(session)
    assert session.say(*call), session.words
    session.run(1)
    edited = editable_state(session)
    assert edited != before
    assert session.say("/dance/undo")
    session.run(1)
    assert editable_state(session) == before
    assert session.say("/dance/redo")
    session.run(1)
    assert editable_state(session) == edited
    assert not session.say("/dance/redo")


def test_removed_obstacle_is_restored_by_undo(session):
    session.say("/dance/obstacle", "rock", 3.0, 3.0, 0.5)
    session.say("/dance/wall", "fence", -3.0, 3.5, 3.0, 3.5)
    before = editable_state(session)
    session.say("/dance/obstacle/remove", "rock")
    assert session.show.motion.surroundings.obstacle_count == 0
    session.say("/dance/undo")
    assert editable_state(session) == before


@pytest.mark.long
def test_edits_are_undone_in_reverse_order_and_new_edit_clears_redo(session):
    states = [editable_state(session)]
    for call in CALLS:
        session.say(*call)
        session.run(1)
        states.append(editable_state(session))
    for state in reversed(states[:-1]):
        assert session.say("/dance/undo")
        session.run(1)
        assert editable_state(session) == state
    assert not session.say("/dance/undo")
    session.say("/dance/redo")
    session.say("/dance/light/level", 1.7)
    assert not session.say("/dance/redo")


def test_fader_movement_is_one_edit_and_two_faders_are_two(session):
    for value in (0.9, 0.8, 0.7):
        session.say("/dance/light/level", value)
        session.run(ticks=3)
    session.say("/dance/light/haze", 0.5)
    assert session.desk.facts(session.show.danced_beats)["edits"] == 2
    session.say("/dance/undo")
    session.say("/dance/undo")
    session.run(1)
    assert session.value("/dance/light/level") == 1.0


@pytest.mark.long
def test_playback_commands_are_not_edits(session):
    for call in (("/dance/go",), ("/dance/attract", 1.0, 1.0), ("/dance/step", "spin"), ("/dance/blackout", 1),
                 ("/dance/cue", "up"), ("/dance/formation", "circle")):  # fmt: skip
        session.say(*call)
    session.run(8)
    assert session.cues["fired"] == 2
    assert not session.say("/dance/undo")
    assert "nothing to take back" in session.words


@pytest.mark.long
def test_undo_keeps_later_changes_by_cue(session):
    session.say("/dance/light/haze", 0.5)
    session.say("/dance/cue", "dim")
    session.run(16)
    assert session.value("/dance/light/level") == 0.25
    session.say("/dance/undo")
    session.run(1)
    assert session.value("/dance/light/haze") == 0.035
    assert session.value("/dance/light/level") == 0.25


def test_refused_calls_are_not_edits_and_history_is_limited(session):
    session.say("/dance/scene", "nowhere")
    session.say("/dance/sequence", "no such step")
    assert session.desk.facts(session.show.danced_beats)["edits"] == 0
    for number in range(MAX_EDITS + 10):
        session.say("/dance/scene/store", f"scene {number}")
    assert session.desk.facts(session.show.danced_beats)["edits"] == MAX_EDITS


def test_each_kind_of_edit_names_known_part(session):
    assert {kind.edits for kind in EVENT_TYPES.values()} - {""} == set(editable_state(session))


def test_simultaneous_changes_of_two_performers_are_two_edits():
    session = DeskSession(DESK + '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n').run(5)
    for name in ("anna", "ben"):
        session.say(f"/dance/mocap/{name}/mirrored", 1)
    mirrored = lambda: [each.mirrored for each in session.show.mocap.performers.values()]  # noqa: E731
    assert session.desk.undo_history.facts()["undo"] == "MirrorMocap ben"
    session.say("/dance/undo")
    assert mirrored() == [True, False]
    session.say("/dance/undo")
    assert mirrored() == [False, False]


def test_edit_of_new_performer_can_be_undone():
    session = DeskSession().run(5)
    assert session.say("/dance/mocap/live/place", 1.0, 2.0)
    assert session.say("/dance/undo")
    live = session.show.mocap.performers["live"]
    assert (live.origin, live.scale) == ((0.0, 0.0, 0.0), 1.0)
    assert session.say("/dance/redo")
    assert live.origin == (1.0, 2.0, 0.0)


def test_attraction_strength_change_keeps_attracted_group(session):
    captured = session.show.mocap.performers["anna"]
    session.say("/dance/mocap/anna/attract", 2.0)
    assert (captured.attract, captured.attracts) == (2.0, "front")
    session.say("/dance/mocap/anna/attract", 1.0, "*")
    assert captured.attracts == "*"


@pytest.mark.parametrize(
    "call", [("/dance/light/level", 0.3), ("/dance/light/key", 0.1), ("/dance/camera/eye", 1.0, 2.0, 9.0)],
    ids=lambda call: call[0],
)  # fmt: skip
def test_affected_values_match_full_snapshot_difference(session, call):
    part = session.desk.undo_history._parts["parameters"]
    event = REGISTRY.call(call[0], call[1:], 0.0, "key")
    few, whole = part.edited_values(event), part.goals()
    assert 0 < len(few) <= 4
    assert session.say(*call), session.words
    now = part.goals()
    changed = {place: (was, new) for place, (was, new) in enumerate(zip(whole, now, strict=True)) if was != new}
    assert changed
    assert changed == {
        place: (few[place], new) for place, new in part.edited_values(event).items() if few[place] != new
    }
