"""`live soak` and `live sim`: reports, exit codes, refusals, and real-time operation."""

import json
import signal
import subprocess
import sys
import wave

import pytest

from live.app.offline.soak_run import ROW_SECONDS, FrameTimeStats
from tests.cli.command import run_live


@pytest.mark.long
def test_short_soak_reports_and_replays_its_journal(tmp_path):
    report = tmp_path / "report.json"
    told = run_live(
        "soak", "score", "--minutes", "0.2", "--fps", "8", "--seed", "3", "--faults", "20",
        "--report", str(report), "--folder", str(tmp_path / "kept"),
    )  # fmt: skip
    assert told.returncode == 0, told.stdout + told.stderr
    assert "nothing went wrong" in told.stdout
    facts = json.loads(report.read_text())
    assert facts["ok"]
    assert facts["seconds"] == pytest.approx(12.0, abs=5.0)
    assert facts["replay"]["different"] == 0
    assert facts["replay"]["measures"] >= facts["measures"] - facts["leapt"] > 0
    assert (tmp_path / "kept" / "journal.jsonl").is_file()


@pytest.mark.long
def test_real_time_soak_of_six_seconds_reaches_show_over_network(tmp_path):
    told = run_live("soak", "score", "--minutes", "0.1", "--real", "--players", "400", "--faults", "0", "--json")
    facts = json.loads(told.stdout)
    assert facts["frames"] > 30
    assert facts["events"]["accepted"] > 20
    assert facts["replay"]["different"] == 0
    assert facts["replay"]["measures"] >= 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("soak", "no such patch"), "there is no patch"),
        (("soak", "--hours", "0"), "--hours"),
        (("soak", "--hours", "1", "--minutes", "1"), "exclude each other"),
        (("soak", "--faults", "-1"), "--faults"),
        (("sim", "--role", "king"), "--role"),
        (("sim", "--osc", "nonsense"), "--osc"),
        (("sim", "--nonsense", "2"), "--nonsense"),
        (("sim", "--midi", "no such port"), "--midi"),
    ],
)
def test_invalid_options_are_refused_in_one_line(arguments, words):
    told = run_live(*arguments)
    assert told.returncode == 2
    assert words in told.stderr


def test_simulated_band_is_written_as_sound(tmp_path):
    path = tmp_path / "band.wav"
    told = run_live("sim", "score", "--audio", str(path), "--seconds", "3")
    assert told.returncode == 0, told.stderr
    with wave.open(str(path)) as file:
        assert file.getnframes() == 3 * file.getframerate()


def test_growing_frame_times_are_detected_and_noise_is_not():
    rising, even = FrameTimeStats(), FrameTimeStats()
    for row in range(9):
        for number in range(100):
            time = (row + (number + 1) / 100.0) * ROW_SECONDS
            rising.add(time, 0.001 * (1 + row), late=row, memory=300.0)
            even.add(time, 0.001 * (1 + number % 3), late=row, memory=300.0)
    assert len(rising.rows) == len(even.rows) == 9
    first, last = rising.growth()
    assert last > 3.0 * first
    first, last = even.growth()
    assert first == pytest.approx(last)
    assert [row["late"] for row in rising.rows] == [0, *([1] * 8)]
    assert FrameTimeStats().growth() is None


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_soak_ended_by_signal_reports_results_so_far(tmp_path, number):
    report = tmp_path / "report.json"
    command = [sys.executable, "-m", "live", "soak", "score", "--hours", "20", "--report", str(report)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=tmp_path) as running:
        for line in running.stderr:
            if "times real time" in line:
                break
        running.send_signal(number)
        told, _ = running.communicate(timeout=120)
    assert running.returncode == 1
    assert "interrupted" in told
    facts = json.loads(report.read_text())
    assert facts["problems"] == ["interrupted"]
    assert facts["frames"] > 0
