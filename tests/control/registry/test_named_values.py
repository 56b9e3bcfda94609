"""Values of which a control names whose they are: each is asked, told, listened to and set at its own address."""

import pytest

from live.control.events import events
from live.control.layouts.surface import make_surface
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_mapping import current_value
from live.control.osc.oscquery_tree import Namespace
from live.control.registry.registry import READABLE, REGISTRY, Values
from live.show.desk.completions import completion_names
from live.show.patch.patch_reader import parse_patch
from tests.control.osc.test_osc_handler import ME, YOU, Asked
from tests.show.made_show import PATCH

MIRRORED, PLACE, ATTRACT = (f"/dance/mocap/{what}" for what in ("mirrored", "place", "attract"))
ROWS = {
    MIRRORED: (("anna", (True,)), ("ben", (False,))),
    PLACE: (("anna", (1.0, -2.0, 0.0, 1.0)), ("ben", (0.0, 0.0, 90.0, 1.0))),
    ATTRACT: (("anna", (0.5, "*")), ("ben", (0.0, "ember"))),
}
NAMED = [control for control in REGISTRY if control.named]


@pytest.fixture
def asked():
    made = Asked()
    made.door.values.update(ROWS)
    return made


def own(what, name="anna"):
    return f"/dance/mocap/{name}/{what}"


def test_all_that_is_said_of_performers_has_a_value_under_her_name():
    assert {control.address for control in NAMED} == {c.address for c in REGISTRY if "/mocap/" in c.address}
    for control in NAMED:
        assert control.address in READABLE
        assert control.address_of("anna") == own(control.address.rpartition("/")[2])
        for name in ("two words", "a/b", "a*", "a?", "[a]", "{a}", "a,b", "#a", "Änna", "", "a\n"):
            assert control.address_of(name) is None
        assert REGISTRY.storage_key(own(control.address.rpartition("/")[2])) == (control.address, "anna")
    assert REGISTRY.storage_key("/dance/light/key") == ("/dance/light/key", "")
    assert REGISTRY.storage_key("/nothing") == ("/nothing", "")


def test_a_message_that_says_nothing_asks_where_nothing_would_mean_nothing(asked):
    assert asked.ask(MIRRORED) == [(own("mirrored"), True), (own("mirrored", "ben"), False)]
    assert asked.ask(own("place", "ben")) == [(own("place", "ben"), 0.0, 0.0, 90.0, 1.0)]
    assert asked.ask("/dance/get", own("mirrored")) == [(own("mirrored"), True)]
    assert asked.ask("/dance/get", own("mirrored", "nobody")) == [("/dance/no_value", own("mirrored", "nobody"))]
    assert asked.ask("/dance/get", "/dance/mocap/a*") == [
        (own("attract"), 0.5, "*"),
        (own("attract", "ben"), 0.0, "ember"),
    ]
    assert asked.events() == []
    assert asked.ask(own("mirrored", "ben")) == []  # to be mirrored is what nothing means here
    assert [(type(event), event.performer) for event in asked.events()] == [(events.MirrorMocap, "ben")]


def test_of_several_said_of_one_performer_the_last_counts_and_others_are_left_alone(asked):
    asked.ask(own("attract"), 0.25)
    asked.ask(own("attract", "ben"), -1.0, "tide")
    asked.ask(ATTRACT, "anna", 0.75)
    found = {event.performer: (event.strength, event.group) for event in asked.events()}
    assert found == {"anna": (0.75, ""), "ben": (-1.0, "tide")}
    assert asked.door.replaced == 1


def test_subscribers_are_told_each_at_her_address_and_not_what_they_said(asked):
    asked.ask("/dance/subscribe", "/dance/mocap", 60.0)
    asked.ask("/dance/subscribe", "/dance/mocap", 60.0, of=YOU)
    assert {row[0] for row in asked.turn(0.1)[ME]} == {own(what, who) for what in ("mirrored", "place", "attract")
                                                      for who in ("anna", "ben")}  # fmt: skip
    asked.ask(own("attract"), 0.25, at=1.0)
    asked.door.values.update({ATTRACT: (("anna", (0.25, "*")), ("ben", (0.0, "ember")))})
    asked.door.subscribers.mark_changed([ATTRACT], 1.0)
    assert (own("attract"), 0.25, "*") in asked.turn(1.1)[YOU]
    asked.turn(2.5)
    asked.ask(own("attract"), 0.125, "*", at=3.0)
    asked.door.values.update({ATTRACT: (("anna", (0.125, "*")), ("ben", (0.0, "ember")))})
    asked.door.subscribers.mark_changed([ATTRACT], 3.0)
    assert set(asked.turn(3.1)) == {YOU}
    assert asked.turn(4.5) == {}  # it came as it was said
    asked.ask(own("attract"), 0.5, "*", at=5.0)
    asked.door.values.update({ATTRACT: (("anna", (0.5, "*")), ("ben", (1.0, "ember")))})
    asked.door.subscribers.mark_changed([ATTRACT], 5.0)
    asked.turn(5.1)
    assert (own("attract", "ben"), 1.0, "ember") in asked.turn(6.5)[ME]  # and what another said is told


def test_the_tree_has_everybody_who_is_named():
    values = Values()
    tree = Namespace(values)
    assert not tree.has(own("mirrored"))
    assert "VALUE" not in tree.node(MIRRORED)
    values.update(ROWS)
    for name, (value,) in ROWS[MIRRORED]:
        node = tree.node(own("mirrored", name))
        assert (node["TYPE"], node["VALUE"], node["ACCESS"]) == ("T" if value else "F", [value], 3)
    assert tree.attribute(own("attract"), "RANGE") == {"RANGE": [{"MIN": -10, "MAX": 10}, {}]}
    assert (tree.node(ATTRACT)["TYPE"], tree.node(ATTRACT)["VALUE"]) == ("sfs", ["anna", 0.5, "*"])
    assert set(tree.node("/dance/mocap/ben")["CONTENTS"]) == {"mirrored", "place", "attract"}


def test_a_fader_of_a_performer_is_picked_up_where_hers_is():
    values = Values()
    values.update(ROWS)
    for name, strength in (("anna", 0.5), ("ben", 0.0), ("nobody", None)):
        assert current_value(Binding("cc", 7, ATTRACT, values={"performer": name}), values) == strength


def test_the_page_is_told_the_performers_of_a_patch():
    patch = parse_patch(PATCH + '[[mocap]]\nname = "anna"\n[[mocap]]\nname = "ben"\n', "test.toml")
    names = completion_names(patch, ())
    assert [names[control.address] for control in NAMED] == [["anna", "ben"]] * len(NAMED)


def test_performers_of_a_patch_have_switches_and_a_fader_that_leaves_the_rest_alone():
    made = make_surface(NAMED, role="operator", names={c.address: ["anna", "two words"] for c in NAMED})
    widgets = {widget.address: widget.kind for page in made.pages for widget in page.widgets}
    assert widgets == {own(what): "toggle" for what in ("shown", "mirrored", "obstacle")} | {own("attract"): "fader"}
    assert set(made.omitted) == {f"/dance/mocap/{what}" for what in ("dancer", "place", "canon")}
