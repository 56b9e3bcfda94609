"""The lines of a text file one after the other, without a copy of the whole; any line ends."""

import re
from collections.abc import Iterator
from typing import Final

from live.motion.formats.file_error import MotionFileError

LINE_LIMIT: Final = 100_000
"""Letters of a line at most."""
_NOTHING: Final = re.compile(rb"(?>\s++|#[^\r\n]*+)*+")
"""Blanks and comments; possessive, so that none of it is remembered."""
_END: Final = re.compile(rb"[\r\n]")


def words_of_lines(data: bytes, file: str) -> Iterator[tuple[int, list[str]]]:
    """Number (from 1) and words of each line that holds any; what follows a # is left out.

    Raises MotionFileError for lines of over 100,000 letters.
    """
    place, number = 0, 1
    while True:
        nothing = _NOTHING.match(data, place)
        start = nothing.end() if nothing else place
        number += line_ends(data, place, start)
        place = start
        if place == len(data):
            return
        following = _END.search(data, place)
        end = following.start() if following else len(data)
        if end - place > LINE_LIMIT:
            raise MotionFileError(file, number, f"a line of {end - place} letters", "an ASF or AMC file expected")
        words = data[place:end].decode("utf-8", errors="replace").split("#", 1)[0].split()
        if words:
            yield number, words
        place = end


def line_ends(data: bytes, start: int, end: int) -> int:
    """How many lines end in data[start:end], with LF, CR or both; a CR LF must not be cut in two."""
    ends = data.count(b"\n", start, end) + data.count(b"\r", start, end)
    return ends - data.count(b"\r\n", start, end)
