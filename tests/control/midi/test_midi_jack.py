"""Tests of MIDI over real ports: two programs on a private JACK server."""

import threading

import numpy as np
import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import SystemClock
from live.clock.timeline import Timeline
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged, Tap
from live.control.midi import midi_ports
from live.control.midi.midi_clock_output import MidiClockOutput
from live.control.midi.midi_feedback import MidiOutput
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_ports import UnknownPort, find_port, open_port
from tests.control.midi.jack import JackPeer, JackServer, jack_server  # noqa: F401 - a fixture
from tests.control.waiting import wait_for

pytestmark = pytest.mark.usefixtures("jack_server")


def sender(name: str, port: str = "out") -> JackPeer:
    return JackPeer(name, port, "sends")


def test_port_is_found_by_part_of_name() -> None:
    box = sender("drumbox")
    try:
        assert find_port("input", "DRUM") == "drumbox:out"
        with pytest.raises(UnknownPort, match="drumbox:out"):
            find_port("input", "piano")
    finally:
        box.close()


def test_messages_are_received_and_lost_port_is_reopened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.2)
    inbox: EventQueue[ControlEvent] = EventQueue()
    box = sender("footswitch")
    listens = MidiInput("footswitch", inbox, SystemClock(), midi_map=MidiMap())
    listens.start()
    try:
        assert wait_for(lambda: listens.connected == "footswitch:out", 10.0)
        for message in ([0xB0, 64, 127], [0xFA], [0xF8], [0xF8], [0xFE]):
            box.send(message)
        assert wait_for(lambda: listens.messages == 5, 10.0)
        box.close()
        assert wait_for(lambda: listens.connected == "", 10.0)
        box = sender("footswitch")
        assert wait_for(lambda: listens.connected == "footswitch:out", 10.0)
        box.send([0xB0, 64, 0])
        box.send([0xB0, 64, 127])
        assert wait_for(lambda: listens.messages == 7, 10.0)
    finally:
        listens.stop()
        box.close()
    events = inbox.drain()
    assert sum(isinstance(event, Tap) for event in events) == 2
    assert any(isinstance(event, BeatHeard) and event.jump for event in events)
    assert [event.state for event in events if isinstance(event, SourceChanged)][-1] == "lost"


@pytest.mark.long
def test_replugged_controller_with_new_number_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Port names of ALSA's bridge to JACK; the port is replugged faster than the check interval."""
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.2)
    names = ["Pad [24] (capture)- Pad MIDI 1", "Pad [31] (capture)- Pad MIDI 1"]
    inbox: EventQueue[ControlEvent] = EventQueue()
    box = sender("a2j", names[0])
    listens = MidiInput(f"a2j:{names[0]}", inbox, SystemClock(), midi_map=MidiMap())
    listens.start()
    try:
        assert wait_for(lambda: listens.connected == f"a2j:{names[0]}", 10.0)
        box.close()
        box = sender("a2j", names[1])
        assert wait_for(lambda: listens.connected == f"a2j:{names[1]}", 10.0)
        box.send([0xB0, 64, 127])
        assert wait_for(lambda: listens.messages == 1, 10.0)
    finally:
        listens.stop()
        box.close()
    assert [type(event) for event in inbox.drain()] == [Tap]


@pytest.mark.long
def test_burst_is_received_whole_while_python_is_busy() -> None:
    box, received, done = sender("keyboard"), list[bytes](), threading.Event()
    sent = [[0x90, key, velocity] for velocity in range(1, 6) for key in range(100)]

    def busy() -> None:
        while not done.is_set():
            sum(range(10_000))

    busy_threads = [threading.Thread(target=busy) for _ in range(3)]
    port = open_port("input", "keyboard")
    try:
        port.listen(lambda message: received.append(bytes(message)))
        for thread in busy_threads:
            thread.start()
        box.send(*sent)
        assert wait_for(lambda: len(received) >= len(sent), 20.0)
        assert received == [bytes(message) for message in sent]
    finally:
        done.set()
        port.close()
        box.close()


@pytest.mark.long
def test_pad_feedback_is_received_at_port(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.2)
    found: list[list[int]] = []

    def plugged_in() -> JackPeer:
        return JackPeer("pads", "in", "receives", found.append)

    pads = plugged_in()
    tells = MidiOutput("pads", SystemClock())
    tells.start()
    try:
        for opened in (1, 2):
            assert wait_for(lambda opened=opened: tells.opened == opened, 10.0)  # type: ignore[misc]
            tells.send(b"\x90\x24\x7f")
            assert wait_for(lambda: found == [[0x90, 0x24, 0x7F]], 10.0)
            found.clear()
            pads.close()
            assert wait_for(lambda: not tells.connected, 10.0)
            pads = plugged_in()
    finally:
        tells.stop()
        pads.close()


@pytest.mark.long
def test_sent_clock_is_received_at_same_beat(monkeypatch: pytest.MonkeyPatch) -> None:
    """Clock out to clock in: tempo, phase and measure match the timeline, also after a tempo change."""
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.2)
    clock = SystemClock()
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("synth", inbox, clock)
    bus = JackPeer("synth", "in", "receives", listens.receive)
    sends = MidiClockOutput("synth", clock)
    sends.set_timeline(Timeline(tempo=180.0))
    sends.start()
    try:
        assert wait_for(lambda: sends.sent > 150, 15.0)
        now = clock.now()
        faster = Timeline(tempo=180.0).with_tempo(200.0, now)
        sends.set_timeline(faster)
        sent = sends.sent
        assert wait_for(lambda: sends.sent > sent + 200, 15.0)
    finally:
        sends.stop()
    while not listens._arrived.empty():
        time, message = listens._arrived.get()
        listens.decode(message, time)
    bus.close()
    events = inbox.drain()
    beats = [event for event in events if isinstance(event, BeatHeard) and event.anchored]
    last = beats[-1]
    # The server without a card loses some pulses on a busy machine, and delivers the others up to 5 ms late.
    assert 60.0 / float(np.median([beat.period for beat in beats[-4:]])) == pytest.approx(200.0, rel=0.03)
    off = faster.beat_at(last.beat_time) - round(faster.beat_at(last.beat_time))
    assert abs(off) * 0.3 < 0.05
    assert round(faster.beat_at(last.beat_time)) % 4 == last.beat
    assert [event.state for event in events if isinstance(event, SourceChanged)][:2] == ["found", "started"]
    assert float(np.median(np.array(sends.late))) < 1e-3


@pytest.mark.long
def test_input_survives_server_crash(
    jack_server: JackServer,  # noqa: F811
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.2)
    box = sender("sequencer")
    listens = MidiInput("sequencer", EventQueue(), SystemClock())
    listens.start()
    try:
        assert wait_for(lambda: listens.connected == "sequencer:out", 10.0)
        jack_server.crash()
        assert wait_for(lambda: listens.connected == "", 15.0)
        box.close()
        jack_server.start()
        box = sender("sequencer")
        assert wait_for(lambda: listens.connected == "sequencer:out", 15.0)
    finally:
        listens.stop()
        box.close()
