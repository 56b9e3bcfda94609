"""Tests of the mapping from notes, controllers and program changes to controls."""

import pytest

from live.control.events import events
from live.control.midi.midi_binding import DEFAULTS, BadBinding, Binding
from live.control.midi.midi_mapping import MidiMap
from live.show.patch.midi_bindings import bindings_of
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError

PATCH = 'name = "p"\n[[group]]\nname = "ember"\ndancers = 2\nsteps = ["walk"]\n'


def single_event(midi_map: MidiMap, message: tuple[int, ...]) -> events.ControlEvent:
    (event,) = midi_map.events(message, 2.5)
    assert isinstance(event, events.ControlEvent)
    assert (event.time, event.source) == (2.5, "midi")
    return event


def test_foot_switch_taps_by_default() -> None:
    midi_map = MidiMap()
    assert isinstance(single_event(midi_map, (0xB3, 64, 127)), events.Tap)
    assert midi_map.events((0xB3, 64, 90), 0.0) == []  # still down
    assert midi_map.events((0xB3, 64, 0), 0.0) == []
    assert isinstance(single_event(midi_map, (0xB3, 64, 64)), events.Tap)


def test_manual_clock_controls_use_channel_16() -> None:
    midi_map = MidiMap()
    assert isinstance(single_event(midi_map, (0x9F, 37, 1)), events.One)
    assert midi_map.events((0x99, 36, 100), 0.0) == []  # a drum machine's kick
    assert midi_map.events((0x9F, 36, 0), 0.0) == []  # a note-off
    nudges = [single_event(midi_map, (0x9F, key, 1)) for key in (41, 42)]
    assert [nudge.seconds for nudge in nudges if isinstance(nudge, events.Nudge)] == [-0.01, 0.01]
    held = [single_event(midi_map, (0x9F, 40, 1)) for _ in range(2)]
    assert [hold.on for hold in held if isinstance(hold, events.HoldTempo)] == [True, False]
    scaled = [single_event(midi_map, (0x9F, key, 1)) for key in (38, 39)]
    assert [scale.factor for scale in scaled if isinstance(scale, events.ScaleTempo)] == [0.5, 2.0]
    assert len(DEFAULTS) == 13


def test_controllers_set_scaled_numbers_and_switches() -> None:
    midi_map = MidiMap(
        [
            Binding("cc", 7, "/dance/clock/tempo", scale=(60.0, 187.0)),
            Binding("cc", 8, "/dance/clock/metre"),
            Binding("cc", 9, "/dance/blackout"),
            Binding("program", 3, "/dance/clock/source", 2, {"name": "audio"}),
        ]
    )
    tempos = [single_event(midi_map, (0xB0, 7, value)) for value in (0, 64, 127)]
    assert [tempo.tempo for tempo in tempos if isinstance(tempo, events.SetTempo)] == [60.0, 124.0, 187.0]
    assert isinstance(single_event(midi_map, (0xB0, 8, 127)), events.SetMetre)
    dark = [single_event(midi_map, (0xB0, 9, value)) for value in (127, 0)]
    assert [event.on for event in dark if isinstance(event, events.Blackout)] == [True, False]
    chosen = single_event(midi_map, (0xC1, 3))
    assert isinstance(chosen, events.ChooseSource)
    assert chosen.name == "audio"
    assert midi_map.events((0xC0, 3), 0.0) == []  # another channel


@pytest.mark.parametrize("message", [(), (0x90,), (0x90, 36), (0x90, 200, 3), (0xB0, 7), (0xF8,), (0x36, 1, 1)])
def test_broken_messages_give_no_events(message: tuple[int, ...]) -> None:
    assert MidiMap().events(message, 0.0) == []


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ('note = 36\ncontrol = "/dance/clock/tab"', "there are"),
        ('control = "/dance/clock/tap"', "one of note, cc and program"),
        ('note = 36\ncc = 2\ncontrol = "/dance/clock/tap"', "one of note, cc and program"),
        ('note = 36\ncontrol = "/dance/clock/tempo"', "values = { tempo"),
        ('note = 36\ncontrol = "/dance/clock/tempo"\nvalues = { tempo = 900 }', "tempo 20 to 400"),
        ('note = 36\ncontrol = "/dance/clock/tempo"\nvalues = { tmpo = 90 }', "it has tempo"),
        ('cc = 7\ncontrol = "/dance/clock/tempo"\nscale = [10, 90]', "scale"),
        ('note = 7\ncontrol = "/dance/clock/tap"\nscale = [10, 90]', "scale is for controllers"),
        ('note = 128\ncontrol = "/dance/clock/tap"', "128"),
        ('note = 1\nchannel = 17\ncontrol = "/dance/clock/tap"', "17"),
    ],
)
def test_errors_name_file_line_and_remedy(line: str, told: str) -> None:
    with pytest.raises(PatchError, match=r"show\.toml, line \d+: midi\.map\.1") as caught:
        parse_patch(f"{PATCH}\n[[midi.map]]\n{line}\n", "show.toml")
    assert told in caught.value.message


def test_patch_map_replaces_the_defaults() -> None:
    own = parse_patch(f'{PATCH}[[midi.map]]\nnote = 60\ncontrol = "/dance/clock/tap"\n', "p")
    assert bindings_of(own.midi) == (Binding("note", 60, "/dance/clock/tap"),)
    assert bindings_of(parse_patch(PATCH, "p").midi) == DEFAULTS
    assert bindings_of(parse_patch(f"{PATCH}[midi]\ndefaults = false\n", "p").midi) == ()


def test_binding_to_unknown_control_is_refused() -> None:
    with pytest.raises(BadBinding):
        Binding("note", 1, "nowhere")
