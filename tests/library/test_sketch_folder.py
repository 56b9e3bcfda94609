"""Tests of folders of sketched steps: errors, and a cache that follows the files."""

import numpy as np
import pytest

from live.library import step_folder
from live.library.disk_cache import ClipCache
from live.library.recording_file import RecordingError
from live.library.step_folder import StepsError, load_folder
from live.show.patch.patch_search_path import PATCHES

SWAY = 'name = "sway"\n[pelvis]\n"1" = "left 4"\n"3" = "right 4"\n'


@pytest.fixture(autouse=True)
def isolated_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "cache").mkdir()


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "steps"
    path.mkdir()
    (path / "sway.toml").write_text(SWAY)
    return path


def test_cached_clips_are_bit_exact(folder, monkeypatch):
    first = load_folder(folder)
    monkeypatch.setattr(step_folder, "_build_sketches", lambda texts: pytest.fail("rebuilt although nothing changed"))
    again = load_folder(folder)
    assert len(again) == len(first) > 0
    for a, b in zip(first, again, strict=True):
        assert (a.step, a.first, a.samples_per_measure, a.direction, a.mirrored) == (
            b.step, b.first, b.samples_per_measure, b.direction, b.mirrored,
        )  # fmt: skip
        assert (a.clip.rotation == b.clip.rotation).all()
        assert (a.clip.root_position == b.clip.root_position).all()
        assert (a.clip.contact == b.clip.contact).all()


def test_changed_step_is_read_again(folder):
    before = load_folder(folder)[0].clip.root_position
    (folder / "sway.toml").write_text(SWAY.replace("left 4", "left 8"))
    after = load_folder(folder)[0].clip.root_position
    assert np.abs(after[:, 0]).max() > 1.3 * np.abs(before[:, 0]).max()


def test_broken_cache_is_rebuilt(folder, tmp_path):
    load_folder(folder)
    for cache in (tmp_path / "cache").glob("steps-*.npz"):
        cache.write_bytes(b"PK broken")
    assert load_folder(folder)


def test_old_caches_are_removed(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(step_folder, "CACHE", ClipCache("steps", max_entries=2))
    for size in (3, 4, 5, 6):
        (folder / "sway.toml").write_text(SWAY.replace("left 4", f"left {size}"))
        load_folder(folder)
    assert len(list((tmp_path / "cache").glob("steps-*.npz"))) == 2


def test_errors_name_file_and_line(folder):
    (folder / "wrong.toml").write_text('name = "wrong"\n[pelvis]\n"1" = "sideways 4"\n')
    with pytest.raises(StepsError, match=r"wrong\.toml:3: .*sideways"):
        load_folder(folder)
    (folder / "wrong.toml").write_text(SWAY)
    with pytest.raises(StepsError, match=r"'sway' is already in .*sway\.toml"):
        load_folder(folder)
    (folder / "wrong.toml").write_bytes(b"\xff")
    with pytest.raises(RecordingError, match=r"wrong\.toml: not a text in UTF-8"):
        load_folder(folder)


def test_folder_without_steps_is_refused(tmp_path):
    with pytest.raises(RecordingError, match=r"no TOML file in .* describes steps"):
        load_folder(tmp_path)


@pytest.mark.long
def test_project_has_eight_steps_and_walk_has_nine_directions():
    clips = load_folder(PATCHES / "steps")
    names = {clip.step for clip in clips}
    assert len(names) >= 8
    walk = [clip for clip in clips if clip.step == "walk"]
    assert len({clip.direction for clip in walk}) == 9
