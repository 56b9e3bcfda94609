import pytest

from live.control.events import events
from live.control.keyboard import FORMATION_KEYS, KEYS, event_for_formation, event_for_key, help_lines
from live.control.pointer import TOOLS
from live.control.registry.registry import REGISTRY


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("Space", events.Tap),
        ("1", events.One),
        ("M", events.RestartAudio),
    ],
)
def test_keys_create_their_events(name, kind):
    assert event_for_key(name, time=3.5, blackout_now=False) == kind(time=3.5, source="key")


@pytest.mark.parametrize("name", ["S", "s"])
def test_s_key_spreads(name):
    event = event_for_key(name, time=3.5, blackout_now=False)
    assert event == events.PlaceElement(time=3.5, source="key", kind="spread")


def test_b_key_toggles_blackout():
    assert event_for_key("B", time=1.0, blackout_now=False) == events.Blackout(time=1.0, source="key", on=True)
    assert event_for_key("B", time=1.0, blackout_now=True) == events.Blackout(time=1.0, source="key", on=False)


@pytest.mark.parametrize("name", ["F", "O", "Esc", "Escape", "F12", "", "space\0"])
def test_window_and_unknown_keys_create_no_event(name):
    assert event_for_key(name, time=1.0, blackout_now=False) is None


def test_esc_is_not_a_key_of_the_show():
    assert not any(name.lower().startswith("esc") for name in KEYS)


def test_every_show_key_uses_a_control():
    addresses = {control.address for control in REGISTRY}
    for name, key in KEYS.items():
        assert key.is_control == (key.command in addresses)
        assert (event_for_key(name, time=0.0, blackout_now=True) is not None) == key.is_control
    others = {key.command for key in KEYS.values() if not key.is_control}
    assert others == {f"window/{what}" for what in ("fullscreen", "overlay", "guides", "card", "edit")}


def test_digit_key_starts_formation_at_next_measure():
    assert event_for_formation("wedge", time=3.0) == events.Evolve(
        time=3.0, source="key", formation="wedge", measures=4.0, next=True
    )


def test_the_help_names_every_key():
    lines = help_lines(["wedge", "star"])
    assert len(lines) == len(KEYS) + len(TOOLS) + 2
    for name, key in KEYS.items():
        assert any(line.startswith(name) and line.endswith(key.description) for line in lines)
    assert "3      formation star" in lines
    assert not set(KEYS) & (set(TOOLS) | set(FORMATION_KEYS))
