"""Tests of mutated and flooding MIDI: no exceptions, bounded state, and no loss for other sources."""

import random

from live.base.event_queue import EventQueue
from live.clock.note_energy import NoteEnergy
from live.clock.time_source import ManualClock
from live.control.events.events import Blackout, ControlEvent, Go, SetParameter, Tap
from live.control.midi.midi_binding import Binding
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_learn import MidiLearn
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_streams import MidiTokenizer
from live.control.registry.control import ROLE_RANKS

RIM, DARK = "/dance/light/rim", "/dance/blackout"
BINDINGS = (
    Binding("cc", 1, RIM, fine=True),
    Binding("cc", 7, RIM),
    Binding("nrpn", 5, RIM),
    Binding("bend", 0, RIM),
    Binding("pressure", 0, RIM),
    Binding("note", 36, RIM, velocity=True, mode="momentary"),
    Binding("note", 37, DARK),
    Binding("note", 38, "/dance/go"),
    Binding("program", 3, DARK),
)


def test_mutated_bytes_leave_every_decoder_working() -> None:
    rng = random.Random(12)
    inbox: EventQueue[ControlEvent] = EventQueue()
    midi_map = MidiMap(BINDINGS)
    listens = MidiInput("box", inbox, ManualClock(), midi_map=midi_map, notes=NoteEnergy())
    good = bytes.fromhex(
        "fa f8 90 24 40 25 41 f8 b0 07 10 11 b0 63 00 b0 62 05 06 40 26 01 e0 00 40 f8 d0 30 c0 03 f1 05 f2 01 02"
        "fb fc fe f0 7f 7f 01 01 21 02 03 04 f7 b0 01 40 21 03 80 24 00 ff"
    )
    cutter, time, heard = MidiTokenizer(), 0.0, 0
    for turn in range(200):
        data = bytearray(good)
        for _ in range(turn % 12):
            data[rng.randrange(len(data))] = rng.randrange(256)
        if turn % 40 == 0:
            listens.learning = MidiLearn(RIM, {})
        for message in cutter.feed(data):
            time += rng.choice((0.0, 0.001, 0.02))
            listens._decode_safely(message, time)
            heard += 1
        listens._advance_safely(time)
    assert (listens.failed, listens.failure) == (0, "")
    assert heard > 2500
    assert cutter.rejected > 50
    events = inbox.drain()
    assert {type(event) for event in events} >= {SetParameter, Blackout}
    for kept in (midi_map.last_positions, midi_map._pickups, midi_map._switches, midi_map._pressed):
        assert len(kept) <= 16 * len(BINDINGS)


def test_fader_flood_does_not_drop_other_events() -> None:
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("box", inbox.add_queue(rank=ROLE_RANKS["musician"]), ManualClock(), midi_map=MidiMap(BINDINGS))
    inbox.put(Tap(time=0.0, source="key"))
    for turn in range(7_000):
        listens.decode((0xB0, 7, turn % 128), 0.0)
    listens.decode((0x90, 37, 1), 0.0)
    for turn in range(7_000):
        listens.decode((0xFA,) if turn % 2 else (0xFC,), 0.0)
    assert inbox.dropped > 2_000  # of its own lane
    events = inbox.drain()
    assert isinstance(events[0], Tap)
    assert len(events) <= 4097


def test_last_fader_value_is_kept_and_pads_keep_order() -> None:
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("box", inbox.add_queue(rank=ROLE_RANKS["musician"]), ManualClock(), midi_map=MidiMap(BINDINGS))
    for place in range(100):
        listens.decode((0xB0, 7, place), 0.0)
    listens.decode((0x90, 38, 1), 0.0)
    listens.decode((0xB0, 7, 127), 0.0)
    first, go, last = inbox.drain()
    assert isinstance(first, SetParameter)
    assert isinstance(go, Go)
    assert isinstance(last, SetParameter)
    assert first.value[0] < last.value[0] == 4.0


def test_operator_outranks_musician_on_same_value() -> None:
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("box", inbox.add_queue(rank=ROLE_RANKS["musician"]), ManualClock(), midi_map=MidiMap(BINDINGS))
    operator = inbox.add_queue(rank=ROLE_RANKS["operator"])
    listens.decode((0xB0, 7, 1), 0.0)
    operator.put(SetParameter(time=0.0, source="osc", address=RIM, value=(0.5,)), (RIM,))
    inbox.drain(now=1.0)
    listens.decode((0xB0, 7, 2), 1.01)
    assert inbox.drain(now=1.02) == []
    assert inbox.outranked == 1
    listens.decode((0xB0, 7, 3), 2.0)
    assert len(inbox.drain(now=2.0)) == 1
