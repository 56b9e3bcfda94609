"""Shared-memory ring of pictures: another program reads it with only the documented header."""

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from live.base.system.picture_ring import HEADER_SIZE, SLOTS, FrameRing, ring_path
from tests.places import ROOT

SIZE = (40, 24)
READER = ROOT / "docs/how-to/picture/read_ring.py"
pytestmark = pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="memory files are at another place here")


def noise(number: int) -> np.ndarray:
    return np.random.default_rng(number).integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8)


@pytest.fixture
def name() -> str:
    return f"choreographics-test-{os.getpid()}"


@pytest.fixture
def ring(name: str) -> Iterator[FrameRing]:
    ring = FrameRing(name, SIZE)
    yield ring
    ring.close()
    assert not ring.path.exists()


@pytest.fixture(scope="module")
def reader() -> ModuleType:
    """The reader example of the documentation."""
    specification = importlib.util.spec_from_file_location("read_ring", READER)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_every_picture_is_read_complete(ring: FrameRing, name: str, reader: ModuleType) -> None:
    seen = reader.Ring(name)
    assert (seen.width, seen.height) == SIZE
    assert seen.open
    assert seen.read() is None
    for number in range(1, 3 * SLOTS):
        ring.write(noise(number)[::-1], 0.25 * number)  # upside down in memory, as it comes back from the card
        found, seconds, picture = seen.read()
        assert (found, seconds) == (number, 0.25 * number)
        assert np.array_equal(picture, noise(number)[::-1])


def test_slow_reader_never_gets_torn_picture(ring: FrameRing, name: str, reader: ModuleType) -> None:
    """The slot is overwritten while the reader copies it: the reader detects this and reads the newest again."""
    seen = reader.Ring(name)
    ring.write(noise(1), 0.0)

    class Overtaken(np.ndarray):
        """Pixels that are overwritten once while they are copied."""

        def copy(self, *_: object) -> np.ndarray:
            if ring.frames == 1:
                for number in range(2, 2 + SLOTS):
                    ring.write(noise(number), float(number))
            return np.asarray(self).copy()

    seen.pixels = seen.pixels.view(Overtaken)
    number, seconds, picture = seen.read()
    assert number == 1 + SLOTS
    assert seconds == number
    assert np.array_equal(picture, noise(number))


def test_header_matches_documentation(ring: FrameRing) -> None:
    ring.write(noise(1), 1.5)
    data = ring.path.read_bytes()
    assert data[:8] == b"CGLPIC01"
    assert np.frombuffer(data, "<u4", 6, 8).tolist() == [4096, *SIZE, 3, 4, 1]
    assert np.frombuffer(data, "<u8", 1, 32)[0] == 1
    assert np.frombuffer(data, "<u8", 1, 64)[0] == 1
    assert np.frombuffer(data, "<f8", 1, 72)[0] == 1.5
    assert len(data) == HEADER_SIZE + SLOTS * SIZE[0] * SIZE[1] * 3
    assert data[HEADER_SIZE : HEADER_SIZE + SIZE[0] * SIZE[1] * 3] == noise(1).tobytes()


def test_second_ring_of_same_name_replaces_first(ring: FrameRing, name: str, reader: ModuleType) -> None:
    old = reader.Ring(name)
    ring.write(noise(1), 0.0)
    with_other_size = FrameRing(name, (20, 10))
    assert not old.open, "readers of the old one are told"
    ring.write(noise(2), 0.1)  # and nobody who writes there is hurt
    ring.close()
    assert with_other_size.path.exists(), "the old one does not take the new one away"
    assert reader.Ring(name).width == 20
    with_other_size.close()
    assert not with_other_size.path.exists()


def test_ring_is_readable_from_another_process(ring: FrameRing, name: str, tmp_path: Path) -> None:
    ring.write(noise(7), 0.0)
    subprocess.run([sys.executable, str(READER), name, str(tmp_path / "out.ppm")], check=True, timeout=60)
    data = (tmp_path / "out.ppm").read_bytes()
    assert data == b"P6 40 24 255\n" + noise(7).tobytes()


def test_invalid_names_and_foreign_files_are_refused(name: str) -> None:
    for wrong in ("", "../passwd", "a/b", "-x", "x" * 65, "sp ace"):
        with pytest.raises(ValueError, match="expected"):
            ring_path(wrong)
    path = ring_path(name)
    path.write_text("somebody's own file")
    try:
        with pytest.raises(ValueError, match="no ring"):
            FrameRing(name, SIZE)
        assert path.read_text() == "somebody's own file"
    finally:
        path.unlink()
