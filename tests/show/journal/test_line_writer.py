"""Tests of LineWriter: line order, full or hanging disks, and exclusive access."""

import json
import threading
from pathlib import Path

import pytest

from live.show.journal import line_writer
from live.show.journal.line_writer import LineWriter, UnfinishedFile, with_gap
from tests.control.waiting import wait_for


def test_lines_are_written_in_order(tmp_path):
    writer = LineWriter(tmp_path / "a", name="test")
    for number in range(1000):
        writer.line(str(number))
    writer.close()
    assert (tmp_path / "a").read_text().split() == [str(number) for number in range(1000)]
    assert writer.dropped == 0


def test_missing_folder_raises_error_at_once(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        LineWriter(tmp_path / "no" / "a", name="test")


def test_lines_dropped_on_full_disk_are_counted():
    writer = LineWriter(Path("/dev/full"), name="test")
    for _ in range(50):
        writer.line("x")
    writer.close()
    assert (writer.dropped, writer.bytes) == (50, 0)


def test_hanging_disk_does_not_block_caller(tmp_path, monkeypatch):
    monkeypatch.setattr(line_writer, "MAX_WAITING_LINES", 8)
    writer = LineWriter(tmp_path / "a", name="test")
    release, stuck, add = threading.Event(), threading.Event(), writer._file.append

    def hangs(data):
        stuck.set()
        release.wait(30)
        add(data)

    monkeypatch.setattr(writer._file, "append", hangs)
    writer.line("first")
    assert stuck.wait(10)
    for number in range(20):  # returns at once although nothing can be written
        writer.line(str(number))
    assert writer.dropped == 12
    release.set()
    writer.close()
    assert (tmp_path / "a").read_text().split() == ["first", *map(str, range(8))]


def test_second_writer_waits_until_first_writer_closes(tmp_path):
    """As when a process takes over a journal although its supervisor is still alive."""
    path = tmp_path / "j"
    first = LineWriter(path, name="first", mark=with_gap)
    for number in range(1, 4):
        first.line(f'{{"tick":{number}}}', number)
    assert wait_for(lambda: first.written is not None and first.written.number == 3, 5.0)
    rest = UnfinishedFile('{"tick":1}', first.written, [(4, '{"tick":4}')])
    second = LineWriter(path, name="second", mark=with_gap, unwritten=rest)
    second.line('{"tick":5}', 5)
    first.line('{"tick":6}', 6)
    assert wait_for(lambda: first.written.number == 6, 5.0)
    assert second.written is None
    first.close()
    assert wait_for(lambda: second.written is not None and second.written.number == 5, 10.0)
    second.close()
    ticks = [json.loads(line)["tick"] for line in path.read_text().splitlines()]
    assert ticks == [1, 2, 3, 6, 4, 5]


def test_writer_without_lock_writes_nothing_and_marks_gap(tmp_path, monkeypatch):
    monkeypatch.setattr("live.show.journal.line_writer.LOCK_TIMEOUT", 0.05)
    path = tmp_path / "j"
    first = LineWriter(path, name="first", mark=with_gap)
    first.line('{"tick":1}', 1)
    assert wait_for(lambda: first.written is not None, 5.0)
    second = LineWriter(path, name="second", mark=with_gap, unwritten=UnfinishedFile('{"tick":1}', first.written, []))
    second.line('{"tick":2}', 2)
    second.line('{"tick":3}', 3)
    assert wait_for(lambda: second.missing == 2, 5.0)
    assert path.read_text() == '{"tick":1}\n'
    first.close()
    second.line('{"tick":4}', 4)
    second.close()
    assert path.read_text() == '{"tick":1}\n{"tick":4,"gap":2}\n'


def test_a_journal_is_written_where_the_system_refuses_a_lock(tmp_path, monkeypatch):
    def fail(*_, **__):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("live.base.system.file_lock._lock", fail)
    path = tmp_path / "j.jsonl"
    writer = LineWriter(path, name="test", mark=with_gap)
    writer.line('{"journal": 1}')
    writer.close()
    assert path.read_text() == '{"journal": 1}\n'
