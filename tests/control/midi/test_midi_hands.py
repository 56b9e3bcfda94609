"""Tests of 14-bit faders, bends, pressure, numbered parameters, velocities, switches, and soft takeover."""

import numpy as np
import pytest

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.midi.channel_messages import MAX_14_BIT, ChannelMessageDecoder
from live.control.midi.midi_binding import BadBinding, Binding, merge_bindings
from live.control.midi.midi_mapping import MidiMap
from live.control.registry.registry import Values

TEMPO = "/dance/clock/tempo"


def tempos(midi_map: MidiMap, *messages: tuple[int, ...], time: float = 0.0) -> list[float]:
    found = [event for message in messages for event in midi_map.events(message, time)]
    assert all(isinstance(event, events.SetTempo) for event in found)
    return [event.tempo for event in found if isinstance(event, events.SetTempo)]


def pair(value: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    return (0xB0, 7, value >> 7), (0xB0, 39, value & 127)


def test_controller_pair_has_14_bits_and_is_monotonic() -> None:
    midi_map = MidiMap([Binding("cc", 7, TEMPO, fine=True, scale=(60.0, 180.0))])
    tempos(midi_map, *pair(0))
    for way in (range(0, MAX_14_BIT + 1, 37), range(MAX_14_BIT, -1, -41)):
        ends = [tempos(midi_map, *pair(value))[-1] for value in way]
        assert np.allclose(ends, [60.0 + 120.0 * value / MAX_14_BIT for value in way])
        every = [tempo for value in way for tempo in tempos(midi_map, *pair(value))]
        steps = np.diff(every) * np.sign(way.step)
        assert steps.min() >= -120.0 / MAX_14_BIT * 128 * 1.01  # at most to where the upper bits left it
    assert tempos(midi_map, *pair(MAX_14_BIT))[-1] == 180.0


def test_fader_with_upper_bits_only_reaches_both_ends() -> None:
    midi_map = MidiMap([Binding("cc", 7, TEMPO, fine=True, scale=(60.0, 180.0))])
    assert tempos(midi_map, (0xB0, 7, 0), (0xB0, 7, 127)) == [60.0, 180.0]


def test_pitch_bend_covers_scale_around_its_middle() -> None:
    midi_map = MidiMap([Binding("bend", 0, TEMPO, scale=(100.0, 140.0))])
    assert tempos(midi_map, (0xE3, 0, 0), (0xE3, 0, 64), (0xE3, 127, 127)) == [100.0, 120.0, 140.0]


def test_pressure_and_numbered_parameters_set_numbers() -> None:
    midi_map = MidiMap(
        [Binding("pressure", 0, TEMPO, 2, scale=(60.0, 187.0)), Binding("nrpn", 130, TEMPO, scale=(60.0, 180.0))]
    )
    assert tempos(midi_map, (0xD1, 0), (0xD1, 127), (0xD0, 5)) == [60.0, 187.0]
    choose = ((0xB0, 99, 1), (0xB0, 98, 2))
    assert tempos(midi_map, *choose, (0xB0, 6, 127), (0xB0, 38, 127)) == [180.0, 180.0]
    assert tempos(midi_map, (0xB0, 6, 64), (0xB0, 38, 0))[-1] == pytest.approx(60.0 + 120.0 * 8192 / MAX_14_BIT)
    assert tempos(midi_map, (0xB0, 101, 0), (0xB0, 100, 0), (0xB0, 6, 3)) == []  # a registered one
    assert tempos(midi_map, (0xB0, 99, 1), (0xB0, 98, 3), (0xB0, 6, 3)) == []  # another number


def test_velocity_sets_number_and_momentary_release_resets() -> None:
    held = MidiMap([Binding("note", 36, TEMPO, scale=(60.0, 187.0), velocity=True, mode="momentary")])
    assert tempos(held, (0x90, 36, 127), (0x80, 36, 64), (0x90, 36, 1), (0x90, 36, 0)) == [187.0, 60.0, 61.0, 60.0]
    struck = MidiMap([Binding("note", 36, TEMPO, scale=(60.0, 187.0), velocity=True)])
    assert tempos(struck, (0x90, 36, 127), (0x80, 36, 64)) == [187.0]


def blackout_values(midi_map: MidiMap, *messages: tuple[int, ...]) -> list[bool]:
    found = [event for message in messages for event in midi_map.events(message, 0.0)]
    return [event.on for event in found if isinstance(event, events.Blackout)]


def test_switches_are_momentary_or_toggle_current_value() -> None:
    press, release = (0x90, 36, 9), (0x80, 36, 0)
    dark = "/dance/blackout"
    assert blackout_values(MidiMap([Binding("note", 36, dark, mode="momentary")]), press, release) == [True, False]
    on, off = (0xB0, 80, 127), (0xB0, 80, 0)
    assert blackout_values(MidiMap([Binding("cc", 80, dark, mode="toggle")]), on, off, on, off) == [True, False]
    values = Values()
    midi_map = MidiMap([Binding("note", 36, dark)], values)
    values.update({dark: (("", (True,)),)})  # somebody else has darkened it
    assert blackout_values(midi_map, press, release) == [False]
    values.update({dark: (("", (False,)),)})
    assert blackout_values(midi_map, press, release) == [True]


def test_scale_curves_are_invertible() -> None:
    for curve in (0.5, 1.0, 2.0):
        binding = Binding("cc", 7, TEMPO, scale=(180.0, 60.0), curve=curve)
        assert (binding.value(0.0), binding.value(1.0)) == (180.0, 60.0)
        for share in (0.0, 0.1, 0.5, 0.9, 1.0):
            assert binding.value(share) == pytest.approx(180.0 - 120.0 * share**curve)
            assert binding.position(binding.value(share)) == pytest.approx(share)
        assert (binding.position(400.0), binding.position(20.0)) == (0.0, 1.0)


class FaderDriver:
    """A fader and the show's tempo, which the fader or another source sets."""

    def __init__(self, **options: object) -> None:
        self.values = Values()
        self.map = MidiMap([Binding("cc", 7, TEMPO, scale=(60.0, 187.0), **options)], self.values)  # type: ignore[arg-type]
        self.tempo = 0.0
        self.time = 0.0
        self.set(120.0)

    def set(self, tempo: float) -> None:
        self.tempo = tempo
        self.values.update({TEMPO: (("", (tempo,)),)})

    def move(self, *places: int, wait: float = 0.02) -> list[float]:
        found = []
        for place in places:
            self.time += wait
            for tempo in tempos(self.map, (0xB0, 7, place), time=self.time):
                found.append(tempo)
                self.set(tempo)
        return found


def test_fader_is_ignored_until_crossing_current_value() -> None:
    stage = FaderDriver()
    assert stage.move(0, 20, 40, 57) == []
    assert stage.move(59, 63, 70) == [119.0, 123.0, 130.0]  # two steps from 60 are near enough
    stage.set(100.0)  # somebody else, while the fader still has it
    stage.time += 5.0
    assert stage.move(75, 80, 60) == []
    assert stage.move(30, 20) == [90.0, 80.0]
    stage.set(180.0)
    assert stage.move(21, wait=0.1) == [81.0]  # what was set just now is still on its way: the hand keeps it
    stage.time += 5.0
    assert stage.move(20, wait=0.1) == [80.0]


def test_fader_jump_across_value_takes_over() -> None:
    stage = FaderDriver()
    assert stage.move(10, 110) == [170.0]
    assert FaderDriver(pickup=False).move(10) == [70.0]
    assert MidiMap([Binding("cc", 7, TEMPO)]).events((0xB0, 7, 0), 0.0)  # nobody says where the show is


def test_fader_keeps_control_of_fading_value() -> None:
    rim = "/dance/light/rim"
    for measures, keeps in ((4.0, True), (0.0, False)):
        values = Values()
        midi_map = MidiMap([Binding("cc", 7, rim, values={"measures": measures}, scale=(0.0, 1.27))], values)
        values.update({rim: (("", (0.0,)),)})
        found: list[object] = [midi_map.events((0xB0, 7, place), 0.0) for place in (0, 100)]
        values.update({rim: (("", (0.4,)),)})  # on its way to 1
        found = midi_map.events((0xB0, 7, 102), 3.0)
        assert bool(found) == keeps


def test_group_binding_uses_group_value_for_pickup() -> None:
    values = Values()
    larger = "/dance/motion/larger"
    midi_map = MidiMap([Binding("cc", 7, larger, values={"group": "Tide"})], values)
    values.update({larger: (("ember", (0.5,)), ("tide", (-0.7,)))})
    (found,) = midi_map.events((0xB0, 7, 0), 0.0)
    assert isinstance(found, events.SetParameter)
    assert (found.value, found.group) == ((-0.7,), "Tide")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"kind": "cc", "number": 40, "fine": True}, "fine is for"),
        ({"kind": "note", "number": 4, "fine": True, "velocity": True}, "fine is for"),
        ({"kind": "cc", "number": 4, "velocity": True}, "velocity is for"),
        ({"kind": "cc", "number": 4, "mode": "toggle"}, "mode is for"),
        ({"kind": "nrpn", "number": 16384}, "nrpn 0 to 16383"),
        ({"kind": "bend", "number": 1}, "bend 0 to 0"),
    ],
)
def test_invalid_binding_options_are_refused(options: dict[str, object], told: str) -> None:
    with pytest.raises(BadBinding, match=told):
        Binding(control=TEMPO, **options)  # type: ignore[arg-type]


def test_learned_binding_replaces_written_binding() -> None:
    written = [Binding("cc", 7, TEMPO), Binding("cc", 7, "/dance/blackout", 3), Binding("note", 7, "/dance/go", 3)]
    learned = [Binding("cc", 7, "/dance/light/rim", 3)]
    assert merge_bindings(written, learned) == (written[2], learned[0])
    assert merge_bindings(written[1:], [Binding("cc", 7, TEMPO, 4)])[:2] == tuple(written[1:])
    assert merge_bindings(written, []) == tuple(written)


def test_random_messages_leave_bounded_state() -> None:
    rng = np.random.default_rng(3)
    midi_map = MidiMap()
    for message in rng.integers(-3, 300, (3000, 3)).tolist():
        assert all(isinstance(made, ControlEvent) for made in midi_map.events(message, 0.0))
    hands = ChannelMessageDecoder()
    for number in range(16384):  # each of the numbered parameters once
        for message in ((0xB0, 99, number >> 7), (0xB0, 98, number & 127), (0xB0, 6, 5)):
            hands.decode(message)
    assert len(hands._data) == 1
