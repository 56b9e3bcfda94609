"""Tests of grid controllers: their ports' names, pads and lights, and the window on a show's pads."""

import itertools
from typing import Any

import pytest

from live.control.midi.grid_layout import FUNCTIONS, LAYOUTS, GridLayout, Light, layout_of
from live.control.midi.grid_surface import GridSurface

BY_NAME = {layout.name: layout for layout in LAYOUTS}
LIGHTS: tuple[Light, ...] = ("off", "idle", "waits", "runs", "away", "refused", "dim", "bright")


@pytest.mark.parametrize(
    ("port", "name"),
    [
        ("Launchpad Mini MK3:Launchpad Mini MK3 LPMiniMK3 MI 24:1", "Launchpad Mini MK3"),
        ("Launchpad Mini MK3:Launchpad Mini MK3 LPMiniMK3 DA 24:0", None),
        ("LPMiniMK3 MIDI Out", "Launchpad Mini MK3"),
        ("LPMiniMK3 DAW Out", None),
        ("Launchpad X:Launchpad X LPX MIDI In 28:1", "Launchpad X"),
        ("MIDIIN2 (LPX MIDI)", "Launchpad X"),
        ("LPProMK3 MIDI", "Launchpad Pro MK3"),
        ("Launchpad MK2:Launchpad MK2 MIDI 1 20:0", "Launchpad MK2"),
        ("Launchpad Mini:Launchpad Mini MIDI 1 20:0", "Launchpad"),
        ("Launchpad S", "Launchpad"),
        ("APC MINI:APC MINI MIDI 1 20:0", "APC Mini"),
        ("APC mini mk2 Control", "APC Mini mk2"),
        ("APC mini mk2 Notes", None),
        ("APC40 mkII:APC40 mkII MIDI 1 20:0", "APC40 mkII"),
        ("Launchkey Mini MK3", None),
        ("Launch Control XL", None),
        ("piano", None),
    ],
)
def test_a_controller_is_known_by_the_name_of_its_port(port: str, name: str | None) -> None:
    layout = layout_of(port)
    assert (layout and layout.name) == name


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.name)
def test_every_pad_and_button_has_its_own_place_and_valid_lights(layout: GridLayout) -> None:
    places = set(itertools.product(range(layout.rows), range(layout.columns)))
    assert set(layout.pads.values()) == places
    assert not set(layout.pads) & set(layout.buttons)
    assert set(layout.buttons.values()) <= set(FUNCTIONS)
    assert {"up", "down", "left", "right", "now", "beat", "measure", "section", "stop"} <= set(layout.buttons.values())
    for address in (*layout.pads, *layout.buttons):
        for light, hue in itertools.product(LIGHTS, (None, 0.0, 0.1, 0.5, 0.99)):
            message = layout.light(address, light, hue)
            assert len(message) == 3
            assert message[0] >> 4 in (0x9, 0xB)
            assert max(message[1:]) < 128
        assert layout.press([*address, 100]) == (address, True)
        assert layout.press([*address, 0]) == (address, False)
    lights = {light: layout.colours(light, 0.5) for light in ("off", "idle", "runs", "refused")}  # type: ignore[arg-type]
    assert len(set(lights.values())) == 4
    for message in ([0x90, 127, 127][:2], [0xF8], [0xF0, 0, 0, 0xF7], [0xE0, 1, 1], [0x9F, 11, 1]):
        assert layout.press(message) is None


def test_the_makers_numbers() -> None:
    """Corners and messages as in the programmers' references."""
    mini, old, apc, new = (BY_NAME[name] for name in ("Launchpad Mini MK3", "Launchpad", "APC Mini", "APC Mini mk2"))
    assert mini.begin == bytes.fromhex("F0 00 20 29 02 0D 0E 01 F7")
    assert BY_NAME["Launchpad X"].begin == bytes.fromhex("F0 00 20 29 02 0C 0E 01 F7")
    assert [mini.pads[0x90, number] for number in (81, 88, 11, 18)] == [(0, 0), (0, 7), (7, 0), (7, 7)]
    assert [mini.buttons[0xB0, number] for number in (91, 98, 89, 19)] == ["up", "section", "own", "stop"]
    assert [old.pads[0x90, number] for number in (0, 7, 112, 119)] == [(0, 0), (0, 7), (7, 0), (7, 7)]
    assert (old.buttons[0x90, 8], old.buttons[0x90, 120], old.buttons[0xB0, 104]) == ("own", "stop", "up")
    assert [apc.pads[0x90, number] for number in (56, 63, 0, 7)] == [(0, 0), (0, 7), (7, 0), (7, 7)]
    assert (apc.buttons[0x90, 64], apc.buttons[0x90, 82], new.buttons[0x90, 112]) == ("up", "own", "own")
    assert new.light((0x90, 56), "runs", 0.0) == bytes((0x96, 56, 5))  # bright red
    assert apc.press([0x80, 56, 127]) == ((0x90, 56), False)


