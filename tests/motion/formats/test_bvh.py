"""Tests of reading BVH: all layouts of the format, variants that programs write, and errors that name the line."""

import time

import numpy as np
import pytest

from live.motion.formats.bvh_header import JOINT_LIMIT
from live.motion.formats.bvh_reader import parse_bvh
from live.motion.formats.file_error import MotionFileError

SMALL = """HIERARCHY
ROOT A
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT B
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -20 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
30 80 20 0 0 0 1 2 3
30 80 20 60 0 0 -30 0 4.5e-1
"""


def test_small_file_is_parsed_exactly() -> None:
    motion = parse_bvh(SMALL, "small.bvh")
    assert motion.names == ("A", "B")
    assert motion.parents.tolist() == [-1, 0]
    assert motion.offsets.tolist() == [[0, 0, 0], [10, 0, 0]]
    assert motion.channels == ("xyzZXY", "ZXY")
    assert motion.end_parents.tolist() == [1]
    assert motion.end_offsets.tolist() == [[0, -20, 0]]
    assert motion.values.tolist() == [[30, 80, 20, 0, 0, 0, 1, 2, 3], [30, 80, 20, 60, 0, 0, -30, 0, 0.45]]
    assert (motion.frame_count, motion.frames_declared, motion.header_fps) == (2, 2, 25.0)
    assert motion.warnings == ()
    assert not motion.values.flags.writeable


@pytest.mark.parametrize(
    "text",
    [
        SMALL.replace("\n", "\r\n"),
        SMALL.replace("\n", "\r"),
        SMALL.replace("  ", "\t"),
        "\ufeff" + SMALL,
        SMALL.removesuffix("\n"),
        SMALL + "\n \n\t\n",
        SMALL.replace("Frames: 2\nFrame Time: 0.04", "Frame Time:\t0.04\nFrames:\t2"),
        SMALL.replace("MOTION\n", "  motion\t\n\n").replace("Frame Time:", "FRAME TIME:"),
        SMALL.replace("\n{", " {").replace("End Site", "END SITE").replace("JOINT", "Joint"),
        SMALL.replace("30 80 20 0 0 0 1 2 3\n", "30 80 20\n0 0 0\n1 2 3\n"),
        SMALL.replace("1 2 3\n30", "1 2 3 30"),
        SMALL.replace("30 80", "  +3.0E+01   8.e1"),
    ],
    ids=["crlf", "cr", "tabs", "bom", "no end", "blank", "swapped", "case", "braces", "wrapped", "joined", "numbers"],
)
def test_all_notations_give_same_motion(text: str) -> None:
    motion = parse_bvh(text, "small.bvh")
    expected = parse_bvh(SMALL, "small.bvh")
    assert motion.values.tolist() == expected.values.tolist()
    assert (motion.names, motion.channels, motion.frame_time) == (expected.names, expected.channels, 0.04)


def test_any_channel_layout_is_read() -> None:
    text = """HIERARCHY
ROOT A { OFFSET 0 0 0 CHANNELS 6 Yrotation Xrotation Zrotation Zposition Yposition Xposition
  JOINT left arm { OFFSET 1 0 0
    JOINT C { OFFSET 1 0 0 CHANNELS 1 Xrotation } }
  JOINT D { OFFSET 0 1 0 CHANNELS 5 Xposition Zrotation Xrotation Zrotation Yposition }
  JOINT E { OFFSET 0 1 0 CHANNELS 0 } }
MOTION
Frames: 1
Frame Time: 0.01
1 2 3 4 5 6 7 8 9 10 11 12
"""
    motion = parse_bvh(text, "x")
    assert motion.channels == ("YXZzyx", "", "X", "xZXZy", "")
    assert motion.names[1] == "left arm"
    assert motion.end_parents.size == 0


