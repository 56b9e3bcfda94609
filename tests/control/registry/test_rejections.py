import math
import typing
from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.control.events import events
from live.control.events.event_json import event_from_json, event_to_json
from live.control.events.events import ControlEvent
from live.control.events.system import Ping
from live.control.registry.control import NAME_LENGTH, Argument, Control, Released
from live.control.registry.registry import REGISTRY, Registry
from live.control.registry.rejections import Reason, Rejection, Tally
from tools.reference.osc_pages import osc_pages


def call(address, *values):
    return REGISTRY.call(address, values, 12.5, "test")


def reason(address, *values):
    result = call(address, *values)
    assert isinstance(result, Rejection), result
    assert result.address == address
    return result.reason


STAMP = {"time": 12.5, "source": "test"}


@pytest.mark.parametrize(
    ("address", "values", "event"),
    [
        ("/dance/attract", (1.5, -2.0), events.PlaceElement(kind="attract", points=((1.5, -2.0),), **STAMP)),
        (
            "/dance/attract",
            (1, -2, 3, 8),
            events.PlaceElement(kind="attract", points=((1.0, -2.0),), strength=3.0, measures=8.0, **STAMP),
        ),
        (
            "/dance/attract",
            (0.0, 0.0, None, 2.0),
            events.PlaceElement(kind="attract", points=((0.0, 0.0),), measures=2.0, **STAMP),
        ),
        (
            "/dance/repel",
            (-100, 100.0, 0),
            events.PlaceElement(kind="repel", points=((-100.0, 100.0),), strength=0.0, **STAMP),
        ),
        ("/dance/spread", (), events.PlaceElement(kind="spread", **STAMP)),
        ("/dance/spread", (0.25,), events.PlaceElement(kind="spread", measures=0.25, **STAMP)),
        ("/dance/clear", (), events.Clear(**STAMP)),
        ("/dance/clear", (1.0,), events.Clear(**STAMP)),
        ("/dance/clock/tap", (True,), events.Tap(**STAMP)),
        ("/dance/clock/tap", (0.0,), Released()),
        ("/dance/clock/one", (0,), Released()),
        ("/dance/step", ("samba",), events.CallStep(name="samba", **STAMP)),
        ("/dance/step", ("Čača ♥", 16), events.CallStep(name="Čača ♥", measures=16.0, **STAMP)),
        ("/dance/step", ("x" * NAME_LENGTH,), events.CallStep(name="x" * NAME_LENGTH, **STAMP)),
        ("/dance/clock/tap", (), events.Tap(**STAMP)),
        ("/dance/clock/tap", (None,), events.Tap(**STAMP)),
        ("/dance/clock/one", (), events.One(**STAMP)),
        ("/dance/clock/tempo", (128,), events.SetTempo(tempo=128.0, **STAMP)),
        ("/dance/blackout", (1,), events.Blackout(on=True, **STAMP)),
        ("/dance/blackout", (0.0,), events.Blackout(on=False, **STAMP)),
        ("/dance/blackout", (True,), events.Blackout(on=True, **STAMP)),
        ("/dance/blackout", (False,), events.Blackout(on=False, **STAMP)),
        ("/dance/ping", (), Ping(**STAMP)),
    ],
)
def test_every_control_makes_its_event(address, values, event):
    result = call(address, *values)
    assert result == event
    for field in fields(result):  # an int is a float here, not an int that the journal would write another way
        value, kind = getattr(result, field.name), typing.get_type_hints(type(result))[field.name]
        assert type(value) is (typing.get_origin(kind) or kind)
        assert all(type(number) is float for point in value for number in point) if field.name == "points" else True


