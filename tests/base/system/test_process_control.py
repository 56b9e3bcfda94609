"""Tests of what is known of a process and a file's owner, by the way of Linux and by the one that works everywhere."""

import os
import platform
import sys

import pytest

from live.base.system import process_control
from live.base.system.files import is_private


@pytest.mark.skipif(sys.platform != "linux", reason="both ways exist on Linux alone")
def test_linux_reads_memory_without_a_library_and_both_ways_agree(monkeypatch):
    monkeypatch.setattr(process_control, "LINUX", False)
    resident, machine = process_control.memory_of(os.getpid()), process_control.machine_memory()
    monkeypatch.setattr(process_control, "LINUX", True)
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "psutil", None)  # the supervisor need not import it
        assert process_control.memory_of(os.getpid()) == pytest.approx(resident, rel=0.1)
        assert process_control.machine_memory() == machine


@pytest.mark.parametrize("linux", [True, False])
def test_a_process_that_has_gone_has_no_memory(linux, monkeypatch):
    monkeypatch.setattr(process_control, "LINUX", linux)
    assert process_control.memory_of(2**22 + 1) == 0  # more than any process has (proc(5), pid_max)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="files have no owner here")
def test_a_file_of_another_user_is_not_private(tmp_path, monkeypatch):
    path = tmp_path / "key"
    path.touch(0o600)
    assert is_private(path.stat())
    monkeypatch.setattr(os, "getuid", lambda: path.stat().st_uid + 1)
    assert not is_private(path.stat())


@pytest.mark.skipif(
    sys.platform != "linux" or platform.libc_ver()[0] != "glibc", reason="glibc alone keeps what is freed"
)
def test_freed_pieces_go_back_to_the_system():
    pieces = [bytes(2000) for _ in range(50_000)]
    last = pieces[-1]  # lies above all others, so glibc keeps these when they are freed
    del pieces
    before = process_control.memory_of(os.getpid())
    process_control.return_free_memory()
    assert before - process_control.memory_of(os.getpid()) > 50_000_000
    assert len(last) == 2000
