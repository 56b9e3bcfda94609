"""`live sync`: a synthetic BVH of a clapping dancer, and invalid input."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from live.base.errors import PersonError
from live.cli.main import app
from live.library.beat_alignment import SyncResult
from live.motion.beats.clap_sync import AssignedClap, Clap
from live.motion.beats.music_reference import MusicReference
from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long
from tests.library.test_beat_alignment import click_track
from tests.motion.beats.test_claps import palm_distance, scattered_clap_times
from tests.motion.formats.made_bvh import body_bvh
from tests.motion.retarget.made_source import clapping_values


@pytest.fixture
def clap_recording(tmp_path: Path) -> Path:
    path = tmp_path / "clapped.bvh"
    path.write_text(body_bvh(clapping_values(palm_distance(scattered_clap_times()), 8.0, 60.0), fps=60.0))
    return path


@pytest.mark.long
def test_claps_are_aligned_to_click(clap_recording: Path) -> None:
    """Every clap is found within 5 ms, through file, reader and command."""
    done = run_live("sync", str(clap_recording), "--click", "120", "--count", "8", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    np.testing.assert_allclose([clap["time_s"] for clap in found["claps"]], scattered_clap_times(), atol=0.005)
    assert [clap["beat"] for clap in found["claps"]] == list(range(1, 9))
    assert found["first_beat_s"] == pytest.approx(
        float(np.mean(scattered_clap_times() - 0.5 * np.arange(8))), abs=0.005
    )
    assert (found["bpm"], found["source"], found["drop_frames"]) == (120.0, "click", 0)
    assert found["confidence"] > 0.7
    residuals = [1e3 * (time - found["first_beat_s"] - 0.5 * n) for n, time in enumerate(scattered_clap_times())]
    np.testing.assert_allclose([clap["residual_ms"] for clap in found["claps"]], residuals, atol=5.0)


@pytest.mark.long
def test_output_contains_lines_to_paste(clap_recording: Path) -> None:
    done = run_live("sync", str(clap_recording))
    assert done.returncode == 0
    assert "clap    1.5" in done.stdout
    assert done.stdout.count("# guess: confirm") == 2  # hands alone may do something else than clap
    lines = tomllib.loads(done.stdout.split("\n\n")[1])
    assert lines["file"] == "clapped.bvh"
    assert lines["bpm"] == pytest.approx(120.0, rel=0.01)
    assert lines["first_beat_s"] == pytest.approx(1.5, abs=0.02)


@mostly_long(
    ("options", "marks"),
    [
        (["--click", "120", "--count", "8"], ("from claps to the click, confidence 0.", 2)),
        (["--click", "90", "--count", "8"], ("guess: confirm", 2)),
        (["--anchor", "1.5"], ("guess: confirm", 1)),
        (["--anchor", "1.5", "--bpm", "120"], ("#", 0)),
    ],
    quick=[0, 2],
)
def test_guessed_values_are_marked_in_lines_to_paste(
    clap_recording: Path, options: list[str], marks: tuple[str, int]
) -> None:
    done = CliRunner().invoke(app, ["sync", str(clap_recording), *options])
    assert done.exit_code == 0
    assert done.stdout.split("\n\n")[1].count(f"# {marks[0]}".replace("# #", "#")) == marks[1]


def test_fewer_than_four_claps_are_guess() -> None:
    clap = Clap(1.0, 0.05, 3.0)
    placed = tuple(AssignedClap(clap, beat, 0.0) for beat in (1, 2, 3, 4))
    reference = MusicReference(1.0, 120.0, 0.9, "click", "")
    assert not SyncResult(reference, placed, 0, 60.0).guessed
    assert SyncResult(reference, (*placed[:3], AssignedClap(clap, None, None)), 0, 60.0).guessed


@pytest.mark.long
def test_claps_are_aligned_to_song(clap_recording: Path, tmp_path: Path) -> None:
    song = click_track(tmp_path / "song.wav", 0.7 + 0.5 * np.arange(70), 36.0)
    done = run_live("sync", str(clap_recording), "--song", str(song), "--json")
    found = json.loads(done.stdout)
    assert found["source"] == "song"
    assert found["bpm"] == pytest.approx(120.0, rel=1e-3)
    assert found["first_beat_s"] == pytest.approx(1.5, abs=0.02)
    assert "the song begins at +0.8" in found["note"]


def test_manual_anchor_has_priority(clap_recording: Path) -> None:
    done = CliRunner().invoke(
        app, ["sync", str(clap_recording), "--click", "120", "--anchor", "3.21", "--bpm", "124", "--json"]
    )
    found = json.loads(done.stdout)
    assert (found["first_beat_s"], found["bpm"], found["source"], found["confidence"]) == (3.21, 124.0, "hand", 1.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--click", "4000"], "--click 4000"),
        (["--click", "120", "--song", "a.wav"], "--click and --song"),
        (["--count", "8"], "--count counts the beats of a click"),
        (["--song", "none.wav"], "no such file"),
        (["--drop-frames", "480"], "the recording has 480 frames"),
        (["--anchor", "-1"], "--anchor -1"),
        (["--anchor", "8.5", "--bpm", "120"], "--anchor 8.5: the recording lasts 8.00 s"),
        (["--fps", "nan"], "--fps nan"),
    ],
)
def test_invalid_options_are_refused(clap_recording: Path, options: list[str], words: str) -> None:
    done = CliRunner().invoke(app, ["sync", str(clap_recording), *options])
    assert isinstance(done.exception, PersonError)
    assert words in done.exception.message
    assert "\n" not in done.exception.message
    assert done.stdout == ""


def test_broken_file_is_refused_with_its_line(tmp_path: Path) -> None:
    broken = tmp_path / "broken.bvh"
    broken.write_text("HIERARCHY\nROOT Hips\n{\n")
    done = run_live("sync", str(broken))
    assert done.returncode == 2
    assert f"{broken}, line 3" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    missing = CliRunner().invoke(app, ["sync", str(tmp_path / "none.bvh")])
    assert isinstance(missing.exception, PersonError)
    assert "there is no such file" in missing.exception.message


def test_motionless_body_needs_manual_anchor(tmp_path: Path) -> None:
    still = tmp_path / "still.bvh"
    still.write_text(body_bvh(np.zeros((300, 66)) + np.eye(1, 66, 1) * 94.0, fps=60.0))
    nothing = CliRunner().invoke(app, ["sync", str(still)])
    assert isinstance(nothing.exception, PersonError)
    assert "--anchor SECONDS --bpm BPM" in str(nothing.exception.remedy)
    done = CliRunner().invoke(app, ["sync", str(still), "--anchor", "1", "--bpm", "100", "--json"])
    assert json.loads(done.stdout)["source"] == "hand"