@pytest.mark.parametrize(
    ("address", "values", "expected"),
    [
        ("/dance/attract", (), Reason.MISSING),
        ("/dance/attract", (1.0,), Reason.MISSING),
        ("/dance/attract", (None, 1.0), Reason.MISSING),
        ("/dance/attract", (1.0, 2.0, 1.0, 4.0, "*", True, 5.0), Reason.EXTRA),
        ("/dance/attract", (math.nan, 0.0), Reason.NOT_FINITE),
        ("/dance/attract", (0.0, -math.inf), Reason.NOT_FINITE),
        ("/dance/attract", (1e30, 0.0), Reason.OUT_OF_RANGE),
        ("/dance/attract", (100.001, 0.0), Reason.OUT_OF_RANGE),
        ("/dance/attract", (10**400, 0.0), Reason.OUT_OF_RANGE),
        ("/dance/attract", (0.0, 0.0, -0.1), Reason.OUT_OF_RANGE),
        ("/dance/attract", (0.0, 0.0, 10.1), Reason.OUT_OF_RANGE),
        ("/dance/attract", (0.0, 0.0, 1.0, 0.2), Reason.OUT_OF_RANGE),
        ("/dance/attract", (0.0, 0.0, 1.0, 1025), Reason.OUT_OF_RANGE),
        ("/dance/attract", ("1", "2"), Reason.WRONG_TYPE),
        ("/dance/attract", (True, 0.0), Reason.WRONG_TYPE),
        ("/dance/attract", (b"1234", (1, 2, 3, 4)), Reason.WRONG_TYPE),
        ("/dance/clear", (2.0,), Reason.EXTRA),
        ("/dance/step", (), Reason.MISSING),
        ("/dance/step", (3,), Reason.WRONG_TYPE),
        ("/dance/step", ("",), Reason.NAME),
        ("/dance/step", ("   ",), Reason.NAME),
        ("/dance/step", ("a\nb",), Reason.NAME),
        ("/dance/step", ("a\u202eb",), Reason.NAME),
        ("/dance/step", ("x" * (NAME_LENGTH + 1),), Reason.NAME),
        ("/dance/clock/tempo", (19.9,), Reason.OUT_OF_RANGE),
        ("/dance/clock/tempo", (400.1,), Reason.OUT_OF_RANGE),
        ("/dance/blackout", (2,), Reason.OUT_OF_RANGE),
        ("/dance/blackout", (0.5,), Reason.OUT_OF_RANGE),
        ("/dance/blackout", (math.nan,), Reason.NOT_FINITE),
        ("/dance/blackout", ("on",), Reason.WRONG_TYPE),
        ("/dance/attrac", (1.0, 2.0), Reason.UNKNOWN_ADDRESS),
        ("/dance/attract/", (1.0, 2.0), Reason.UNKNOWN_ADDRESS),
        ("/DANCE/attract", (1.0, 2.0), Reason.UNKNOWN_ADDRESS),
        ("/dance/*", (), Reason.UNKNOWN_ADDRESS),
    ],
)
def test_undeclared_values_are_refused_with_reason(address, values, expected):
    assert reason(address, *values) == expected


def test_extra_argument_refusal_names_the_value():
    words = "'/dance/background': extra argument: expected at most 2 values, the next one is 7"
    assert str(call("/dance/background", "sea", 1.0, 7)) == words


anything = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=80), st.binary(max_size=8), st.just((1, 2))
)


@given(st.sampled_from([control.address for control in REGISTRY]), st.lists(anything, max_size=6))
def test_any_values_give_valid_event_or_rejection(address, values):
    result = call(address, *values)
    if isinstance(result, Rejection):
        assert str(result).isprintable()
        assert len(str(result)) < 300
    elif isinstance(result, ControlEvent):
        given_on: dict[str, typing.Any] = {}  # what the event is made of: some events name and count otherwise
        replace(REGISTRY[address], make=lambda **values: given_on.update(values) or result).call(values, 12.5, "test")
        for argument in REGISTRY[address].arguments:
            value = given_on[argument.name]
            if argument.type == "float":
                assert argument.minimum <= value <= argument.maximum
            elif argument.type == "name":
                assert 1 <= len(value) <= NAME_LENGTH
        assert event_from_json(event_to_json(result)) == result


def test_rejection_names_range_and_value():
    text = str(call("/dance/attract", 1e30, 0.0))
    assert "-100 to 100 m" in text
    assert "1e+30" in text


def test_duplicate_address_or_misplaced_optional_argument_is_refused():
    with pytest.raises(ValueError, match="one address"):
        Registry([REGISTRY["/dance/clear"], REGISTRY["/dance/clear"]])
    first, second = Argument("a", "float", "", default=1.0), Argument("b", "float", "")
    with pytest.raises(ValueError, match="after an optional one"):
        Control("/x", events.Clear, (first, second), "", "operator")


def test_defaults_are_within_their_ranges():
    for control in REGISTRY:
        for argument in control.arguments:
            if argument.default is not None:
                assert argument.check(argument.default) == argument.default


def test_tallies_count_by_reason():
    first = Tally()
    for kind in (Reason.EXTRA, Reason.EXTRA, Reason.NAME):
        first.count(kind)
    assert first.as_dict() == {"extra argument": 2, "unusable name": 1}
    assert first.total == 3


def test_the_reference_has_every_control_once():
    text = "\n".join(text for name, text in osc_pages().items() if name != "index.md")
    for control in REGISTRY:
        assert text.count(f"\n## {control.address}\n") == 1


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("/dance/spred", "/dance/spread"),
        ("/dance/fomation", "/dance/formation"),
        ("/dance/lok/warm", "/dance/look"),
        ("dance/spred/", "/dance/spread"),
        ("/dance/light/key/color", "/dance/light/key/colour"),
        ("/16/fader17", None),
        ("", None),
        ("/dance/" + "x" * 5000, None),
    ],
)
def test_unknown_address_has_a_near_one_or_none(written, meant):
    assert REGISTRY.near(written) == meant


def test_every_known_address_with_one_wrong_letter_is_found():
    for control in REGISTRY:
        name = control.address.removeprefix("/dance/")
        if len(name) > 6:
            near = REGISTRY.near(control.address[:-2] + control.address[-1])
            assert near is not None
            assert near.startswith("/dance/")
