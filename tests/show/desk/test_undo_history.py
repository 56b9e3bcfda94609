"""Undo and redo: every kind of edit comes back as it was; what has been played is left alone."""

import pytest

from live.control.registry.registry import REGISTRY
from live.show.desk.undo_history import EDITED_PARTS, MAX_EDITS
from tests.show.desk.desk_show import DESK, Hands


@pytest.fixture
def hands():
    return Hands(DESK + '[[mocap]]\nname = "anna"\nattracts = "front"\n').run(5)


def kept(hands):
    """All that can be edited, by part."""
    taken = {name: part.snapshot() for name, part in hands.desk.undo_history._parts.items()}
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


@pytest.mark.parametrize("call", CALLS, ids=lambda call: call[0])
def test_each_edit_is_taken_back_and_made_again(hands, call):
    before = kept(hands)
    assert hands.say(*call), hands.words
    hands.run(1)
    edited = kept(hands)
    assert edited != before
    assert hands.say("/dance/undo")
    hands.run(1)
    assert kept(hands) == before
    assert hands.say("/dance/redo")
    hands.run(1)
    assert kept(hands) == edited
    assert not hands.say("/dance/redo")


def test_removing_from_the_set_is_taken_back(hands):
    hands.say("/dance/obstacle", "rock", 3.0, 3.0, 0.5)
    hands.say("/dance/wall", "fence", -3.0, 3.5, 3.0, 3.5)
    before = kept(hands)
    hands.say("/dance/obstacle/remove", "rock")
    assert hands.show.motion.surroundings.obstacle_count == 0
    hands.say("/dance/undo")
    assert kept(hands) == before


def test_edits_come_back_in_their_order_and_a_new_one_ends_what_could_be_made_again(hands):
    states = [kept(hands)]
    for call in CALLS:
        hands.say(*call)
        hands.run(1)
        states.append(kept(hands))
    for state in reversed(states[:-1]):
        assert hands.say("/dance/undo")
        hands.run(1)
        assert kept(hands) == state
    assert not hands.say("/dance/undo")
    hands.say("/dance/redo")
    hands.say("/dance/light/level", 1.7)
    assert not hands.say("/dance/redo")


def test_a_moving_fader_is_one_edit_and_two_are_two(hands):
    for value in (0.9, 0.8, 0.7):
        hands.say("/dance/light/level", value)
        hands.run(ticks=3)
    hands.say("/dance/light/haze", 0.5)
    assert hands.desk.facts(hands.show.danced_beats)["edits"] == 2
    hands.say("/dance/undo")
    hands.say("/dance/undo")
    hands.run(1)
    assert hands.value("/dance/light/level") == 1.0


def test_what_has_been_played_is_no_edit(hands):
    for call in (("/dance/go",), ("/dance/attract", 1.0, 1.0), ("/dance/step", "spin"), ("/dance/blackout", 1),
                 ("/dance/cue", "up"), ("/dance/formation", "circle")):  # fmt: skip
        hands.say(*call)
    hands.run(8)
    assert hands.cues["fired"] == 2
    assert not hands.say("/dance/undo")
    assert "nothing to take back" in hands.words


def test_undo_leaves_alone_what_a_cue_has_changed_since(hands):
    hands.say("/dance/light/haze", 0.5)
    hands.say("/dance/cue", "dim")
    hands.run(16)
    assert hands.value("/dance/light/level") == 0.25
    hands.say("/dance/undo")
    hands.run(1)
    assert hands.value("/dance/light/haze") == 0.035
    assert hands.value("/dance/light/level") == 0.25


def test_what_is_refused_is_no_edit_and_only_so_many_are_kept(hands):
    hands.say("/dance/scene", "nowhere")
    hands.say("/dance/sequence", "no such step")
    assert hands.desk.facts(hands.show.danced_beats)["edits"] == 0
    for number in range(MAX_EDITS + 10):
        hands.say("/dance/scene/store", f"scene {number}")
    assert hands.desk.facts(hands.show.danced_beats)["edits"] == MAX_EDITS


def test_every_kind_of_edit_names_a_part(hands):
    assert set(EDITED_PARTS.values()) == set(kept(hands))


def test_what_is_said_of_two_performers_at_once_are_two_edits():
    hands = Hands(DESK + '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n').run(5)
    for name in ("anna", "ben"):
        hands.say(f"/dance/mocap/{name}/mirrored", 1)
    mirrored = lambda: [each.mirrored for each in hands.show.mocap.performers.values()]  # noqa: E731
    assert hands.desk.undo_history.facts()["undo"] == "MirrorMocap ben"
    hands.say("/dance/undo")
    assert mirrored() == [True, False]
    hands.say("/dance/undo")
    assert mirrored() == [False, False]


def test_what_was_said_of_a_performer_of_whom_nothing_was_known_is_taken_back():
    hands = Hands().run(5)
    assert hands.say("/dance/mocap/live/place", 1.0, 2.0)
    assert hands.say("/dance/undo")
    live = hands.show.mocap.performers["live"]
    assert (live.origin, live.scale) == ((0.0, 0.0, 0.0), 1.0)
    assert hands.say("/dance/redo")
    assert live.origin == (1.0, 2.0, 0.0)


def test_who_attracts_more_attracts_the_same(hands):
    captured = hands.show.mocap.performers["anna"]
    hands.say("/dance/mocap/anna/attract", 2.0)
    assert (captured.attract, captured.attracts) == (2.0, "front")
    hands.say("/dance/mocap/anna/attract", 1.0, "*")
    assert captured.attracts == "*"


@pytest.mark.parametrize(
    "call", [("/dance/light/level", 0.3), ("/dance/light/key", 0.1), ("/dance/camera/eye", 1.0, 2.0, 9.0)],
    ids=lambda call: call[0],
)  # fmt: skip
def test_a_value_of_the_picture_is_compared_by_its_own_numbers_with_what_all_would_show(hands, call):
    part = hands.desk.undo_history._parts["parameters"]
    event = REGISTRY.call(call[0], call[1:], 0.0, "key")
    few, whole = part.affected(event), part.snapshot()
    assert 0 < len(few) <= 3
    assert hands.say(*call), hands.words
    now = part.snapshot()
    changed = {place: (was, new) for place, (was, new) in enumerate(zip(whole, now, strict=True)) if was != new}
    assert changed
    assert changed == {place: (few[place], new) for place, new in part.affected(event).items() if few[place] != new}
