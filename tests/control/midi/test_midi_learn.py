"""Tests of MIDI learn: which controller a gesture selects."""

import random

import pytest

from live.control.midi.channel_messages import ChannelMessageDecoder
from live.control.midi.midi_binding import BadBinding, Binding
from live.control.midi.midi_learn import MidiLearn, parse_values

TEMPO, LARGER, SCENE, DARK = "/dance/clock/tempo", "/dance/motion/larger", "/dance/scene", "/dance/blackout"


def learn(address: str, given: str, *messages: tuple[int, ...]) -> Binding | None:
    hands, learning = ChannelMessageDecoder(), MidiLearn(address, parse_values(address, given.splitlines()))
    found = [learning.process(hands.decode(message)) for message in messages]
    assert not any(found[:-1])  # with the last message, and not before
    return found[-1]


def test_fader_is_learned_after_enough_movement() -> None:
    moves = [(0xB2, 21, place) for place in (60, 61, 62, 64, 67)]
    assert learn(TEMPO, "", *moves) == Binding("cc", 21, TEMPO, 3)
    assert learn(TEMPO, "", *moves[:-1]) is None


def test_controller_noise_is_not_learned() -> None:
    rng = random.Random(1)
    noise = [(0xB0, 10 + rng.randrange(8), 64 + rng.randrange(2)) for _ in range(200)]
    assert learn(TEMPO, "", *noise, (0xE1, 0, 64), (0xF8,), (0xFE,), (0xE1, 0, 60), (0xE1, 0, 50)) == Binding(
        "bend", 0, TEMPO, 2
    )


def test_fine_pair_is_recognized_by_second_controller() -> None:
    messages = []
    for value in range(8000, 9000, 150):
        messages += [(0xB0, 1, value >> 7), (0xB0, 33, value & 127)]
    hands, learning = ChannelMessageDecoder(), MidiLearn(TEMPO, {})
    found = [binding for message in messages if (binding := learning.process(hands.decode(message)))]
    assert found[0] == Binding("cc", 1, TEMPO, 1, fine=True)
    assert learn(TEMPO, "", *[(0xB0, 40, place) for place in (1, 2, 9)]) == Binding("cc", 40, TEMPO, 1)


def test_pads_and_buttons_are_learned_immediately() -> None:
    assert learn(SCENE, "chorus", (0x99, 36, 3)) == Binding("note", 36, SCENE, 10, {"name": "chorus"})
    assert learn(DARK, "", (0xB0, 80, 127)) == Binding("cc", 80, DARK, 1)
    assert learn("/dance/go", "", (0xC5, 4)) == Binding("program", 4, "/dance/go", 6)
    assert learn(TEMPO, "", (0xB0, 80, 127), (0xB0, 80, 0)) == Binding("cc", 80, TEMPO, 1)  # a button at both ends
    assert learn(TEMPO, "", (0x90, 36, 5)) == Binding("note", 36, TEMPO, 1, velocity=True)


def test_releases_and_data_entry_are_not_learned() -> None:
    entry = [(0xB0, 99, 0), (0xB0, 98, 3), (0xB0, 6, 0), (0xB0, 6, 50)]
    assert learn(TEMPO, "", (0x80, 36, 5), (0xC5, 4), *entry) == Binding("nrpn", 3, TEMPO, 1)


def test_values_are_parsed_by_position_or_name() -> None:
    assert parse_values(LARGER, ["ember"]) == {"group": "ember"}
    assert parse_values(LARGER, ["group=ember"]) == {"group": "ember"}
    assert parse_values("/dance/clock/nudge", ["seconds=-0.02"]) == {"seconds": -0.02}
    assert parse_values(DARK, ["on=yes"]) == {"on": True}
    assert parse_values(SCENE, ["a=b", "measures=2"]) == {"name": "a=b", "measures": 2.0}


@pytest.mark.parametrize(
    ("address", "given", "told"),
    [
        ("/dance/clock/tenpo", "", "/dance/clock/tempo"),
        ("nowhere", "", "there are"),
        (TEMPO, "ember", "name=value"),
        ("/dance/clock/nudge", "seconds=soon", "seconds .* expected"),
        (SCENE, "", "needs a value"),
        (SCENE, "chorus\nmeasures=-3", "measures -1 to"),
    ],
)
def test_impossible_learn_request_is_refused(address: str, given: str, told: str) -> None:
    with pytest.raises(BadBinding, match=told):
        MidiLearn(address, parse_values(address, given.splitlines()))