@pytest.mark.parametrize(("declared", "held"), [(1, 2), (5, 2), (10**14, 2)])
def test_wrong_frame_count_gives_warning(declared: int, held: int) -> None:
    motion = parse_bvh(SMALL.replace("Frames: 2", f"Frames: {declared}"), "x")
    assert motion.frame_count == held
    assert motion.warnings == (f"says {declared} frames, holds {held} data lines: all of them are used",)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("HIERARCHY", "HIERARKHY", 1, "HIERARCHY expected"),
        ("ROOT A", "JOINT A", 2, "ROOT expected"),
        ("ROOT A", "ROOT", 2, "a joint without a name"),
        ("OFFSET 10 0 0", "OFFSET 10 0", 9, "'CHANNELS' as OFFSET z is not a number"),
        ("OFFSET 10 0 0", "OFFSET 10 nan 0", 8, "'nan' as OFFSET y is not a number"),
        ("OFFSET 10 0 0", "OFFSET 1e300 0 0", 8, "at most 1e7"),
        ("OFFSET 10 0 0", "OFFSET 1e999 0 0", 8, "at most 1e7"),
        ("OFFSET 10 0 0", "OFFSET 1_0 0 0", 8, "is not a number"),
        ("OFFSET 10 0 0\n", "", 8, "OFFSET expected"),
        ("CHANNELS 3", "CHANNELS three", 9, "'three' channels; 0 to 9 expected"),
        ("CHANNELS 3", "CHANNELS 40", 9, "'40' channels"),
        ("CHANNELS 3", "CHANNELS 4", 10, "channel 'End' is not known"),
        ("3 Zrotation", "3 Wrotation", 9, "channel 'Wrotation' is not known"),
        ("Yposition Z", "Xposition Z", 5, "'Xposition' is named twice"),
        ("    }\n  }\n}", "    }\n  }\n", 14, "the skeleton ends too early"),
        ("    }\n  }\n}", "    }\n  }\n}\n}", 16, "was read after the skeleton"),
        ("MOTION", "ROOT Z { OFFSET 0 0 0 }\nMOTION", 16, "one skeleton per file"),
        ("MOTION\n", "", 16, "'Frames:' was read after the skeleton; MOTION expected"),
        ("Frames: 2\n", "", 18, "Frames: COUNT expected"),
        ("Frames: 2", "Frames: two", 17, "a whole number expected"),
        ("Frames: 2", "Frames: -2", 17, "a whole number expected"),
        ("Frame Time: 0.04\n", "", 18, "Frame Time: SECONDS expected"),
        ("0.04", "0", 18, "0.0001 to 10 seconds expected"),
        ("0.04", "-0.04", 18, "0.0001 to 10 seconds expected"),
        ("0.04", "inf", 18, "is not a number"),
        ("0.04", "0,04", 18, "is not a number"),
        ("4.5e-1", "", 20, "8 numbers in this line, the last one: the file is cut off; 9 numbers"),
        ("4.5e-1", "4.5e-", 20, "'4.5e-' is not a number"),
        ("4.5e-1", "4.5 7", 20, "10 numbers in this line"),
        ("1 2 3", "1 2", 19, "8 numbers in this line; 9 numbers"),
        ("1 2 3", "1 x 3", 19, "'x' is not a number"),
        ("1 2 3", "1 nan 3", 19, "'nan' is not"),
        ("1 2 3", "1 -inf 3", 19, "'-inf' is not"),
        ("1 2 3", "1 1e400 3", 19, "finite, at most 1e7"),
        ("1 2 3", "1 2e7 3", 19, "'2e7' is not usable"),
        ("1 2 3", "1 ² 3", 19, "decimal numbers expected"),
        ("1 2 3", "1 2\0 3", 19, "is not a number"),
        ("30 80 20 0 0 0 1 2 3\n30 80 20 60 0 0 -30 0 4.5e-1\n", "", 19, "no frames; 2 lines of 9 numbers"),
    ],
)
def test_errors_name_file_line_and_expected_content(old: str, new: str, line: int, words: str) -> None:
    assert old in SMALL
    with pytest.raises(MotionFileError, match=words) as caught:
        parse_bvh(SMALL.replace(old, new, 1), "small.bvh")
    assert caught.value.file == "small.bvh"
    assert caught.value.line == line
    assert str(caught.value).startswith(f"small.bvh, line {line}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "\n\n", "hello", "\0" * 50, "{" * 1000, "MOTION", "\u2028" * 9, "HIERARCHY"])
def test_text_without_bvh_content_is_refused(text: str) -> None:
    with pytest.raises(MotionFileError) as caught:
        parse_bvh(text, "x")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def nested_joints(depth: int) -> str:
    inside = "".join(
        f"{'ROOT' if n == 0 else 'JOINT'} j{n} {{ OFFSET 0 1 0 CHANNELS 1 Xrotation\n" for n in range(depth)
    )
    return f"HIERARCHY\n{inside}{'}' * depth}\nMOTION\nFrames: 1\nFrame Time: 0.1\n{'1 ' * depth}\n"


def test_nesting_is_read_up_to_joint_limit() -> None:
    assert parse_bvh(nested_joints(JOINT_LIMIT), "deep").joint_count == JOINT_LIMIT
    with pytest.raises(MotionFileError, match="more than 1000 joints"):
        parse_bvh(nested_joints(JOINT_LIMIT + 1), "deep")
    with pytest.raises(MotionFileError, match="more than 1000 joints"):
        parse_bvh(nested_joints(100_000), "deep")


def test_number_count_over_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("live.motion.formats.bvh_numbers.VALUE_LIMIT", 17)
    with pytest.raises(MotionFileError, match="more than 17 numbers"):
        parse_bvh(SMALL, "x")


def test_2000_frames_of_43_joints_are_read_fast() -> None:
    """The limit is 50 ms on an idle machine; this takes the best of five, with a margin for a busy one."""
    rng = np.random.default_rng(1)
    head = "HIERARCHY\nROOT r { OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    joints = "".join(f"JOINT j{n} {{ OFFSET 0 1 0 CHANNELS 3 Zrotation Xrotation Yrotation }}\n" for n in range(42))
    values = rng.uniform(-180, 180, (2000, 132))
    rows = "\n".join(" ".join(f"{value:.5f}" for value in row) for row in values)
    text = f"{head}{joints}}}\nMOTION\nFrames: 2000\nFrame Time: 0.0083333\n{rows}\n"
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        motion = parse_bvh(text, "big")
        best = min(best, time.process_time() - start)
    np.testing.assert_allclose(motion.values, values, atol=1e-5)
    assert best < 0.15
