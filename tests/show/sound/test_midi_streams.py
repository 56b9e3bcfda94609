"""Recorded MIDI clocks through decoder, events and follower: the Timeline against the true beats."""

import json

import numpy as np

from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.midi.midi_clock import MidiClock
from live.clock.ticks import TICK
from live.control.midi.midi_decoder import to_event
from live.show.sound.clock_commands import apply_clock_event
from tests.fixtures.mostly_long import mostly_long


def timeline_of(lines, seconds):
    """(time, beat, phase, bpm) at every tick."""
    clock, follower, at, rows = MidiClock(), TimelineFollower(), 0, []
    for tick in range(1, int(seconds / TICK)):
        now = tick * TICK
        while at < len(lines) and lines[at]["t"] <= now:
            for item in clock.receive(lines[at]["m"], lines[at]["t"]):
                apply_clock_event(follower, to_event(item, "midi", 4))
            at += 1
        for item in clock.advance(now):
            apply_clock_event(follower, to_event(item, "midi", 4))
        timeline = follower.advance(now)
        rows.append((now, timeline.beat_at(now), timeline.phase_at(now), follower.tempo))
    return np.array(rows), follower


@mostly_long(
    ("name", "bound_ms"),
    [
        ("mo02_jit1_96", 1.0), ("mo04_jit5_174", 3.0), ("mo05_jit5exp_61", 3.0), ("mo07_bursts10ms_96", 3.0),
        ("mo10_stop_continue", 1.0), ("mo12_spp", 1.0), ("mo13_dropouts", 1.0), ("mo17_start_late_clock", 1.0),
        ("mo08_ramp_120_174", 4.0), ("mo18_accel_rit", 12.0),
    ], quick=[0, 6],
)  # fmt: skip
def test_timeline_matches_the_beats_of_midi_clock(shared, name, bound_ms):
    """Within a bound around the stream's constant delay (p95), every measure line right, from 1.5 s after a start."""
    folder = shared / "beats" / "midiclock"
    lines = [json.loads(line) for line in (folder / f"{name}.jsonl").read_text().splitlines()]
    running = json.loads((folder / f"{name}.truth.json").read_text())["running"]
    rows, follower = timeline_of(lines[1:], lines[0]["dur"])
    off = []
    for row in (folder / f"{name}.beats").read_text().splitlines():
        time, beat, bpm = (float(value) for value in row.split())
        if any(begin + 1.5 <= time <= end for begin, end in running) and time < rows[-1, 0]:
            at, _, phase, tempo = rows[np.searchsorted(rows[:, 0], time) - 1]
            into = phase + (time - at) * tempo / 60.0 - (beat - 1.0)
            off.append(((into + 2.0) % 4.0 - 2.0) * 60.0 / bpm)
    assert len(off) > 20
    assert np.percentile(np.abs(np.array(off) - np.median(off)), 95) * 1e3 < bound_ms
    assert np.abs(off).max() < 0.1, "no line is a beat off"
    assert (np.diff(rows[:, 1]) > 0.0).all()
    assert follower.rejected == 0
