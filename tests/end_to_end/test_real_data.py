"""Real music and real recordings: the show follows a music file and dances clips of motion capture."""

import json
from pathlib import Path

import pytest

from tests.cli.command import run_live
from tests.places import SHARED


def _shared(*parts: str) -> Path:
    path = SHARED.joinpath(*parts)
    if not path.exists():
        pytest.skip("the test data of ../shared is not here")
    return path


def _salsa(folder: Path) -> Path:
    """A library of salsa measures: beats as estimated from the foot plants, true rate 60/s, T-pose dropped."""
    rows = json.loads(_shared("mocap", "beats_estimated.json").read_text())
    entries = []
    for row in rows:
        for file in row["files"]:
            if file not in ("salsa/60_01.bvh", "salsa/60_04.bvh"):
                continue
            for measure in range(2, row["measures_of_4"] - 3, 3):
                entries.append(
                    f'[[step]]\nfile = "{_shared("mocap", file)}"\nname = "salsa {file[8:10]}, {measure}"\nfps = 60\n'
                    f"drop_frames = 6\nbpm = {60 / row['beat_s']:.4f}\nfirst_beat_s = {row['phase_of_4beats_s']}\n"
                    f"start_measure = {measure}\nmeasures = 2\n"
                )
    folder.mkdir()
    (folder / "salsa.toml").write_text("\n".join(entries))
    return folder


@pytest.mark.long
@pytest.mark.shared
def test_show_follows_music_and_dances_recordings(tmp_path):
    """A band at 104 bpm; the film is small, its journal replays, and the danced steps come from the recordings."""
    music = _shared("beats", "open", "o03_band_104.ogg")
    library = _salsa(tmp_path / "library")
    film, journal, report = (tmp_path / name for name in ("a.mp4", "a.jsonl", "a.json"))
    made = run_live(
        "render", "--steps", str(library), "--audio", str(music), "--seconds", "26", "--fps", "5", "--size", "160x90",
        "--out", str(film), "--journal", str(journal), "--report", str(report),
    )  # fmt: skip
    if made.returncode == 2 and "OpenGL" in made.stderr:
        pytest.skip(made.stderr.strip())
    assert made.returncode == 0, made.stderr
    figures = json.loads(report.read_text())
    assert figures["status"]["source"] == "audio"
    assert figures["status"]["bpm"] == pytest.approx(104.0, rel=0.02)
    assert figures["status"]["clock_state"] == "locked"
    assert {row["step"][:5] for row in figures["steps"]} == {"salsa"}
    assert len({row["step"] for row in figures["steps"]}) >= 4
    assert figures["overlaps"] < 200
    assert '"BeatHeard"' in journal.read_text()
    verified = run_live("replay", str(journal), "--verify", "--json")
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert json.loads(verified.stdout)["measures"] >= 10
