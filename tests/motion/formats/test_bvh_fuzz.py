"""Fuzz tests of BVH files: a mutated file quickly gives a motion or a clear one-line error."""

import random
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.retarget.retarget import retarget
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, dance_values

Result = TypeVar("Result")
WORDS = (
    "nan", "inf", "-1e308", "1e-320", "0x10", "1_0", "", "{", "}", "\n", "\0", "\x1a", "JOINT", "ROOT x", "End Site",
    "OFFSET", "CHANNELS", "CHANNELS 999999999", "MOTION", "Frames: 99999999999", "Frame Time: 0", "ù", "\u2028", "-",
    "9" * 400, "LeftUpLeg", "Xposition", ".", "1e7", "\ufeff", "\r",
)  # fmt: skip


def mutate_text(text: str, rng: random.Random) -> str:
    """The text after one to four random mutations."""
    for _ in range(rng.randint(1, 4)):
        kind, at = rng.randrange(8), rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.randint(1, 60))
        if kind == 0:
            text = text[:at]  # cut off
        elif kind == 1:
            text = text[:at] + text[end:]
        elif kind == 2:
            text = text[:at] + rng.choice(WORDS) + text[at:]
        elif kind == 3:
            text = text[:at] + text[at:end] * rng.randint(2, 5) + text[end:]
        elif kind == 4:
            text = text[:at] + chr(rng.choice((rng.randrange(128), rng.randrange(0xD7FF)))) + text[at + 1 :]
        else:
            words = text.split(" ")
            place = rng.randrange(len(words))
            words[place] = rng.choice(WORDS) if kind == 5 else rng.choice(words)
            if kind == 7:
                del words[place]
            text = " ".join(words)
        if not text:
            break
    return text


def attempt(work: Callable[[], Result]) -> tuple[Result | None, ValueError | None]:
    """The result of the work, or the ValueError (MotionFileError is one) that it raises."""
    try:
        return work(), None
    except ValueError as error:
        return None, error


@mostly_long("seed", range(4), quick=[1])
def test_mutated_file_gives_motion_or_error(seed: int) -> None:
    rng = random.Random(seed)
    whole = body_bvh(dance_values(3), fps=30.0)
    outcomes = {"motion": 0, "error": 0, "clip": 0}
    start = time.process_time()
    for _ in range(300):
        text = mutate_text(whole, rng)
        motion, problem = attempt(lambda text=text: parse_bvh(text, "fuzz.bvh"))
        if motion is None:
            outcomes["error"] += 1
            assert isinstance(problem, MotionFileError)
            assert len(str(problem).splitlines()) == 1, text
            assert len(str(problem)) < 400
            assert 1 <= problem.line <= text.count("\n") + text.count("\r") + 1
            continue
        outcomes["motion"] += 1
        assert motion.values.shape == (motion.frame_count, sum(map(len, motion.channels)))
        assert np.isfinite(motion.values).all()
        assert np.isfinite(motion.offsets).all()
        assert (motion.parents[1:] < np.arange(1, motion.joint_count)).all()
        clip, problem = attempt(lambda motion=motion: retarget(bvh_to_source_motion(motion), name="fuzz"))
        if clip is None:
            assert "\n" not in str(problem)
            continue
        outcomes["clip"] += 1
        np.testing.assert_allclose(np.linalg.norm(clip.rotation, axis=-1), 1.0, atol=1e-5)
    assert min(outcomes.values()) > 0, outcomes
    assert time.process_time() - start < 60.0  # a file that hangs the reader would take forever
