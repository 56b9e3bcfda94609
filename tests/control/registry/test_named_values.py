"""Tests of values per performer: each is queried, sent, subscribed and set at its own address."""

import pytest

from live.control.events import events
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_mapping import current_value
from live.control.registry.registry import READABLE, REGISTRY, Values
from live.control.web.surface import make_surface
from live.show.desk.completions import completion_names
from live.show.patch.patch_reader import parse_patch
from tests.control.osc.test_osc_handler import ME, YOU, HandlerStage
from tests.show.made_show import PATCH

MIRRORED, PLACE, ATTRACT = (f"/dance/mocap/{what}" for what in ("mirrored", "place", "attract"))
ROWS = {
    MIRRORED: (("anna", (True,)), ("ben", (False,))),
    PLACE: (("anna", (1.0, -2.0, 0.0, 1.0)), ("ben", (0.0, 0.0, 90.0, 1.0))),
    ATTRACT: (("anna", (0.5, "*")), ("ben", (0.0, "ember"))),
}
NAMED = [control for control in REGISTRY if control.named]


@pytest.fixture
def handler_stage():
    made = HandlerStage()
    made.door.values.update(ROWS)
    return made


def performer_address(what, name="anna"):
    return f"/dance/mocap/{name}/{what}"


def test_performer_controls_have_an_address_per_performer():
    assert {control.address for control in NAMED} == {c.address for c in REGISTRY if "/mocap/" in c.address}
    for control in NAMED:
        assert control.address in READABLE
        assert control.address_of("anna") == performer_address(control.address.rpartition("/")[2])
        for name in ("two words", "a/b", "a*", "a?", "[a]", "{a}", "a,b", "#a", "Änna", "", "a\n"):
            assert control.address_of(name) is None
        assert REGISTRY.storage_key(performer_address(control.address.rpartition("/")[2])) == (control.address, "anna")
    assert REGISTRY.storage_key("/dance/light/key") == ("/dance/light/key", "")
    assert REGISTRY.storage_key("/nothing") == ("/nothing", "")


def test_message_without_values_queries_unless_arguments_are_optional(handler_stage):
    assert handler_stage.ask(MIRRORED) == [
        (performer_address("mirrored"), True),
        (performer_address("mirrored", "ben"), False),
    ]
    assert handler_stage.ask(performer_address("place", "ben")) == [
        (performer_address("place", "ben"), 0.0, 0.0, 90.0, 1.0)
    ]
    assert handler_stage.ask("/dance/get", performer_address("mirrored")) == [(performer_address("mirrored"), True)]
    assert handler_stage.ask("/dance/get", performer_address("mirrored", "nobody")) == [
        ("/dance/no_value", performer_address("mirrored", "nobody"))
    ]
    assert handler_stage.ask("/dance/get", "/dance/mocap/a*") == [
        (performer_address("attract"), 0.5, "*"),
        (performer_address("attract", "ben"), 0.0, "ember"),
    ]
    assert handler_stage.events() == []
    assert handler_stage.ask(performer_address("mirrored", "ben")) == []  # to be mirrored is what nothing means here
    assert [(type(event), event.performer) for event in handler_stage.events()] == [(events.MirrorMocap, "ben")]


def test_last_value_is_kept_for_each_performer(handler_stage):
    handler_stage.ask(performer_address("attract"), 0.25)
    handler_stage.ask(performer_address("attract", "ben"), -1.0, "tide")
    handler_stage.ask(ATTRACT, "anna", 0.75)
    found = {event.performer: (event.strength, event.group) for event in handler_stage.events()}
    assert found == {"anna": (0.75, ""), "ben": (-1.0, "tide")}
    assert handler_stage.door.replaced == 1


def test_subscribers_get_performer_addresses_without_echo(handler_stage):
    handler_stage.ask("/dance/subscribe", "/dance/mocap", 60.0)
    handler_stage.ask("/dance/subscribe", "/dance/mocap", 60.0, of=YOU)
    expected = {performer_address(what, who) for what in ("mirrored", "place", "attract") for who in ("anna", "ben")}
    assert {row[0] for row in handler_stage.turn(0.1)[ME]} == expected
    handler_stage.ask(performer_address("attract"), 0.25, at=1.0)
    handler_stage.door.values.update({ATTRACT: (("anna", (0.25, "*")), ("ben", (0.0, "ember")))})
    handler_stage.door.subscribers.mark_changed([ATTRACT], 1.0)
    assert (performer_address("attract"), 0.25, "*") in handler_stage.turn(1.1)[YOU]
    handler_stage.turn(2.5)
    handler_stage.ask(performer_address("attract"), 0.125, "*", at=3.0)
    handler_stage.door.values.update({ATTRACT: (("anna", (0.125, "*")), ("ben", (0.0, "ember")))})
    handler_stage.door.subscribers.mark_changed([ATTRACT], 3.0)
    assert set(handler_stage.turn(3.1)) == {YOU}
    assert handler_stage.turn(4.5) == {}  # it came as it was said
    handler_stage.ask(performer_address("attract"), 0.5, "*", at=5.0)
    handler_stage.door.values.update({ATTRACT: (("anna", (0.5, "*")), ("ben", (1.0, "ember")))})
    handler_stage.door.subscribers.mark_changed([ATTRACT], 5.0)
    handler_stage.turn(5.1)
    assert (performer_address("attract", "ben"), 1.0, "ember") in handler_stage.turn(6.5)[
        ME
    ]  # and what another said is told


def test_performer_fader_picks_up_the_performer_value():
    values = Values()
    values.update(ROWS)
    for name, strength in (("anna", 0.5), ("ben", 0.0), ("nobody", None)):
        assert current_value(Binding("cc", 7, ATTRACT, values={"performer": name}), values) == strength


def test_completions_contain_performers_of_patch():
    patch = parse_patch(PATCH + '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n', "test.toml")
    names = completion_names(patch, ())
    assert [names[control.address] for control in NAMED] == [["anna", "ben"]] * len(NAMED)


def test_performers_of_patch_have_switches_and_fader():
    made = make_surface(NAMED, role="operator", names={c.address: ["anna", "two words"] for c in NAMED})
    widgets = {widget.address: widget.kind for page in made.pages for widget in page.widgets}
    assert widgets == {performer_address(what): "toggle" for what in ("shown", "mirrored", "obstacle")} | {
        performer_address("attract"): "fader"
    }
    assert set(made.omitted) == {f"/dance/mocap/{what}" for what in ("dancer", "place", "canon")}
