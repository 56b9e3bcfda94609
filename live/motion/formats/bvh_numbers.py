"""Reader for the numbers of a BVH file's MOTION part: one pass over the bytes, errors with line numbers."""

import re
from itertools import islice
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.motion.formats.bvh_kernels import (
    COUNT,
    INEXACT,
    INVALID,
    OUT_OF_RANGE,
    WRAPPED,
    WRONG_COUNT,
    WRONG_LAST,
    WRONG_PLACE,
    scan_numbers,
)
from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, count_line_ends, quoted
from live.motion.formats.file_report import VALUE_LIMIT

INEXACT_LIMIT: Final = 1 << 14
"""Up to this many numbers beyond the kernel's precision are read one by one; if there are more, numpy reads all."""

_WORD: Final = re.compile(rb"[^ \t\n\r\f\v]+")


def read_numbers(data: bytes, start: int, columns: int, frames: int, file: str) -> Float64:
    """Read all frames from byte `start` on, shape (T, columns); `frames` is only the count that the file states.

    Every number is the nearest double, as from Python's `float`. Every frame must end at a line end, so that a missing
    number cannot shift the rest. Raises MotionFileError.
    """
    return _NumberBlock(data, start, file).read(columns, frames)


class _NumberBlock:
    def __init__(self, data: bytes, start: int, file: str) -> None:
        self._data, self._start, self._file = data, start, file
        self._text = np.frombuffer(bytearray(memoryview(data)[start:]) + b"\n", np.uint8)
        self._inexact: Int64 = np.empty((INEXACT_LIMIT, 2), np.int64)
        self._scan_result: Int64 = np.zeros(8, np.int64)

    def read(self, columns: int, frames: int) -> Float64:
        values = np.empty(min(frames * columns, self._text.size // 2 + 1, VALUE_LIMIT))
        scan_numbers(self._text, columns, values, self._inexact, self._scan_result)
        found = self._scan_result
        if found[INVALID] >= 0:
            raise self._not_a_number_error(int(found[INVALID]))
        count = int(found[COUNT])
        if count > VALUE_LIMIT:
            problem = f"more than {VALUE_LIMIT} numbers, in {count // columns} frames of {columns}"
            raise self._error(0, problem, "export it at 60 frames a second, without fingers, or cut it into pieces")
        if count == 0:
            raise self._error(0, "no frames", f"{frames} lines of {columns} numbers expected")
        if count > values.size:  # more frames than the file states
            values = np.empty(count)
            scan_numbers(self._text, columns, values, self._inexact, self._scan_result)
        values = values[:count] if count == values.size else values[:count].copy()
        values = self._read_inexact(values)
        if found[OUT_OF_RANGE] >= 0:
            place = int(found[OUT_OF_RANGE])
            problem = f"the number {quoted(self._word(place))} is not usable"
            raise self._error(place, problem, "finite, at most 1e7 expected")
        self._check_lines(columns, count)
        return values.reshape(-1, columns)

    def _read_inexact(self, values: Float64) -> Float64:
        """Return the values including the numbers beyond the kernel's exact arithmetic."""
        count, found = int(self._scan_result[INEXACT]), self._scan_result
        if count > INEXACT_LIMIT:
            values = np.fromstring(self._data[self._start :].decode("ascii"), np.float64, sep=" ")
            strange = np.flatnonzero(~(np.abs(values) <= MAGNITUDE_LIMIT))
            if strange.size:
                words = _WORD.finditer(self._data, self._start)
                found[OUT_OF_RANGE] = next(islice(words, int(strange[0]), None)).start() - self._start
            return values
        for index, place in self._inexact[:count].tolist():
            word = _WORD.match(self._data, self._start + place)
            values[index] = float(word.group()) if word else np.nan
            if not abs(values[index]) <= MAGNITUDE_LIMIT and (found[OUT_OF_RANGE] < 0 or place < found[OUT_OF_RANGE]):
                found[OUT_OF_RANGE] = place
        return values

    def _check_lines(self, columns: int, count: int) -> None:
        found = self._scan_result
        if found[WRONG_COUNT] == 0 or (found[WRAPPED] and count % columns == 0):
            return
        problem = f"{found[WRONG_COUNT]} numbers in this line"
        if found[WRONG_LAST]:
            problem += ", the last one: the file is cut off"
        raise self._error(int(found[WRONG_PLACE]), problem, f"{columns} numbers (one per channel) expected")

    def _not_a_number_error(self, place: int) -> MotionFileError:
        word = self._word(place)
        strange = next((letter for letter in word if not letter.isascii()), None)
        if strange is not None:
            return self._error(place, f"{quoted(strange)} among the numbers", "decimal numbers expected")
        return self._error(place, f"{quoted(word)} is not a number", "decimal numbers expected")

    def _word(self, place: int) -> str:
        at = self._start + place
        return self._data[at : at + 60].decode("utf-8", errors="replace").split(maxsplit=1)[0]

    def _error(self, place: int, problem: str, expected: str) -> MotionFileError:
        return MotionFileError(self._file, line_at(self._data, self._start + place), problem, expected)


def line_at(data: bytes, place: int) -> int:
    """Return the line number, from 1, of a byte; lines end with LF, CR or both."""
    return count_line_ends(data, 0, place) + 1
