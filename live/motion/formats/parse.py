"""BVH files: a skeleton and its recorded channels, any rotation order and channel layout (T164).

Reading is strict about what would dance wrongly (a number missing in a line, no number, NaN) and lenient about what
many programs write (Frames that miscounts, CRLF, tabs, keywords in other cases, joints without channels).
"""

import re
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.formats.bvh_header import Hierarchy, parse_hierarchy
from live.motion.formats.bvh_numbers import line_at, read_numbers
from live.motion.formats.file_error import MotionFileError, read_number, shown
from live.motion.formats.motion_size import refuse_too_large

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

FRAME_TIME_RANGE: Final = (1e-4, 10.0)
"""Seconds per frame that are believed."""

SKELETON_BYTES: Final = 4_000_000
"""Length of the first part of a file at most: a thousand joints take less than a tenth of it."""

_MOTION: Final = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*MOTION[ \t]*(?=[\r\n]|\Z)", re.IGNORECASE)
_LINE: Final = re.compile(rb"([^\r\n]*)(\r\n|\r|\n|\Z)")
_HEADER_LINE: Final = re.compile(r"\s*([A-Za-z][A-Za-z ]*?)\s*:?\s+(\S+)\s*", re.ASCII)
_NOT_BLANK: Final = re.compile(rb"\S")
_FRAMES: Final = re.compile(r"\d{1,15}", re.ASCII)


@dataclass(frozen=True, slots=True, eq=False)
class BvhMotion:
    """What one file holds: J joints (End Sites are not joints), C channels, T frames; units as in the file."""

    file: str
    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, which always comes before it; -1 for the root, shape (J,)."""
    offsets: Float64
    """OFFSET of each joint [file units], shape (J, 3)."""
    channels: tuple[str, ...]
    """Per joint one letter per channel in file order: x y z = position along, X Y Z = rotation about that axis."""
    end_parents: Int32
    """Joint that carries each of the E End Sites, shape (E,)."""
    end_offsets: Float64
    """OFFSET of each End Site [file units], shape (E, 3)."""
    values: Float64
    """The channels of every frame [file units, degrees], shape (T, C)."""
    frame_time: float
    """Seconds per frame as the file says it (it may lie)."""
    frames_declared: int
    """Number of frames as the file says it (it may lie)."""
    warnings: tuple[str, ...]
    """What was strange but usable."""

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    @property
    def frame_count(self) -> int:
        """Number of frames T that the file really holds."""
        return int(self.values.shape[0])

    @property
    def header_fps(self) -> float:
        """Frames per second as the file says it."""
        return 1.0 / self.frame_time


def parse_bvh(data: bytes | str, file: str) -> BvhMotion:
    """Read a whole BVH file from its bytes (or text); `file` is its name for messages.

    Raises MotionFileError (and nothing else) for whatever else the bytes may be. Time is linear in their length.
    """
    if isinstance(data, str):
        data = data.encode("utf-8", errors="replace")
    data = data.removeprefix(b"\xef\xbb\xbf")
    motion = _MOTION.search(data, 0, SKELETON_BYTES)
    if motion is None:
        raise _no_motion(data, file)
    hierarchy = parse_hierarchy(_text(data[: motion.start()]), file)
    frames, frame_time, start = _read_motion_header(data, motion.end(), file)
    columns = sum(map(len, hierarchy.channels))
    if columns == 0:
        raise MotionFileError(file, line_at(data, start), "no joint has channels", "CHANNELS with rotations expected")
    values = read_numbers(data, start, columns, frames, file)
    refuse_too_large(file, len(values), len(hierarchy.names), columns, len(data))
    warnings = []
    if values.shape[0] != frames:
        warnings.append(f"says {frames} frames, holds {values.shape[0]} data lines: all of these are used")
    return _build(hierarchy, file, values, frame_time, frames, tuple(warnings))


def _text(data: bytes) -> str:
    return data.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n")


def _no_motion(data: bytes, file: str) -> MotionFileError:
    text = _text(data[:SKELETON_BYTES])
    start = text[:1000].lstrip()
    if start[:9].upper() != "HIERARCHY":
        return MotionFileError(file, 1, f"{shown(start[:20])} was read", "a BVH file begins with HIERARCHY")
    parse_hierarchy(text, file)  # a broken skeleton is the better message
    if len(data) > SKELETON_BYTES:
        text = f"no MOTION within the first {SKELETON_BYTES} bytes"
        return MotionFileError(file, None, text, "a file with recorded frames expected")
    return MotionFileError(file, text.count("\n") + 1, "no MOTION section", "a file with recorded frames expected")


def _build(
    hierarchy: Hierarchy, file: str, values: Float64, frame_time: float, frames: int, warnings: tuple[str, ...]
) -> BvhMotion:
    arrays = (
        np.array(hierarchy.parents, np.int32),
        np.array(hierarchy.offsets, np.float64).reshape(-1, 3),
        np.array(hierarchy.end_parents, np.int32),
        np.array(hierarchy.end_offsets, np.float64).reshape(-1, 3),
        values,
    )
    for array in arrays:
        array.setflags(write=False)
    return BvhMotion(
        file=file,
        names=tuple(hierarchy.names),
        parents=arrays[0],
        offsets=arrays[1],
        channels=tuple(hierarchy.channels),
        end_parents=arrays[2],
        end_offsets=arrays[3],
        values=values,
        frame_time=frame_time,
        frames_declared=frames,
        warnings=warnings,
    )


def _read_motion_header(data: bytes, place: int, file: str) -> tuple[int, float, int]:
    """Frames, frame time [s], and the byte from which on there are numbers; `place` is the end of the word MOTION."""
    frames: int | None = None
    frame_time: float | None = None
    place = _next_line(data, place)
    while frames is None or frame_time is None:
        missing = "Frames: COUNT" if frames is None else "Frame Time: SECONDS"
        word = _NOT_BLANK.search(data, place)
        if word is None:
            raise MotionFileError(file, line_at(data, len(data)), "the file ends here", f"{missing} expected")
        line = line_at(data, word.start())
        place = _next_line(data, word.start())
        content = _text(data[word.start() : min(place, word.start() + 500)]).strip()
        match = _HEADER_LINE.fullmatch(content)
        key = match.group(1).lower().replace(" ", "") if match else ""
        if match is None or key not in ("frames", "frametime"):
            raise MotionFileError(file, line, f"{shown(content)} was read", f"{missing} expected")
        if (frames if key == "frames" else frame_time) is not None:
            raise MotionFileError(file, line, f"{shown(content)} a second time", f"{missing} expected")
        if key == "frames":
            frames = _read_frame_count(match.group(2), file, line)
        else:
            frame_time = _read_frame_time(match.group(2), file, line)
    return frames, frame_time, place


def _next_line(data: bytes, place: int) -> int:
    """Where the line after this one begins."""
    match = _LINE.match(data, place)
    return match.end() if match else len(data)


def _read_frame_count(text: str, file: str, line: int) -> int:
    if not _FRAMES.fullmatch(text):
        raise MotionFileError(file, line, f"{shown(text)} frames", "a whole number expected")
    return int(text)


def _read_frame_time(text: str, file: str, line: int) -> float:
    seconds = read_number(text, file, line, "Frame Time")
    if not FRAME_TIME_RANGE[0] <= seconds <= FRAME_TIME_RANGE[1]:
        raise MotionFileError(file, line, f"Frame Time {shown(text)}", "0.0001 to 10 seconds expected")
    return seconds
