"""Tests of the MIDI clock sender on a fake port."""

from typing import cast

import pytest

from live.clock.midi.pulse_schedule import PulseMessages
from live.clock.time_source import SystemClock
from live.clock.timeline import Timeline
from live.control.midi.midi_clock_output import MidiClockOutput
from live.control.midi.midi_streams import Port
from tests.control.waiting import wait_for


class FakePort:
    """Records sent messages."""

    name = "synth"
    there = True

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def send(self, message: bytes) -> None:
        self.sent.append(message)

    def close(self) -> None: ...


def test_scheduling_error_does_not_stop_clock_output(monkeypatch: pytest.MonkeyPatch) -> None:
    port = FakePort()
    sends = MidiClockOutput("synth", SystemClock(), open_by_name=lambda _: cast(Port, port))

    def fail(_timeline: Timeline, _now: float) -> PulseMessages:
        raise OverflowError("no such pulse")

    monkeypatch.setattr(sends._schedule, "next_pulse", fail)
    sends.set_timeline(Timeline(tempo=240.0))
    sends.start()
    try:
        assert wait_for(lambda: sends.sent >= 24, 10.0)
    finally:
        sends.stop()
    assert sends.problem == ""
    assert sends.status()["failed"] == 1
    assert sends.status()["failure"] == "OverflowError: no such pulse"
    assert port.sent.count(b"\xf8") >= 24
