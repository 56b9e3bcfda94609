"""Tests of the MIDI clock process: start, status, end with the show, and restart."""

import subprocess

import pytest

from live.clock.time_source import ManualClock, SystemClock
from live.clock.timeline import Timeline
from live.control.midi import midi_clock_process
from live.control.midi.midi_clock_process import MidiClockProcess
from tests.control.waiting import wait_for


def test_missing_port_is_reported_and_killed_process_restarts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(midi_clock_process, "RESTART_AFTER", 0.0)
    sends = MidiClockProcess("no such port", SystemClock())
    sends.start()
    first = sends._process
    assert first is not None
    try:
        sends.set_timeline(Timeline(tempo=140.0))
        assert wait_for(lambda: sends.problem != "", 20.0)
        first.kill()
        first.wait()

        def again() -> bool:
            sends.set_timeline(Timeline(tempo=120.0))
            return sends._process is not first

        assert wait_for(again, 10.0)
    finally:
        second = sends._process
        sends.stop()
    assert second is not None
    assert second.poll() is not None


def test_failed_process_start_is_retried_at_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = ManualClock()
    ended = subprocess.Popen(["true"], stdin=subprocess.PIPE)
    ended.wait()
    sends = MidiClockProcess("no such port", clock)
    sends._process = ended
    tried: list[float] = []

    def refuse(*_: object, **__: object) -> None:
        tried.append(clock.now())
        raise OSError(12, "Cannot allocate memory")

    monkeypatch.setattr(midi_clock_process.subprocess, "Popen", refuse)
    for _ in range(100):
        clock.advance(0.1)
        sends.set_timeline(Timeline(tempo=120.0))
    assert 2 <= len(tried) <= 5  # now and then, not in every frame
    assert sends.problem