GRID = BY_NAME["Launchpad Mini MK3"]
NUMBER = {place: address for address, place in GRID.pads.items()}
BUTTON = {name: address for address, name in GRID.buttons.items()}


def surface(steps: int = 20, groups: int = 10) -> GridSurface:
    made = GridSurface()
    made.columns = ["*", *(f"g{number}" for number in range(groups))]
    made.hues = {"*": None, "g0": 0.33}
    names = [f"s{number}" for number in range(steps)]
    made.pads = {
        "step": [{"pad": f"step {name}", "kind": "step", "name": name} for name in names],
        "own": [{"pad": "own first", "kind": "step", "name": "first", "does": "s3"}],
        "look": [{"pad": "scene dusk", "kind": "scene", "name": "dusk"}],
    }
    return made


def press(made: GridSurface, *names: Any) -> list[Any]:
    """Press and let go each; return the commands."""
    found = []
    for name in names:
        address = BUTTON[name] if isinstance(name, str) else NUMBER[name]
        found += [made.press(GRID, address, down) for down in (True, False)]
    return [call for call in found if call is not None]


def test_a_pad_launches_what_the_page_has_in_the_same_place() -> None:
    made = surface()
    assert press(made, (0, 0), (2, 1)) == [
        ("/dance/launch", ("step s0", "*", "measure")),
        ("/dance/launch", ("step s2", "g0", "measure")),
    ]
    assert press(made, "section", (7, 7)) == [("/dance/launch", ("step s7", "g6", "section"))]
    assert press(made, "down", "right", "beat", (0, 0)) == [("/dance/launch", ("step s8", "g7", "beat"))]
    assert press(made, "down", "down", (3, 2)) == [("/dance/launch", ("step s19", "g9", "beat"))]
    assert press(made, (4, 2), (3, 3)) == []  # nothing is there
    assert press(made, "up", "up", "up", "left", "left", "own", (0, 0), (1, 0)) == [
        ("/dance/launch", ("own first", "*", "beat"))
    ]
    assert press(made, "look", (0, 1), (0, 0)) == [("/dance/launch", ("scene dusk", "*", "beat"))]
    assert press(made, "phrase", (0, 0), "undo") == [("/dance/undo", ())]


def test_stop_alone_stops_everything_and_held_the_column_of_a_pad() -> None:
    made = surface()
    assert press(made, "stop") == [("/dance/launch/stop", ("*",))]
    assert made.press(GRID, BUTTON["stop"], True) is None
    assert made.press(GRID, NUMBER[5, 1], True) == ("/dance/launch/stop", ("g0",))
    assert made.press(GRID, NUMBER[5, 1], False) is None
    assert made.press(GRID, BUTTON["stop"], False) is None
    assert press(made, (0, 0)) == [("/dance/launch", ("step s0", "*", "measure"))]


def test_lights_say_what_waits_runs_and_cannot_follow() -> None:
    made = surface(steps=5, groups=1)
    row = {"who": "G0", "due": 4.0}
    told = {
        "launches": [
            {**row, "pad": "step s0", "state": "runs"}, {**row, "pad": "step s1", "state": "runs"},
            {**row, "pad": "step s1", "state": "waits"}, {**row, "pad": "step s2", "state": "refused"},
        ],
        "away": {"*": {}, "g0": {"s3": 1, "s0": 1}},
    }  # fmt: skip

    def column(number: int, on: bool) -> list[str]:
        lights = made.lights(GRID, told, on=on)
        return [lights[NUMBER[row, number]][0] for row in range(6)]

    assert column(1, True) == ["runs", "waits", "refused", "away", "idle", "off"]
    assert column(1, False)[1] == "off"  # it blinks
    assert column(0, True) == ["idle"] * 5 + ["off"]
    assert column(2, True) == ["off"] * 6
    lights = made.lights(GRID, told, on=True)
    assert lights[NUMBER[4, 1]] == ("idle", 0.33)
    assert lights[BUTTON["stop"]][0] == "refused"
    assert {name for name in BUTTON if lights[BUTTON[name]][0] == "bright"} == {"measure", "step"}
    assert made.lights(GRID, {}, on=True)[BUTTON["stop"]][0] == "dim"
