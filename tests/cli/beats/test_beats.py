"""`live beats`: files and streams, seeds, the timeline, and error messages."""

import csv
import json
import subprocess
import sys
import wave
from pathlib import Path

import numpy as np
import pytest

from tests.cli.command import run_live
from tests.clock.clicks import clicks
from tests.fixtures.mostly_long import mostly_long

RATE = 44_100


@pytest.fixture(scope="module")
def music(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten seconds of clicks at 120 bpm."""
    sound, _ = clicks(120, RATE, 10.0)
    path = tmp_path_factory.mktemp("music") / "clicks.wav"
    with wave.open(str(path), "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE)
        out.writeframes((sound * 32767).astype("<i2").tobytes())
    return path


def test_json_of_file_contains_tempo_and_beats(music: Path) -> None:
    told = json.loads(run_live("beats", str(music), "--json", "--tracker", "aubio").stdout)
    assert told["file"] == "clicks.wav"
    assert told["bpm"] == pytest.approx(120.0, rel=0.02)
    assert len(told["beats"]) > 8
    assert {"time_s", "named_s", "beat", "beats_per_measure", "bpm", "confidence"} == set(told["beats"][0])


@pytest.mark.long
def test_table_csv_click_and_timeline_are_written_for_file(music: Path, tmp_path: Path) -> None:
    clicked, timeline = tmp_path / "out.wav", tmp_path / "out.csv"
    result = run_live("beats", str(music), "--csv", "--click", str(clicked), "--timeline", str(timeline))
    assert result.returncode == 0, result.stderr
    rows = list(csv.DictReader(result.stdout.splitlines()))
    late = [float(row["time_s"]) for row in rows if float(row["time_s"]) > 5.0]
    assert len(late) >= 8
    assert max(abs((time - 0.3 + 0.25) % 0.5 - 0.25) for time in late) < 0.04
    with wave.open(str(clicked)) as sound:
        assert sound.getnframes() == 10 * RATE
    ticks = list(csv.DictReader(timeline.read_text().splitlines()))
    assert list(ticks[0]) == ["time_s", "beat", "measure", "phase", "bpm", "confidence", "state"]
    assert float(ticks[64]["time_s"]) == 1.0
    assert np.all(np.diff([float(tick["beat"]) for tick in ticks]) > 0.0)
    heading = run_live("beats", str(music)).stdout.splitlines()[0]
    assert float(heading.split(" bpm")[0].split()[-1]) == pytest.approx(120.0, abs=0.5)


@pytest.mark.long
def test_likely_tempo_and_metres_decide_how_clicks_are_counted(music: Path) -> None:
    """Clicks without any accent: the operator or the file's name says what they are."""

    def told(path: Path, *options: str) -> tuple[float, set[int]]:
        report = json.loads(run_live("beats", str(path), "--json", *options).stdout)
        return report["bpm"], {beat["beats_per_measure"] for beat in report["beats"]}

    assert told(music)[0] == pytest.approx(120.0, rel=0.02)
    assert told(music, "--likely-bpm", "55")[0] == pytest.approx(60.0, rel=0.02)
    named = music.with_name("slow clicks 60 bpm.wav")
    named.write_bytes(music.read_bytes())
    assert told(named)[0] == pytest.approx(60.0, rel=0.02)
    assert told(music, "--metres", "2+3")[1] == {5}


def test_stream_prints_beats_while_audio_arrives() -> None:
    """In a process of its own, as the benchmark starts it; each beat is printed before its time."""
    sound, times = clicks(120, RATE, 8.0)
    command = [sys.executable, "-m", "live", "beats", "--stdin", "--one-at", "4.3", "--tap-bpm", "120", "--at", "4.0"]
    result = subprocess.run(command, input=sound.astype("<f4").tobytes(), capture_output=True, timeout=120, check=False)
    assert result.returncode == 0, result.stderr
    lines = [line.split() for line in result.stdout.decode().splitlines()]
    beats = [[float(value) for value in line[1:]] for line in lines if line[0] == "B"]
    assert {line[0] for line in lines} <= {"B", "R"}
    late = [beat for beat in beats if beat[0] > 4.5]
    assert len(late) >= 6
    assert all(abs(times[np.argmin(np.abs(times - time))] - time) < 0.04 for time, _, _ in late)
    assert all(emitted < time + 0.05 for time, emitted, _ in late)
    assert late[0][2] == 2.0, "the beat after the one"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "FILE or --stdin"),
        (("a.wav", "--stdin"), "FILE or --stdin"),
        (("no-such.wav",), "no such file"),
        (("--stdin", "--json"), "for files"),
        (("a.wav", "--tap-bpm", "90"), "belong together"),
        (("a.wav", "--tap-bpm", "900", "--at", "3"), "--tap-bpm 900"),
        (("a.wav", "--one-at", "nan"), "--one-at nan"),
        (("a.wav", "--likely-bpm", "700"), "--likely-bpm 700"),
        (("--stdin", "--metres", "3,1"), "--metres '1': a measure has 2 to 9 beats"),
        (("--stdin", "--metres", "4/4"), "number of beats such as 5"),
        (("a.wav", "--timeline", "/no/such/folder/t.csv"), "cannot be written"),
    ],
)
def test_errors_are_printed_in_one_line(arguments: tuple[str, ...], words: str) -> None:
    result = run_live("beats", *arguments)
    assert result.returncode == 2
    assert words in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")
