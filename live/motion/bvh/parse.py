"""BVH files: a skeleton and its recorded channels, any rotation order and channel layout (T164).

Reading is strict about what would dance wrongly (a number missing in a line, no number, NaN) and lenient about what
many programs write (Frames that miscounts, CRLF, tabs, keywords in other cases, joints without channels).
"""

import re
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.bvh.hierarchy import Hierarchy, parse_hierarchy
from live.motion.file_error import MAGNITUDE_LIMIT, MotionFileError, read_number, shown

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

VALUE_LIMIT: Final = 10_000_000
"""Numbers in the motion part of a file at most: ten minutes of 43 joints at 120 frames per second."""
FRAME_TIME_RANGE: Final = (1e-4, 10.0)
"""Seconds per frame that are believed."""

_MOTION: Final = re.compile(r"^[ \t]*MOTION[ \t]*$", re.MULTILINE | re.IGNORECASE)
_HEADER_LINE: Final = re.compile(r"\s*([A-Za-z][A-Za-z ]*?)\s*:?\s+(\S+)\s*", re.ASCII)
_FRAMES: Final = re.compile(r"\d{1,15}", re.ASCII)
_NO_NUMBER: Final = re.compile(r"(?<!\S)(?![+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?!\S))\S+", re.ASCII)


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


def parse_bvh(text: str, file: str) -> BvhMotion:
    """Read a whole BVH file from its text; `file` is its name for messages.

    Raises MotionFileError (and nothing else) for whatever else the text may be. Time is linear in its length.
    """
    text = text.removeprefix("\ufeff")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    motion = _MOTION.search(text)
    if motion is None:
        _refuse_what_is_no_bvh(text, file)
        parse_hierarchy(text, file)  # a broken skeleton is the better message
        raise MotionFileError(file, text.count("\n") + 1, "no MOTION section", "a file with recorded frames expected")
    hierarchy = parse_hierarchy(text[: motion.start()], file)
    line = text.count("\n", 0, motion.start()) + 1
    frames, frame_time, start, line = _read_motion_header(text, motion.end(), line, file)
    columns = sum(map(len, hierarchy.channels))
    if columns == 0:
        raise MotionFileError(file, line, "no joint has channels", "CHANNELS with rotations expected")
    values = _NumberBlock(text[start:], line, file).read(columns, frames)
    warnings = []
    if values.shape[0] != frames:
        warnings.append(f"says {frames} frames, holds {values.shape[0]} data lines: all of these are used")
    return _build(hierarchy, file, values, frame_time, frames, tuple(warnings))


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


def _refuse_what_is_no_bvh(text: str, file: str) -> None:
    start = text[:1000].lstrip()
    if not start[:9].upper() == "HIERARCHY":
        raise MotionFileError(file, 1, f"{shown(start[:20])} was read", "a BVH file begins with HIERARCHY")


def _read_motion_header(text: str, start: int, line: int, file: str) -> tuple[int, float, int, int]:
    """Frames, frame time [s], where the numbers begin in the text, and the line of that place."""
    frames: int | None = None
    frame_time: float | None = None
    start = min(text.find("\n", start) + 1 or len(text), len(text))
    while frames is None or frame_time is None:
        line += 1
        end = text.find("\n", start)
        content = text[start : min(end if end >= 0 else len(text), start + 500)]
        missing = "Frames: COUNT" if frames is None else "Frame Time: SECONDS"
        if not content.strip():
            if end < 0:
                raise MotionFileError(file, text.count("\n") + 1, "the file ends here", f"{missing} expected")
        else:
            match = _HEADER_LINE.fullmatch(content)
            key = match.group(1).lower().replace(" ", "") if match else ""
            if match is None or key not in ("frames", "frametime"):
                raise MotionFileError(file, line, f"{shown(content.strip())} was read", f"{missing} expected")
            if key == "frames":
                frames = _read_frame_count(match.group(2), file, line)
            else:
                frame_time = _read_frame_time(match.group(2), file, line)
        start = end + 1 if end >= 0 else len(text)
    return frames, frame_time, start, line + 1


