"""The lines of a text file one after the other, without a copy of the whole; any line ends."""

from collections.abc import Iterator
from typing import Final

from live.motion.file_error import MotionFileError

LINE_LIMIT: Final = 100_000
"""Letters of a line at most."""


def words_of_lines(data: bytes, file: str) -> Iterator[tuple[int, list[str]]]:
    """Number (from 1) and words of each line that holds any; what follows a # is left out.

    Raises MotionFileError for lines of over 100,000 letters.
    """
    place, number = 0, 0
    while place < len(data):
        end = data.find(b"\n", place)
        end = len(data) if end < 0 else end
        if end - place > LINE_LIMIT:
            raise MotionFileError(file, number + 1, f"a line of {end - place} letters", "an ASF or AMC file expected")
        for line in data[place:end].decode("utf-8", errors="replace").removesuffix("\r").split("\r"):
            number += 1
            words = line.split("#", 1)[0].split()
            if words:
                yield number, words
        place = end + 1
