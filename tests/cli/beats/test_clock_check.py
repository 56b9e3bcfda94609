"""`live clock-check`."""

import json
from pathlib import Path

import pytest

from live.app.offline.clock_stream import read_beats, read_stream
from live.base.errors import PersonError
from live.cli.beats.clock_check import clock_check
from live.clock.midi.clock_report import clock_errors, replay
from tests.clock.midi_streams import make_stream, steady
from tests.fixtures.mostly_long import mostly_long


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def stream_file(folder: Path) -> Path:
    stream = make_stream(steady(120.0), seconds=8.0, jitter=0.001)
    lines = [json.dumps({"t": time, "m": list(message)}) for time, message in stream.events]
    beats = [f"{time}\t{beat % 4 + 1}\t{bpm}" for time, beat, bpm in stream.beats]
    write(folder / "song.beats", "\n".join(beats))
    return write(folder / "song.jsonl", "\n".join(['{"name": "song"}', *lines]) + "\n")


def test_beats_and_errors_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clock_check(stream_file(tmp_path), metre=4, json_out=False)
    lines = capsys.readouterr().out.splitlines()
    beats = [line.split() for line in lines if line.startswith("B ") and " - " not in line]
    assert [beat[3] for beat in beats[:5]] == ["1", "2", "3", "4", "1"]
    assert all(float(beat[2]) <= float(beat[1]) + 0.005 for beat in beats)
    assert float(beats[-1][5]) == pytest.approx(120.0, abs=0.1)
    assert "measure_right 1.000" in lines[-1]


def test_json_contains_beats_errors_and_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    clock_check(stream_file(tmp_path), metre=4, json_out=True)
    found = json.loads(capsys.readouterr().out)
    assert found["name"] == "song"
    assert found["errors"]["found"] == 1.0
    assert found["errors"]["phase_p95_ms"] < 3.0
    assert found["beats"][0]["first_time"] is None
    assert [state["state"] for state in found["states"]] == ["found", "started"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no message"),
        ("{", "line 1: not JSON"),
        ('{"t": 1, "m": [248]}\n{"t": 2}', "line 2: not a message"),
        ('{"t": "x", "m": [248]}', "line 1: not a message"),
        ('{"t": 1, "m": [300]}', "line 1: not a message"),
        ('{"t": 2, "m": [248]}\n{"t": 1, "m": [248]}', "line 2: t goes back"),
    ],
)
def test_error_for_invalid_stream_names_line(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(PersonError, match=told):
        read_stream(write(tmp_path / "bad.jsonl", text))


def test_invalid_beats_and_missing_files_are_reported(tmp_path: Path) -> None:
    with pytest.raises(PersonError, match="line 2: seconds, beat and bpm"):
        read_beats(write(tmp_path / "a.beats", "1 1 120\n2 x 120\n"))
    with pytest.raises(PersonError, match="cannot read"):
        read_stream(tmp_path / "nothing.jsonl")


@mostly_long("name", ["mo09_steps", "mo12_spp", "mo13_dropouts", "mo15_double_start"], quick=[3])
def test_difficult_streams_keep_the_measure(shared: Path, name: str) -> None:
    file = shared / "beats" / "midiclock" / f"{name}.jsonl"
    if not file.is_file():
        pytest.skip("the streams are not there")
    errors = clock_errors(replay(read_stream(file)[1]).beats, read_beats(file.with_suffix(".beats")))
    assert errors is not None
    assert errors.measure_right == errors.found == 1.0
    assert errors.extra == 0
    assert errors.phase_p95_ms <= 3.0
    assert errors.step_beats <= 1
