"""The clip cache: bit-exact round trip, bounded size, and rebuild of damaged or outdated entries."""

from dataclasses import fields, replace

import numpy as np
import pytest

from live.library import disk_cache
from live.library.disk_cache import ClipCache
from live.motion.step_clip import StepClip
from tests.fixtures.made_steps import made_clip, made_steps

CACHE = ClipCache("made", max_entries=3)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    return tmp_path


def fail_on_rebuild():
    pytest.fail("rebuilt although nothing changed")


def test_cached_steps_are_bit_exact_in_every_field():
    told = replace(
        made_clip("told"),
        first=31.5,
        leading_foot="left",
        begin_pose="plié",
        end_pose="sous-sus",
        weight_transfer=True,
        author="Ana",
        style="soft",
        tags=("a", "b"),
        distance_m=0.3,
        mirrored=True,
    )
    steps = [told, *made_steps()]
    assert CACHE.load_or_build([b"a"], lambda: steps) is steps
    again = CACHE.load_or_build([b"a"], fail_on_rebuild)
    assert len(again) == len(steps)
    for a, b in zip(steps, again, strict=True):
        for field in fields(StepClip):
            if field.name != "clip":
                assert getattr(a, field.name) == getattr(b, field.name), field.name
        assert (a.clip.name, a.clip.sample_rate) == (b.clip.name, b.clip.sample_rate)
        for name in ("root_position", "rotation", "contact"):
            assert getattr(a.clip, name).dtype == getattr(b.clip, name).dtype
            np.testing.assert_array_equal(getattr(a.clip, name), getattr(b.clip, name))
            assert not getattr(b.clip, name).flags.writeable


def test_different_sources_have_separate_entries():
    CACHE.load_or_build([b"a", b"b"], lambda: made_steps()[:1])
    assert len(CACHE.load_or_build([b"ab"], lambda: made_steps()[:2])) == 2  # where one source ends matters
    assert len(CACHE.load_or_build([b"a", b"b"], fail_on_rebuild)) == 1


def test_changed_code_digest_rebuilds_clips(monkeypatch):
    CACHE.load_or_build([b"a"], lambda: made_steps()[:1])
    monkeypatch.setattr(disk_cache, "_code_digest", lambda: b"changed")
    assert len(CACHE.load_or_build([b"a"], lambda: made_steps()[:2])) == 2


@pytest.mark.parametrize("damage", [b"", b"PK broken", None])
def test_broken_entry_is_rebuilt(folder, damage):
    CACHE.load_or_build([b"a"], made_steps)
    (path,) = folder.glob("made-*.npz")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert len(CACHE.load_or_build([b"a"], made_steps)) == len(made_steps())
    assert len(CACHE.load_or_build([b"a"], fail_on_rebuild)) == len(made_steps())


def test_any_damaged_byte_still_gives_correct_clips(folder):
    steps = made_steps()[:1]
    CACHE.load_or_build([b"a"], lambda: steps)
    (path,) = folder.glob("made-*.npz")
    whole = path.read_bytes()
    chance = np.random.default_rng(3)
    for at in chance.integers(0, len(whole), 60):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ int(chance.integers(1, 256))]) + whole[at + 1 :])
        (step,) = CACHE.load_or_build([b"a"], lambda: steps)
        np.testing.assert_array_equal(step.clip.rotation, steps[0].clip.rotation)
        assert step.step == "sway"


def test_most_recently_used_entries_are_kept(folder):
    for key in (b"a", b"b", b"c"):
        CACHE.load_or_build([key], made_steps)
    CACHE.load_or_build([b"a"], fail_on_rebuild)
    CACHE.load_or_build([b"d"], made_steps)
    assert len(list(folder.glob("made-*.npz"))) == 3
    CACHE.load_or_build([b"a"], fail_on_rebuild)
    assert len(CACHE.load_or_build([b"b"], lambda: made_steps()[:1])) == 1


def test_cache_stays_within_size_and_keeps_other_files(folder):
    (folder / "other-1.npz").write_bytes(b"x" * 100)
    small = ClipCache("made", max_entries=3, max_bytes=1)
    for key in (b"a", b"b"):
        small.load_or_build([key], made_steps)
    assert len(list(folder.glob("made-*.npz"))) == 1
    assert (folder / "other-1.npz").exists()


def test_unwritable_folder_rebuilds_every_time(folder, monkeypatch):
    (folder / "file").write_text("no folder")
    monkeypatch.setenv("LIVE_CACHE_DIR", str(folder / "file"))
    assert len(CACHE.load_or_build([b"a"], made_steps)) == len(made_steps())
    assert len(CACHE.load_or_build([b"a"], lambda: made_steps()[:1])) == 1


@pytest.mark.parametrize("package", ["motion", "library"])
def test_code_digest_covers_motion_and_library_packages(tmp_path, monkeypatch, package):
    """Regression: a renamed folder was silently missing from the digest."""
    assert all((disk_cache._PACKAGE / name).is_dir() for name in ("motion", "library"))
    for name in ("motion", "library"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.py").write_text("x = 1\n")
    monkeypatch.setattr(disk_cache, "_PACKAGE", tmp_path)
    before = disk_cache._code_digest.__wrapped__()
    (tmp_path / package / "a.py").write_text("x = 2\n")
    assert disk_cache._code_digest.__wrapped__() != before
