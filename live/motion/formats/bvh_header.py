"""Parser for the HIERARCHY part of a BVH file: joints, offsets and channels (T164)."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from live.motion.formats.file_error import MotionFileError, quoted, read_number

JOINT_LIMIT: Final = 1000
LINE_LIMIT: Final = 100_000
"""Maximum characters per line."""
CHANNEL_LIMIT: Final = 9
"""Maximum channels per joint."""
_NOT_BLANK: Final = re.compile(r"\S")
_COUNT: Final = re.compile(r"\d{1,9}", re.ASCII)
_CHANNELS: Final = {
    **{f"{axis}position".lower(): axis.lower() for axis in "XYZ"},
    **{f"{axis}rotation".lower(): axis for axis in "XYZ"},
}


@dataclass(slots=True)
class Hierarchy:
    """Joints in file order (a parent comes before its children) and End Sites."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[tuple[float, float, float]] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)
    """Per joint one letter per channel in file order: x y z = position along, X Y Z = rotation about that axis."""
    end_parents: list[int] = field(default_factory=list)
    end_offsets: list[tuple[float, float, float]] = field(default_factory=list)


class _TokenStream:
    """Token stream of the text with line numbers; braces are separate tokens."""

    def __init__(self, text: str, file: str) -> None:
        self.file, self.line = file, 1
        self._words = self._split(text)
        self._lookahead: tuple[int, str] | None = None

    @staticmethod
    def _split(text: str) -> Iterator[tuple[int, str]]:
        number, place = 1, 0
        while (start := _NOT_BLANK.search(text, place)) is not None:
            number += text.count("\n", place, start.start())
            place = start.start()
            end = text.find("\n", place)
            end = len(text) if end < 0 else end
            for word in text[place : min(end, place + LINE_LIMIT)].replace("{", " { ").replace("}", " } ").split():
                yield number, word
            if end - place > LINE_LIMIT:
                yield number, "a line of over 100000 letters"
            place = end

    def peek(self) -> tuple[int, str] | None:
        if self._lookahead is None:
            self._lookahead = next(self._words, None)
        return self._lookahead

    def next_token(self, expected: str) -> str:
        word = self.peek()
        if word is None:
            raise MotionFileError(self.file, self.line, "the skeleton ends too early", f"{expected} expected")
        self._lookahead = None
        self.line = word[0]
        return word[1]

    def keyword(self, *allowed: str) -> str:
        expected = " or ".join(allowed)
        word = self.next_token(expected)
        if word.upper() not in allowed:
            raise self.error(f"{quoted(word)} was read", f"{expected} expected")
        return word.upper()

    def rest_of_line(self) -> str:
        words = []
        while (word := self.peek()) is not None and word[0] == self.line and word[1] not in "{}":
            words.append(self.next_token(""))
        return " ".join(words)

    def number(self, what: str) -> float:
        return read_number(self.next_token(f"a number ({what})"), self.file, self.line, what)

    def error(self, problem: str, expected: str) -> MotionFileError:
        return MotionFileError(self.file, self.line, problem, expected)


def _read_channels(words: _TokenStream) -> str:
    text = words.next_token("the number of channels")
    if not _COUNT.fullmatch(text) or int(text) > CHANNEL_LIMIT:
        raise words.error(f"{quoted(text)} channels", f"0 to {CHANNEL_LIMIT} expected")
    letters = ""
    for _ in range(int(text)):
        name = words.next_token("a channel's name")
        letter = _CHANNELS.get(name.lower())
        if letter is None:
            raise words.error(
                f"channel {quoted(name)} is not known", "Xposition ... Zposition, Xrotation ... Zrotation"
            )
        if letter in letters and letter.islower():
            raise words.error(f"channel {quoted(name)} is named twice", "each position once expected")
        letters += letter
    return letters


def _read_offset(words: _TokenStream) -> tuple[float, float, float]:
    return words.number("OFFSET x"), words.number("OFFSET y"), words.number("OFFSET z")


def _open_joint(words: _TokenStream, hierarchy: Hierarchy, parent: int) -> int:
    name = words.rest_of_line()
    if not name or len(name) > 200:
        raise words.error("a joint without a name" if not name else "a name of over 200 letters", "JOINT NAME expected")
    words.keyword("{")
    if len(hierarchy.names) >= JOINT_LIMIT:
        raise words.error(f"more than {JOINT_LIMIT} joints", f"at most {JOINT_LIMIT} expected")
    words.keyword("OFFSET")
    hierarchy.names.append(name)
    hierarchy.parents.append(parent)
    hierarchy.offsets.append(_read_offset(words))
    following = words.peek()
    if following is not None and following[1].upper() == "CHANNELS":
        words.next_token("CHANNELS")
        hierarchy.channels.append(_read_channels(words))
    else:
        hierarchy.channels.append("")
    return len(hierarchy.names) - 1


def _read_end_site(words: _TokenStream, hierarchy: Hierarchy, parent: int) -> None:
    words.rest_of_line()  # "Site", sometimes with a name
    words.keyword("{")
    words.keyword("OFFSET")
    offset = _read_offset(words)
    words.keyword("}")
    if len(hierarchy.end_parents) >= JOINT_LIMIT:
        raise words.error(f"more than {JOINT_LIMIT} End Sites", f"at most {JOINT_LIMIT} expected")
    hierarchy.end_parents.append(parent)
    hierarchy.end_offsets.append(offset)


def parse_hierarchy(text: str, file: str) -> Hierarchy:
    """Parse everything from HIERARCHY up to (excluding) MOTION; raises MotionFileError.

    Keywords are case-insensitive, braces may be anywhere, joints may have no channels and leaves no End Site. One
    skeleton per file: a second ROOT is an error. The parser does not recurse, so depth is not limited by the stack.
    """
    words, hierarchy = _TokenStream(text, file), Hierarchy()
    words.keyword("HIERARCHY")
    words.keyword("ROOT")
    open_joints = [_open_joint(words, hierarchy, -1)]
    while open_joints:
        word = words.keyword("JOINT", "END", "ENDSITE", "}")
        if word == "JOINT":
            open_joints.append(_open_joint(words, hierarchy, open_joints[-1]))
        elif word == "}":
            open_joints.pop()
        else:
            _read_end_site(words, hierarchy, open_joints[-1])
    following = words.peek()
    if following is not None:
        word = words.next_token("")
        if word.upper() == "ROOT":
            raise words.error("a second ROOT", "one skeleton per file expected; save each performer in a separate file")
        raise words.error(f"{quoted(word)} was read after the skeleton", "MOTION expected")
    return hierarchy
