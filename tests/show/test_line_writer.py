"""LineWriter: every line in order; a disk that refuses or hangs stops nothing."""

import threading
from pathlib import Path

import pytest

from live.show import line_writer
from live.show.line_writer import LineWriter


def test_lines_arrive_in_order(tmp_path):
    writer = LineWriter(tmp_path / "a", name="test")
    for number in range(1000):
        writer.line(str(number))
    writer.close()
    assert (tmp_path / "a").read_text().split() == [str(number) for number in range(1000)]
    assert writer.dropped == 0


def test_a_folder_that_is_not_there_is_told_at_once(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        LineWriter(tmp_path / "no" / "a", name="test")


def test_a_full_disk_is_counted():
    writer = LineWriter(Path("/dev/full"), name="test")
    for _ in range(50):
        writer.line("x")
    writer.close()
    assert (writer.dropped, writer.bytes) == (50, 0)


def test_a_disk_that_hangs_makes_nobody_wait(tmp_path, monkeypatch):
    monkeypatch.setattr(line_writer, "CAPACITY", 8)
    writer = LineWriter(tmp_path / "a", name="test")
    release, stuck, add = threading.Event(), threading.Event(), writer._file.add

    def hangs(data):
        stuck.set()
        release.wait(30)
        add(data)

    monkeypatch.setattr(writer._file, "add", hangs)
    writer.line("first")
    assert stuck.wait(10)
    for number in range(20):  # returns at once although nothing can be written
        writer.line(str(number))
    assert writer.dropped == 12
    release.set()
    writer.close()
    assert (tmp_path / "a").read_text().split() == ["first", *map(str, range(8))]
