"""Which line of a TOML text a key stands on, so that messages about a value can name it.

`tomllib` gives values without places. This scanner reads a text that `tomllib` has already accepted and only follows
keys, tables, strings and brackets; it judges nothing.
"""

import contextlib
import re
from typing import Final

KeyPath = tuple[str | int, ...]
"""Keys from the outermost table inwards; elements of arrays by their index from 0: ("group", 1, "count")."""

_BARE: Final = re.compile(r"[A-Za-z0-9_-]+")
_ERROR_LINE: Final = re.compile(r"line (\d+)")
_ESCAPES: Final = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", "e": "\x1b", '"': '"', "\\": "\\"}
_HEX_DIGITS: Final = {"x": 2, "u": 4, "U": 8}


def toml_lines(text: str) -> dict[KeyPath, int]:
    """Line (from 1) of every key, table header and array element of a valid TOML text, by its path.

    Elements of an array of tables stand on their own header's line. An invalid text gives what was understood.
    """
    scanner = _Scanner(text)
    with contextlib.suppress(IndexError, ValueError):  # not TOML after all: tomllib says so better than this could
        scanner.document()
    return scanner.lines


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int:
    """Line of `path`, or of its nearest ancestor that stands in the file; 1 if there is none."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return 1


def error_line(message: str, text: str) -> int:
    """Line that a `tomllib.TOMLDecodeError` message speaks of ("at line 3, column 5"; else the last line)."""
    found = _ERROR_LINE.search(message)
    return int(found.group(1)) if found else text.count("\n") + 1


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text.replace("\r\n", "\n")
        self.at = 0
        self.line = 1
        self.lines: dict[KeyPath, int] = {}
        self.array_tables: dict[KeyPath, int] = {}

    def document(self) -> None:
        table: KeyPath = ()
        while self._skip(newlines=True):
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._assignment(table)

    def _header(self) -> KeyPath:
        line, many = self.line, self.text.startswith("[[", self.at)
        self.at += 2 if many else 1
        keys = self._keys()
        self.at += 2 if many else 1
        path: KeyPath = ()
        for position, key in enumerate(keys):
            path += (key,)
            self.lines.setdefault(path, line)
            if position == len(keys) - 1 and many:
                self.array_tables[path] = self.array_tables.get(path, -1) + 1
            if path in self.array_tables:  # a header below [[group]] speaks of its latest element
                path += (self.array_tables[path],)
                self.lines.setdefault(path, line)
        return path

    def _assignment(self, table: KeyPath) -> None:
        line, path = self.line, table
        for key in self._keys():
            path += (key,)
            self.lines.setdefault(path, line)
        self.at += 1  # the equals sign
        self._skip(newlines=False)
        self._value(path)

    def _value(self, path: KeyPath) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self._string()
        elif first == "[":
            self._array(path)
        elif first == "{":
            self._inline_table(path)
        else:
            start = self.at
            while self.at < len(self.text) and self.text[self.at] not in ",]}#\n":
                self.at += 1
            if self.at == start:  # `[}` or `[,`: no value at all, and an array would look for one here for ever
                raise ValueError(start)

    def _array(self, path: KeyPath) -> None:
        self.at += 1
        index = 0
        while self._skip(newlines=True) and self.text[self.at] != "]":
            self.lines.setdefault((*path, index), self.line)
            self._value((*path, index))
            index += 1
            self._skip(newlines=True)
            if self.text[self.at] == ",":
                self.at += 1
        self.at += 1

    def _inline_table(self, path: KeyPath) -> None:
        self.at += 1
        while self._skip(newlines=True) and self.text[self.at] != "}":
            self._assignment(path)
            self._skip(newlines=True)
            if self.text[self.at] == ",":
                self.at += 1
        self.at += 1

    def _keys(self) -> list[str]:
        keys = []
        while True:
            self._skip(newlines=False)
            if self.text[self.at] in "\"'":
                keys.append(self._string())
            else:
                found = _BARE.match(self.text, self.at)
                if found is None:
                    raise ValueError(self.at)
                keys.append(found.group())
                self.at = found.end()
            self._skip(newlines=False)
            if self.text[self.at] != ".":
                return keys
            self.at += 1

    def _string(self) -> str:
        quote = self.text[self.at]
        fence = quote * 3 if self.text.startswith(quote * 3, self.at) else quote
        self.at += len(fence)
        start, characters = self.at, []
        while not self.text.startswith(fence, self.at):
            character = self.text[self.at]
            if character == "\n":
                self.line += 1
            if character == "\\" and quote == '"':
                character = self._escape()
            characters.append(character)
            self.at += 1
            if self.at >= len(self.text):
                raise ValueError(start)
        self.at += len(fence)
        while len(fence) == 3 and self.text[self.at : self.at + 1] == quote:  # """ may end with quotes of its own
            self.at += 1
        return "".join(characters)

    def _escape(self) -> str:
        self.at += 1
        letter = self.text[self.at]
        if letter in _HEX_DIGITS:
            digits = self.text[self.at + 1 : self.at + 1 + _HEX_DIGITS[letter]]
            self.at += len(digits)
            return chr(int(digits, 16))
        if letter == "\n":
            self.line += 1
        return _ESCAPES.get(letter, "")

    def _skip(self, *, newlines: bool) -> bool:
        """Move over blanks, comments and, if asked, line ends; whether anything is left."""
        while self.at < len(self.text):
            character = self.text[self.at]
            if character == "#":
                end = self.text.find("\n", self.at)
                self.at = len(self.text) if end < 0 else end
            elif character == "\n" and newlines:
                self.line += 1
                self.at += 1
            elif character in " \t\r":
                self.at += 1
            else:
                return True
        return False
