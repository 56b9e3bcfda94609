"""The cache of arrays never fails and never gives wrong values, whatever is in its folder."""

import errno
import os
from collections.abc import Callable

import numpy as np
import pytest

from live.base.disk import array_cache
from live.base.disk.array_cache import ArrayCache, digest_of_code

CACHE = ArrayCache("made", max_entries=3)
VALUES = {"a": np.arange(1000, dtype=np.float32).reshape(-1, 4), "b": np.array([1, 2, 3], np.int32)}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    return tmp_path


@pytest.fixture
def entry():
    path = CACHE.entry_path(b"code", [b"source"])
    CACHE.store(path, VALUES)
    return path


def is_whole(found) -> bool:
    return found is not None and all(
        np.array_equal(found[name], VALUES[name]) and found[name].dtype == VALUES[name].dtype for name in VALUES
    )


def test_entry_is_read_as_it_was_written(entry):
    assert is_whole(CACHE.load(entry, dict))


def test_entry_cut_off_anywhere_is_ignored_and_replaced(entry):
    whole = entry.read_bytes()
    for length in range(0, len(whole), 97):
        entry.write_bytes(whole[:length])
        assert CACHE.load(entry, dict) is None
    CACHE.store(entry, VALUES)
    assert is_whole(CACHE.load(entry, dict))


def test_key_depends_on_code_and_on_where_sources_end():
    keys = [(b"code", [b"ab"]), (b"code", [b"a", b"b"]), (b"code", [b"b", b"a"]), (b"other", [b"ab"]), (b"code", [])]
    assert len({CACHE.entry_path(*key) for key in keys}) == len(keys)


def test_pickled_objects_are_never_read(entry):
    np.savez(entry, a=np.array([print], dtype=object))
    assert CACHE.load(entry, dict) is None


def test_arrays_that_unpack_refuses_count_as_no_entry(entry):
    def refuse(arrays):
        raise KeyError("c")

    assert CACHE.load(entry, refuse) is None


def fail_with(number: int) -> Callable[..., None]:
    def fail(*_args: object, **_more: object) -> None:
        raise OSError(number, os.strerror(number))

    return fail


def test_entry_in_folder_of_another_user_is_read_although_its_time_cannot_be_renewed(entry, monkeypatch):
    monkeypatch.setattr(array_cache.os, "utime", fail_with(errno.EPERM))
    assert is_whole(CACHE.load(entry, dict))


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT])
def test_full_or_read_only_disk_keeps_the_old_entry_and_leaves_nothing_else(folder, entry, monkeypatch, number):
    def write_half(file, arrays):
        file.write(b"half")
        fail_with(number)()

    monkeypatch.setattr(array_cache, "write_arrays", write_half)
    CACHE.store(entry, {"a": np.zeros(3)})
    CACHE.store(CACHE.entry_path(b"code", [b"new"]), VALUES)
    assert list(folder.iterdir()) == [entry]
    assert is_whole(CACHE.load(entry, dict))


def test_unreadable_entry_of_another_user_counts_as_none(entry, monkeypatch):
    monkeypatch.setattr(type(entry), "open", fail_with(errno.EACCES))
    assert CACHE.load(entry, dict) is None


def test_folder_that_cannot_be_made_is_no_error(folder, monkeypatch):
    (folder / "file").write_text("no folder")
    monkeypatch.setenv("LIVE_CACHE_DIR", str(folder / "file"))
    path = CACHE.entry_path(b"code", [])
    CACHE.store(path, VALUES)
    assert CACHE.load(path, dict) is None


def test_code_digest_covers_files_and_whole_folders(folder):
    (folder / "inner").mkdir()
    files = [folder / "inner" / "a.py", folder / "b.py"]
    for file in files:
        file.write_text("x = 1\n")
    places = [folder / "inner", folder / "b.py"]
    seen = {digest_of_code(places)}
    for file in files:
        file.write_text("x = 2\n")
        seen.add(digest_of_code(places))
    assert len(seen) == 3
