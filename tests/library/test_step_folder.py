"""A step folder may contain recordings and sketches; each TOML file is read by its kind."""

from pathlib import Path

import pytest

from live.library.recording_file import RecordingError, read_step_files
from live.library.step_folder import StepsError, load_folder
from tests.motion.formats.made_bvh import body_bvh, dance_values

SKETCH = 'name = "bob"\nmirror = false\n[pelvis]\n"1" = "down 4"\n"2" = "up 1"\n'
RECORDING = 'file = "dance.bvh"\nname = "sway"\nbpm = 120\nfirst_beat_s = 2.5\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    path = tmp_path / "steps"
    path.mkdir()
    (path / "dance.bvh").write_text(body_bvh(dance_values(601)))
    (path / "dance.toml").write_text(RECORDING)
    (path / "bob.toml").write_text(SKETCH)
    return path


def test_recordings_and_sketches_are_loaded(folder: Path) -> None:
    assert [step.step for step in load_folder(folder)] == ["bob", "sway"]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (SKETCH, "sketch"),
        ('name = "a"\nbeats = 8\n', "sketch"),
        (RECORDING, "recording"),
        ('name = "a"\nbpm = 120\n', "recording"),
        ('bpm = 120\n[[step]]\nname = "a"\n', "recording"),
        ('file = "a.bvh"\n[pelvis]\n"1" = "down 4"\n', "recording"),
        ('[[pair]]\nleader = { file = "a.bvh" }\n', "neither"),
    ],
)
def test_file_kind_is_recognized_by_content(tmp_path: Path, text: str, kind: str) -> None:
    (tmp_path / "a.toml").write_text(text)
    files = read_step_files(tmp_path)
    assert (bool(files.sketches), bool(files.recordings)) == (kind == "sketch", kind == "recording")


def test_errors_of_both_kinds_are_reported(folder: Path) -> None:
    (folder / "bob.toml").write_text(SKETCH.replace("down", "sideways"))
    with pytest.raises(StepsError, match=r"bob\.toml:4: .*sideways"):
        load_folder(folder)
    (folder / "bob.toml").unlink()
    (folder / "dance.toml").write_text(RECORDING.replace("120", "1"))
    with pytest.raises(RecordingError, match=r"dance\.toml, line 3: bpm"):
        load_folder(folder)
    (folder / "dance.toml").unlink()
    with pytest.raises(RecordingError, match=r"in its 1 recordings .*live steps add FILE --library"):
        load_folder(folder)
