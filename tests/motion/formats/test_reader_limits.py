"""Tests of reader limits: hostile files take little time and at most 64 MB plus 20 times their size."""

import random
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest

from live.motion.formats.acclaim_motion import parse_amc
from live.motion.formats.acclaim_skeleton import parse_asf
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion
from live.motion.retarget.retarget import retarget
from tests.fixtures.mocap import mocap_file
from tests.motion.formats.test_asf_amc import AMC, ASF
from tests.motion.formats.test_bvh_fuzz import attempt, mutate_text

SKELETON = parse_asf(ASF.encode(), "test.asf")
FREE, PER_BYTE = 64_000_000, 20


def read_bvh(data: bytes) -> SourceMotion:
    return bvh_to_source_motion(parse_bvh(data, "x"))


def read_amc(data: bytes) -> SourceMotion:
    return parse_amc(data, "x", SKELETON)


def read_asf(data: bytes) -> SourceMotion:
    return parse_amc(AMC.encode(), "x", parse_asf(data, "x"))


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
    "frames without bones": (read_amc, lambda: "".join(f"{n}\n" for n in range(500_000))),
    "blank lines in an amc": (read_amc, lambda: "\n" * 4_000_000),
    "comments in an amc": (read_amc, lambda: "#\n" * 1_000_000),
    "one line in an amc": (read_amc, lambda: "root " + "1 " * 2_000_000),
    "many frames": (
        read_amc,
        lambda: "".join(f"{n}\nroot 0 0 0 0 0 0\nthigh 0 0 0\nshin 0\n" for n in range(1, 8_000)),
    ),
    "gaps everywhere": (
        read_amc,
        lambda: "".join(f"{2 * n}\nroot 0 0 0 0 0 0\nthigh 0 0 0\nshin 0\n" for n in range(1, 3000)),
    ),
    "bones without end": (read_asf, lambda: ":version\n:bonedata\n" + "begin\nlength 1\n" * 200_000),
    "bones without names": (read_asf, lambda: ":version\n:bonedata\n" + "begin\nend\n" * 200_000),
    "more bones than there may be": (
        read_asf,
        lambda: ":version\n:bonedata\n" + "".join(f"begin\nname b{n}\nend\n" for n in range(2000)),
    ),
    "a large skeleton": (read_asf, lambda: "#" * 5_000_000),
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


@pytest.mark.parametrize("seed", range(4))
def test_mutated_acclaim_file_gives_motion_or_error(seed: int) -> None:
    rng = random.Random(seed)
    outcomes = {"motion": 0, "error": 0}
    for turn in range(400):
        asf, amc = (mutate_text(ASF, rng), AMC) if turn % 2 else (ASF, mutate_text(AMC, rng))
        found, problem = attempt(lambda asf=asf, amc=amc: parse_amc(amc.encode(), "x", parse_asf(asf.encode(), "x")))
        if found is None:
            assert isinstance(problem, MotionFileError)
            assert "\n" not in str(problem)
            assert len(str(problem)) < 400
            outcomes["error"] += 1
            continue
        outcomes["motion"] += 1
        assert found.rotation.shape == (found.frame_count, found.joint_count, 4)
        assert np.isfinite(found.translation).all()
        np.testing.assert_allclose(np.linalg.norm(found.rotation, axis=-1), 1.0, atol=1e-9)
        assert (found.parents[1:] < np.arange(1, found.joint_count)).all()
        assert 1e-4 <= found.frame_time <= 10.0
    assert min(outcomes.values()) > 20, outcomes


@pytest.mark.shared
@pytest.mark.parametrize("seed", range(3))
def test_mutated_recording_gives_clip_or_error(seed: int) -> None:
    rng = random.Random(seed)
    asf = mocap_file("asfamc/49.asf").read_text()
    amc = mocap_file("asfamc/49_14.amc").read_text()
    amc = amc[: amc.index("\n7\n") + 1]
    outcomes = {"clip": 0, "error": 0}
    for turn in range(40):
        skeleton, motion = (mutate_text(asf, rng), amc) if turn % 2 else (asf, mutate_text(amc, rng))
        clip, problem = attempt(
            lambda s=skeleton, m=motion: retarget(parse_amc(m.encode(), "x", parse_asf(s.encode(), "x")), name="x")
        )
        outcomes["clip" if clip is not None else "error"] += 1
        assert clip is None or np.isfinite(clip.root_position).all()
        assert problem is None or "\n" not in str(problem)
    assert min(outcomes.values()) > 0, outcomes


@pytest.mark.shared
@pytest.mark.parametrize("name", ["walk/figure8_MS2_8Walk_M.bvh", "edge/six_channels_everywhere_geno_bind.bvh"])
def test_real_files_stay_within_the_limits(name: str) -> None:
    assert read_limited(read_bvh, mocap_file(name).read_bytes()) is not None
