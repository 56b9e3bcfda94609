"""Tests of the locks on files."""

import errno

import pytest

from live.base.system import file_lock
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


@pytest.mark.parametrize("within", [0.0, None])
def test_a_file_system_without_locks_is_no_error_and_any_other_refusal_is(tmp_path, monkeypatch, within):
    def refuse(number):
        def lock(file, **_):
            raise OSError(number, "refused")

        monkeypatch.setattr(file_lock, "_lock", lock)

    with (tmp_path / "lock").open("ab") as file:
        for number in (errno.ENOTSUP, errno.ENOSYS, errno.ENOLCK):
            refuse(number)
            lock_file(file, within=within)
        refuse(errno.EIO)
        with pytest.raises(OSError, match="refused"):
            lock_file(file, within=within)
