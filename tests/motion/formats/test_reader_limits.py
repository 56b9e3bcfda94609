"""Tests of reader limits: hostile files take little time and at most 64 MB plus 20 times their size."""

import time
import tracemalloc
from collections.abc import Callable

import pytest

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.test_bvh_fuzz import attempt

FREE, PER_BYTE = 64_000_000, 20


def read_bvh(data: bytes) -> SourceMotion:
    return bvh_to_source_motion(parse_bvh(data, "x"))


def read_limited(read: Callable[[bytes], SourceMotion], data: bytes, seconds: float = 20.0) -> SourceMotion | None:
    """The motion, or None for a one-line MotionFileError; fails on any other error, on memory and on time."""
    tracemalloc.start()
    begin = time.process_time()
    motion, problem = attempt(lambda: read(data))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    if problem is not None:
        assert isinstance(problem, MotionFileError)
        assert "\n" not in str(problem)
        assert len(str(problem)) < 500
    assert peak < FREE + PER_BYTE * len(data)
    assert time.process_time() - begin < seconds
    return motion


def head(joints: int, channels: str, others: str | None = None) -> str:
    """A chain of joints with `channels` (the root) and `others` (the rest), up to the frames."""
    text = "HIERARCHY\n"
    for joint in range(joints):
        words = channels if joint == 0 or others is None else others
        text += f"{'JOINT' if joint else 'ROOT'} j{joint} {{ OFFSET 0 1 0 CHANNELS {len(words.split())} {words}\n"
    return f"{text}{'}' * joints}\nMOTION\nFrames: 5\nFrame Time: 0.1\n"


ONE, THREE = "Xrotation", "Zrotation Xrotation Yrotation"
CROWD = 1_500_000
HOSTILE: dict[str, tuple[Callable[[bytes], SourceMotion], Callable[[], str]]] = {
    "the shortest numbers": (read_bvh, lambda: head(43, THREE) + ("0 " * 129 + "\n") * 6000),
    "one joint": (read_bvh, lambda: head(1, THREE) + "0 0 0\n" * (CROWD // 3)),
    "one channel": (read_bvh, lambda: head(1, ONE) + "0\n" * CROWD),
    "a thousand joints of one channel in all": (read_bvh, lambda: head(1000, ONE, "") + "0\n" * CROWD),
    "few frames of a thousand joints": (read_bvh, lambda: head(1000, ONE, "") + "0\n" * 500),
    "numbers that only python reads": (read_bvh, lambda: head(1, ONE) + "1e-99\n" * 300_000),
    "long numbers": (read_bvh, lambda: head(1, ONE) + ("9" * 900 + "e-890\n") * 3000),
    "a number without end": (read_bvh, lambda: head(1, ONE) + "9" * 3_000_000),
    "blank lines": (read_bvh, lambda: "\n" * 3_000_000),
    "blank lines in the skeleton": (read_bvh, lambda: "HIERARCHY\n" + "\n" * 3_000_000),
    "blank lines before the frames": (read_bvh, lambda: head(1, ONE).partition("Frames")[0] + "\r" * 3_000_000),
    "one line of braces": (read_bvh, lambda: "HIERARCHY ROOT " + "{ " * 2_000_000),
    "one line of words": (read_bvh, lambda: "HIERARCHY\nROOT " + "ab " * 1_300_000),
    "frames said again and again": (read_bvh, lambda: head(1, ONE).partition("Frames")[0] + "Frames: 5\n" * 300_000),
    "letters of three bytes": (read_bvh, lambda: "HIERARCHY\n" + "\u2028" * 1_300_000),
    "nothing but zero bytes": (read_bvh, lambda: "\0" * 4_000_000),
}


@pytest.mark.long
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_file_takes_little_memory_and_time(name: str) -> None:
    read, make = HOSTILE[name]
    read_limited(read, make().encode())


def test_large_valid_files_are_read() -> None:
    """The limit concerns the number of joints, not the number of values."""
    motion = read_limited(read_bvh, (head(43, THREE) + ("0 " * 129 + "\n") * 6000).encode())
    assert motion is not None
    assert motion.rotation.shape == (6000, 43, 4)
    motion = read_limited(read_bvh, (head(60, THREE, THREE) + ("-17.25 " * 180 + "\n") * 3000).encode())
    assert motion is not None


@pytest.mark.shared
@pytest.mark.parametrize("name", ["walk/figure8_MS2_8Walk_M.bvh", "edge/six_channels_everywhere_geno_bind.bvh"])
def test_real_files_stay_within_the_limits(name: str) -> None:
    assert read_limited(read_bvh, mocap_file(name).read_bytes()) is not None
