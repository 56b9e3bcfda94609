"""LineWriter: every line in order; a disk that refuses or hangs stops nothing."""

import threading

import pytest

from live.show import line_writer
from live.show.line_writer import LineWriter


def test_lines_arrive_in_order(tmp_path):
    writer = LineWriter(tmp_path / "a", name="test")
    for number in range(1000):
        writer.put(str(number))
    writer.close()
    assert (tmp_path / "a").read_text().split() == [str(number) for number in range(1000)]
    assert writer.dropped == 0


def test_a_folder_that_is_not_there_is_told_at_once(tmp_path):
    with pytest.raises(OSError, match="No such file"):
        LineWriter(tmp_path / "no" / "a", name="test")


class Full:
    """A disk without room."""

    def write(self, text):
        raise OSError(28, "No space left on device")

    def flush(self):
        raise OSError(28, "No space left on device")

    close = flush


def test_a_full_disk_is_counted(tmp_path):
    writer = LineWriter(tmp_path / "a", name="test")
    writer._file.close()
    writer._file = Full()
    for _ in range(50):
        writer.put("x")
    writer.close()
    assert writer.dropped == 51  # and the file that could not be closed properly


def test_a_disk_that_hangs_makes_nobody_wait(tmp_path, monkeypatch):
    monkeypatch.setattr(line_writer, "CAPACITY", 8)
    writer = LineWriter(tmp_path / "a", name="test")
    release, stuck, file = threading.Event(), threading.Event(), writer._file

    class Stuck:
        def write(self, text):
            stuck.set()
            release.wait(30)
            file.write(text)

        def flush(self):
            file.flush()

        def close(self):
            file.close()

    writer._file = Stuck()
    writer.put("first")
    assert stuck.wait(10)
    for number in range(20):  # returns at once although nothing can be written
        writer.put(str(number))
    assert writer.dropped == 12
    release.set()
    writer.close()
    assert (tmp_path / "a").read_text().split() == ["first", *map(str, range(8))]
