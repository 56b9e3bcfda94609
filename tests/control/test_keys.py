import math

import numpy as np
import pytest

from live.control import events
from live.control.keys import KEYS, event_for_key, event_for_pointer, help_lines
from live.control.registry import REGISTRY


@pytest.mark.parametrize(
    ("name", "kind"),
    [("Space", events.Tap), ("1", events.One), ("S", events.Spread), ("s", events.Spread)],
)
def test_keys_make_their_events(name, kind):
    assert event_for_key(name, time=3.5, blackout_now=False) == kind(time=3.5, source="key")


def test_b_turns_the_light_out_and_back():
    assert event_for_key("B", time=1.0, blackout_now=False) == events.Blackout(time=1.0, source="key", on=True)
    assert event_for_key("B", time=1.0, blackout_now=True) == events.Blackout(time=1.0, source="key", on=False)


@pytest.mark.parametrize("name", ["F", "O", "Esc", "Escape", "Q", "", "space\0"])
def test_keys_of_the_window_and_unknown_keys_leave_the_show_alone(name):
    assert event_for_key(name, time=1.0, blackout_now=False) is None


def test_esc_is_not_a_key_of_the_show():
    assert not any(name.lower().startswith("esc") for name in KEYS)


def test_every_key_of_the_show_uses_a_control_and_makes_an_event():
    addresses = {control.address for control in REGISTRY}
    for name, key in KEYS.items():
        assert key.is_control == (key.what in addresses)
        assert (event_for_key(name, time=0.0, blackout_now=True) is not None) == key.is_control


def test_the_pointer_attracts_and_with_shift_repels():
    assert event_for_pointer(1.5, -2.0, False, 4.0) == events.Attract(time=4.0, source="pointer", x=1.5, z=-2.0)
    assert event_for_pointer(1.5, -2.0, True, 4.0) == events.Repel(time=4.0, source="pointer", x=1.5, z=-2.0)


def test_numpys_floats_serve_as_well():
    event = event_for_pointer(np.float32(1.5), np.float64(-2.0), False, 4.0)
    assert event == events.Attract(time=4.0, source="pointer", x=1.5, z=-2.0)
    assert type(event.x) is type(event.z) is float


@pytest.mark.parametrize(("x", "z"), [(math.nan, 0.0), (0.0, math.inf), (1e9, 0.0), (0.0, -100.5)])
def test_a_click_beside_the_floor_makes_nothing(x, z):
    assert event_for_pointer(x, z, False, 4.0) is None


def test_the_help_names_every_key():
    lines = help_lines()
    assert len(lines) == len(KEYS) + 2
    for name, key in KEYS.items():
        assert any(line.startswith(name) and line.endswith(key.description) for line in lines)
