"""Status: figures in the documented form, once a second."""

import json
from collections import Counter

import pytest

from live.show.view.status import FrameTimes, Status, StatusFile
from tests.show.made_show import made_show


def made_status(rejected=None):
    return Status(made_show(), rejected=lambda: Counter(rejected or {}), memory=lambda: 123.45)


def test_percentiles_cover_the_last_frames():
    times = FrameTimes()
    assert times.percentiles(50, 99) == [0.0, 0.0]
    for _ in range(5000):
        times.add(1.0)
    for _ in range(4096):
        times.add(0.016)
    times.add(0.1)
    assert times.percentiles(50, 100) == [16.0, 100.0]


def test_status_snapshot_has_every_key_and_counts_from_one():
    status = made_status({"unknown address": 2})
    status.dropped_events = 3
    s = status.snapshot(0.75)
    assert (s["measure"], s["beat"], s["bpm"], s["clock_state"]) == (1, 2, 120.0, "internal")
    assert s["events_rejected"] == {"unknown address": 2, "inbox full": 3}
    assert s["rss_mb"] == pytest.approx(123.4, abs=0.1)
    assert s["dancers"] == 9
    assert set(s["frame_ms"]) == {"p50", "p99", "p999"}
    assert set(s["cpu_ms"]) == {"p50", "p99"}


def test_status_file_has_one_line_per_second_and_final_line(tmp_path):
    file = StatusFile(tmp_path / "s", made_status())
    for frame in range(200):
        file.frame(frame / 60)
    file.close(3.4)
    lines = [json.loads(line) for line in (tmp_path / "s").read_text().splitlines()]
    assert [line["time"] for line in lines] == [1.0, 2.0, 3.0, 3.4]


def test_overlay_is_refreshed_four_times_per_second():
    status = made_status()
    first = status.overlay(0.0)
    assert any("120.0 bpm" in line for line in first)
    assert any("beat 1 of 4" in line for line in first)
    assert "clock: internal" in first
    assert all(line.isascii() for line in first)  # the overlay's font has few other signs
    status.late_frames = 7
    assert status.overlay(0.2) == first
    assert any("late 7" in line for line in status.overlay(0.3))