def _read_frame_count(text: str, file: str, line: int) -> int:
    if not _FRAMES.fullmatch(text):
        raise MotionFileError(file, line, f"{shown(text)} frames", "a whole number expected")
    return int(text)


def _read_frame_time(text: str, file: str, line: int) -> float:
    seconds = read_number(text, file, line, "Frame Time")
    if not FRAME_TIME_RANGE[0] <= seconds <= FRAME_TIME_RANGE[1]:
        raise MotionFileError(file, line, f"Frame Time {shown(text)}", "0.0001 to 10 seconds expected")
    return seconds


class _NumberBlock:
    """The numbers after the header: one parse by numpy, and the lines they stand in for messages."""

    def __init__(self, text: str, line: int, file: str) -> None:
        self._text, self._line, self._file = text, line, file

    def read(self, columns: int, frames: int) -> Float64:
        """All frames, shape (T, columns); `frames` is only what the file claims."""
        starts = self._find_numbers()
        if starts.size == 0:
            raise self._error(0, "no frames", f"{frames} lines of {columns} numbers expected")
        values = self._parse(starts)
        strange = np.flatnonzero(~(np.abs(values) <= MAGNITUDE_LIMIT))  # catches NaN too
        if strange.size:
            place = int(starts[strange[0]])
            raise self._error(place, f"the number {self._word(place)} is not usable", "finite, at most 1e7 expected")
        self._check_lines(starts, columns)
        return values.reshape(-1, columns)

    def _find_numbers(self) -> Int64:
        """Where in the text each word begins."""
        if not self._text.isascii():
            place = next(i for i, letter in enumerate(self._text) if ord(letter) > 127)
            raise self._error(place, f"{shown(self._text[place])} among the numbers", "decimal numbers expected")
        self._bytes = np.frombuffer(self._text.encode("ascii"), np.uint8)
        inside = np.concatenate(([False], self._bytes > 32))
        begins = inside[1:] & ~inside[:-1]
        if np.count_nonzero(begins) > VALUE_LIMIT:
            raise self._error(0, f"more than {VALUE_LIMIT} numbers", "a shorter recording expected")
        return np.flatnonzero(begins)

    def _parse(self, starts: Int64) -> Float64:
        try:
            values = np.fromstring(self._text, np.float64, sep=" ")
        except (ValueError, DeprecationWarning):  # what numpy says depends on its version; what is wrong we find
            values = np.empty(0)
        if values.size != starts.size:
            bad = _NO_NUMBER.search(self._text)
            place = bad.start() if bad else int(starts[min(values.size, starts.size - 1)])
            raise self._error(place, f"{self._word(place)} is not a number", "decimal numbers expected")
        return values

    def _check_lines(self, starts: Int64, columns: int) -> None:
        """Every frame must end where a line ends, so that a lost number cannot shift all that follow."""
        ends = np.append(np.flatnonzero(self._bytes == 10), self._bytes.size)
        total = np.searchsorted(starts, ends)
        counts = np.diff(total, prepend=0)
        filled = counts > 0
        if (counts[filled] % columns == 0).all():
            return
        if starts.size % columns == 0 and np.isin(np.arange(columns, starts.size + 1, columns), total).all():
            return  # frames that run over several lines
        wrong = np.flatnonzero(filled & (counts % columns != 0))[0]
        last = wrong == np.flatnonzero(filled)[-1]
        problem = f"{counts[wrong]} numbers in this line" + (", the last one: the file is cut off" if last else "")
        place = int(starts[total[wrong] - 1])
        raise self._error(place, problem, f"{columns} numbers (one per channel) expected")

    def _word(self, place: int) -> str:
        return shown(self._text[place : place + 60].split()[0])

    def _error(self, place: int, problem: str, expected: str) -> MotionFileError:
        line = self._line + self._text.count("\n", 0, place)
        return MotionFileError(self._file, line, problem, expected)