def test_full_disk_is_reported_in_one_line(music: Path) -> None:
    result = run_live("beats", str(music), "--tracker", "aubio", "--timeline", "/dev/full")
    assert result.returncode == 2
    assert "--timeline /dev/full cannot be written (No space left on device)" in result.stderr
    sound = clicks(120, RATE, 6.0)[0].astype("<f4").tobytes()
    with open("/dev/full", "w", encoding="ascii") as full:
        beats = subprocess.run(
            [sys.executable, "-m", "live", "beats", "--stdin"],
            input=sound, stdout=full, stderr=subprocess.PIPE, timeout=120, check=False,
        )  # fmt: skip
    assert b"the beats cannot be written (No space left on device)" in beats.stderr
    assert b"Traceback" not in beats.stderr


def test_explain_draws_tempo_half_beat_line_metre_and_confidence(music: Path, tmp_path: Path) -> None:
    """The tempo lane is brightest at 120 bpm, the beat lane on the beat, in each column once the tempo is found."""
    from PIL import Image

    from live.app.pictures.beats_picture import GAP, LEFT, TEMPI

    path = tmp_path / "why.png"
    result = run_live("beats", str(music), "--explain", str(path))
    assert result.returncode == 0, result.stderr
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"), np.float64)
    right = pixels[:, LEFT + (pixels.shape[1] - LEFT) // 2 :]
    lane = right[GAP : GAP + 2 * len(TEMPI) : 2]
    tempo = TEMPI[np.argmax(lane.sum(axis=2).mean(axis=1))]
    assert tempo == pytest.approx(120.0, rel=0.04)
    beat = right[2 * GAP + 2 * len(TEMPI) :][[7, 21, 35, 49]].sum(axis=2).mean(axis=1)
    assert np.argmax(beat) == 0


@mostly_long(
    ("words", "says"),
    [
        (["--stdin", "--explain", "why.png"], "--explain are for files"),
        (["FILE", "--tracker", "aubio", "--explain", "why.png"], "--explain draws the network's tracker"),
        (["FILE", "--explain", "no/such/folder/why.png"], "--explain no/such/folder/why.png cannot be written"),
    ],
    quick=[0],
)
def test_explain_says_what_it_cannot_do(music: Path, words: list[str], says: str) -> None:
    result = run_live("beats", *(str(music) if word == "FILE" else word for word in words))
    assert result.returncode == 2
    assert says in " ".join(result.stderr.split())
