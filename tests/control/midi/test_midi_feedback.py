"""Tests of feedback to pads and motor faders: current values, bounded rate, and no echo during moves."""

from live.control.midi.midi_binding import Binding
from live.control.midi.midi_feedback import MAX_BINDINGS, MOVE_HOLD, UPDATE_INTERVAL, MidiFeedback
from live.control.midi.midi_mapping import MidiMap
from live.control.registry.registry import Values

RIM, DARK, TEMPO = "/dance/light/rim", "/dance/blackout", "/dance/clock/tempo"


class FeedbackDriver:
    """A MIDI map, its feedback, and the show's values."""

    def __init__(self, *bindings: Binding) -> None:
        self.values = Values()
        self.map = MidiMap(bindings, self.values)
        self.feedback = MidiFeedback(self.map, self.values)
        self.feedback.set_bindings(bindings)
        self.time = 10.0

    def set(self, address: str, value: float | bool) -> None:
        changes = {address: (("", (value,)),)}
        self.values.update(changes)
        self.feedback.mark_changed(changes)

    def after(self, seconds: float = UPDATE_INTERVAL) -> list[bytes]:
        self.time += seconds
        return self.feedback.due_messages(self.time)


def test_changed_values_are_sent_once_to_faders_and_pads() -> None:
    desk = FeedbackDriver(
        Binding("cc", 7, RIM, 3, scale=(0.0, 1.27)),
        Binding("cc", 1, TEMPO, fine=True, scale=(60.0, 180.0)),
        Binding("note", 36, DARK, 10, lit=(3, 60)),
        Binding("bend", 0, TEMPO, 2, scale=(60.0, 180.0)),
        Binding("nrpn", 130, TEMPO, scale=(60.0, 180.0)),
        Binding("program", 1, "/dance/go"),
    )
    assert desk.after() == []  # nothing is known
    desk.set(RIM, 0.64)
    assert desk.after() == [b"\xb2\x07\x40"]
    desk.set(RIM, 0.6401)
    assert desk.after() == []
    desk.set(DARK, True)
    assert desk.after() == [b"\x99\x24\x3c"]
    desk.set(DARK, False)
    assert desk.after() == [b"\x99\x24\x03"]
    desk.set(TEMPO, 120.0)
    assert desk.after() == [
        b"\xb0\x01\x40", b"\xb0\x21\x00", b"\xe1\x00\x40",
        b"\xb0\x63\x01", b"\xb0\x62\x02", b"\xb0\x06\x40", b"\xb0\x26\x00",
    ]  # fmt: skip
    desk.feedback.resend_all()
    assert len(desk.after()) == 9


def test_moved_fader_gets_no_feedback_until_released() -> None:
    desk = FeedbackDriver(Binding("cc", 7, RIM, scale=(0.0, 1.27), pickup=False))
    desk.set(RIM, 0.1)
    assert desk.after() == [b"\xb0\x07\x0a"]
    desk.map.events((0xB4, 7, 50), desk.time)
    desk.set(RIM, 0.5)
    assert desk.after() == []
    assert desk.after(MOVE_HOLD) == []  # it stands where it belongs
    desk.map.events((0xB4, 7, 80), desk.time)
    desk.set(RIM, 0.3)  # the show went elsewhere
    assert desk.after(MOVE_HOLD / 2) == []
    assert desk.after(MOVE_HOLD) == [b"\xb4\x07\x1e"]  # on the channel on which it was moved
    assert desk.after(MOVE_HOLD) == []
    desk.set(RIM, 0.1)
    assert desk.after() == [b"\xb4\x07\x0a"]


def test_fader_without_pickup_is_sent_back() -> None:
    desk = FeedbackDriver(Binding("cc", 7, RIM, scale=(0.0, 1.27)))
    desk.set(RIM, 1.0)
    assert desk.after() == [b"\xb0\x07\x64"]
    assert desk.map.events((0xB0, 7, 20), desk.time) == []
    assert desk.after(MOVE_HOLD / 2) == []
    assert desk.after(MOVE_HOLD) == [b"\xb0\x07\x64"]


def test_pad_receives_feedback_of_its_own_press() -> None:
    desk = FeedbackDriver(Binding("note", 36, DARK))
    desk.set(DARK, False)
    desk.after()
    assert desk.map.events((0x92, 36, 90), desk.time)
    desk.set(DARK, True)
    assert desk.after() == [b"\x92\x24\x7f"]  # on the channel on which it was played


def test_updates_per_turn_are_bounded_and_complete() -> None:
    desk = FeedbackDriver(*(Binding("cc", number, RIM, channel) for channel in (1, 2) for number in range(64, 120)))
    desk.set(RIM, 0.5)
    first = desk.after()
    assert len(first) == MAX_BINDINGS
    assert desk.after(UPDATE_INTERVAL / 2) == []
    rest = [message for _ in range(4) for message in desk.after()]
    assert len({message[:2] for message in first + rest}) == 112
    assert desk.feedback.sent == 112
