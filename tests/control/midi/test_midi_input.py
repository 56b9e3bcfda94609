"""Tests of a MIDI port by name: messages become events, and a lost port is reopened."""

from collections.abc import Callable, Sequence
from typing import cast

import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent, SourceChanged, Tap
from live.control.midi import midi_input, midi_ports
from live.control.midi.midi_input import MidiInput
from live.control.midi.midi_mapping import MidiMap
from live.control.midi.midi_ports import UnknownPort, match_port
from live.control.midi.midi_streams import Port
from tests.control.waiting import wait_for


class FakePort:
    """A port that exists or is unplugged."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.exists = self.system_runs = True
        self.closed = False
        self.receive: Callable[[Sequence[int]], None] = lambda message: None

    def listen(self, receive: Callable[[Sequence[int]], None]) -> None:
        self.receive = receive

    def close(self) -> None:
        self.closed = True


def test_messages_become_events() -> None:
    inbox: EventQueue[ControlEvent] = EventQueue()
    listens = MidiInput("box", inbox, ManualClock(), midi_map=MidiMap())
    listens.decode((0xFA,), 1.0)
    for i in range(30):
        listens.decode((0xF8,), 1.01 + i * 0.02)
    listens.decode((0xB0, 64, 127), 2.0)
    listens.advance(3.0)
    events = inbox.drain()
    assert [type(event) for event in events[:3]] == [SourceChanged, SourceChanged, BeatHeard]
    first = cast(BeatHeard, events[2])
    assert (first.source, first.beat, first.measure, first.beats_per_measure, first.jump) == ("midi", 0, 0, 4, True)
    assert sum(isinstance(event, Tap) for event in events) == 1
    assert cast(SourceChanged, events[-1]).state == "lost"
    assert listens.status()["messages"] == 32


def test_unplugged_port_is_lost_and_found_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 0.0)
    inbox: EventQueue[ControlEvent] = EventQueue()
    ports: list[FakePort] = []
    plugged = True

    def open_by_name(name: str) -> Port:
        if not plugged:
            raise OSError("no such port")
        ports.append(FakePort(f"{name}:1 20:{len(ports)}"))
        return cast(Port, ports[-1])

    listens = MidiInput("box", inbox, ManualClock(5.0), open_by_name=open_by_name)
    listens.start()
    try:
        assert wait_for(lambda: len(ports) == 1, 5.0)
        ports[0].receive([0xF8])
        assert wait_for(lambda: listens.messages == 1, 5.0)
        plugged = False
        ports[0].exists = False
        assert wait_for(lambda: listens.problem == "no such port", 5.0)
        assert ports[0].closed
        plugged = True
        assert wait_for(lambda: len(ports) == 2, 5.0)
        assert wait_for(lambda: listens.problem == "", 5.0)
        ports[1].receive([0xF8])
        assert wait_for(lambda: listens.messages == 2, 5.0)
    finally:
        listens.stop()
    states = [event.state for event in inbox.drain() if isinstance(event, SourceChanged)]
    assert states == ["found", "lost", "found"]
    assert listens.opened == 2


def test_quickly_replugged_port_is_reopened(monkeypatch: pytest.MonkeyPatch) -> None:
    """The old name exists at the next try: a check in between has noticed that the port was gone."""
    monkeypatch.setattr(midi_ports, "RETRY_INTERVAL", 1000.0)
    monkeypatch.setattr(midi_input, "CHECK_INTERVAL", 0.0)
    ports: list[FakePort] = []

    def open_by_name(name: str) -> Port:
        ports.append(FakePort(name))
        return cast(Port, ports[-1])

    listens = MidiInput("box", EventQueue(), ManualClock(), open_by_name=open_by_name)
    listens.start()
    try:
        for count in (1, 2, 3):
            assert wait_for(lambda count=count: len(ports) == count, 5.0)  # type: ignore[misc]
            ports[-1].exists = False
        assert wait_for(lambda: len(ports) == 4, 5.0)
    finally:
        listens.stop()
    assert [port.closed for port in ports] == [True] * 4


def test_waiting_messages_are_bounded() -> None:
    listens = MidiInput("box", EventQueue(), ManualClock())
    for _ in range(midi_input.MAX_WAITING + 10):
        listens.receive([0xFE])
    assert listens.dropped == 10


def test_decoder_exception_is_counted_and_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    listens = MidiInput("box", EventQueue(), ManualClock())

    def fail(_message: Sequence[int], _time: float) -> None:
        raise ZeroDivisionError("no beats")

    monkeypatch.setattr(listens, "decode", fail)
    listens._decode_safely((0xF8,), 1.0)
    assert (listens.status()["bad"], listens.status()["failure"]) == (1, "f8: ZeroDivisionError: no beats")


def test_failing_advance_does_not_stop_the_input(monkeypatch: pytest.MonkeyPatch) -> None:
    port = FakePort("box")
    listens = MidiInput("box", EventQueue(), ManualClock(), open_by_name=lambda _: cast(Port, port))

    def fail(_now: float) -> None:
        raise ZeroDivisionError("no beats")

    monkeypatch.setattr(listens, "advance", fail)
    listens.start()
    try:
        assert wait_for(lambda: listens.failed >= 2, 5.0)
        port.receive([0xF8])
        assert wait_for(lambda: listens.messages == 1, 5.0)
    finally:
        listens.stop()
    assert listens.status()["failure"] == "nothing came: ZeroDivisionError: no beats"


def test_ports_are_matched_by_persistent_names() -> None:
    names = ["Through:Port 14:0", "Launchkey MIDI 1 24:0", "Launchkey MIDI 2 24:1"]
    assert match_port("launchkey midi 1", names) == "Launchkey MIDI 1 24:0"
    assert match_port("Launchkey MIDI 2 31:1", names) == "Launchkey MIDI 2 24:1"  # it was plugged in again
    assert match_port("through", names) == names[0]
    bridged = ["a2j:Launchkey [24] (capture): Launchkey MIDI 1", "a2j:Launchkey [24] (capture): Launchkey MIDI 2"]
    assert match_port("a2j:Launchkey [31] (capture): Launchkey MIDI 2", bridged) == bridged[1]
    assert match_port("footswitch:out", ["footswitch-01:out", "organ:out"]) == "footswitch-01:out"
    assert match_port("pad-01:out", ["pad:out", "pad-01:out"]) == "pad-01:out"
    with pytest.raises(UnknownPort, match="several"):
        match_port("launchkey", names)
    with pytest.raises(UnknownPort, match="Through"):
        match_port("nothing", names)
