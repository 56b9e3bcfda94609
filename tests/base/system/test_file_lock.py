"""Tests of the locks on files."""

import pytest

from live.base.system.file_lock import lock_file


def test_an_exclusive_lock_excludes_all_until_it_is_closed(tmp_path):
    path = tmp_path / "lock"
    with path.open("ab") as first, path.open("ab") as second:
        lock_file(first)
        for shared in (False, True):
            with pytest.raises(BlockingIOError):
                lock_file(second, shared=shared)
        first.close()
        lock_file(second, within=None)


def test_shared_locks_exclude_an_exclusive_one(tmp_path):
    path = tmp_path / "lock"
    with path.open("ab") as first, path.open("ab") as second, path.open("ab") as third:
        lock_file(first, shared=True)
        lock_file(second, shared=True)
        with pytest.raises(BlockingIOError):
            lock_file(third)
