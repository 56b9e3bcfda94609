"""TOML texts for messages: the line of each key, remedies for syntax errors, and safe parsing.

`tomllib` gives values without positions. The scanner here reads a text that `tomllib` has accepted, follows only
keys, tables, strings and brackets, and checks nothing.
"""

import contextlib
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

KeyPath = tuple[str | int, ...]
"""Keys from the outermost table inwards; elements of arrays by their index from 0: ("group", 1, "count")."""

_BARE: Final = re.compile(r"[A-Za-z0-9_-]+")
_ERROR_LINE: Final = re.compile(r"line (\d+)")
_ESCAPES: Final = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", "e": "\x1b", '"': '"', "\\": "\\"}
_HEX_DIGITS: Final = {"x": 2, "u": 4, "U": 8}


def toml_line_numbers(text: str) -> dict[KeyPath, int]:
    """Return the line (from 1) of every key, table header and array element of a valid TOML text, by its path.

    Elements of an array of tables have the line of their own header. Of an invalid text, return the part understood.
    """
    scanner = _Scanner(text)
    with contextlib.suppress(IndexError, ValueError):  # not TOML after all: tomllib's message is better
        scanner.document()
    return scanner.lines


@dataclass(frozen=True, slots=True)
class TableHeader:
    """The header of a table in a text."""

    path: KeyPath
    """Its keys; entries of `[[ ]]` with their index: ("group", 1)."""
    line: int
    """Its line, from 1."""
    last_line: int
    """The line with which the table before it ends, comments and blank lines left out; 0 for none."""


def toml_headers(text: str) -> tuple[list[TableHeader], int]:
    """Return the headers of a valid TOML text, and the line with which its last key ends (0: there is none)."""
    scanner = _Scanner(text)
    scanner.document()
    return scanner.headers, scanner.last_line


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int:
    """Return the line of `path`, or of its nearest ancestor in the file; 1 if there is none."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return 1


def error_line(message: str, text: str) -> int:
    """Return the line named in a `tomllib.TOMLDecodeError` message ("at line 3, column 5"; else the last line)."""
    found = _ERROR_LINE.search(message)
    return int(found.group(1)) if found else text.count("\n") + 1


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text.replace("\r\n", "\n")
        self.at = 0
        self.line = 1
        self.lines: dict[KeyPath, int] = {}
        self.array_tables: dict[KeyPath, int] = {}
        self.headers: list[TableHeader] = []
        self.last_line = 0

    def document(self) -> None:
        table: KeyPath = ()
        while self._skip(newlines=True):
            if self.text[self.at] == "[":
                line = self.line
                table = self._header()
                self.headers.append(TableHeader(table, line, self.last_line))
            else:
                self._assignment(table)
            self.last_line = self.line

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
            if path in self.array_tables:  # a header below [[group]] belongs to its latest element
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
            if self.at == start:  # `[}` or `[,`: no value; without this error, `_array` would loop for ever
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
        while (
            len(fence) == 3 and self.text[self.at : self.at + 1] == quote
        ):  # """ may be preceded by quotes that belong to the text
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
        """Skip blanks, comments and, if asked, line ends; return whether anything is left."""
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


_KEY: Final = re.compile(r"\('?(?P<key>.*?)'?,?\)")
_ASSIGNED: Final = re.compile(r"^\s*(?P<key>[^=\[]+?)\s*=\s*(?P<value>.*?)\s*$")
_REMEDIES: Final = (
    ("Unclosed inline table", "close it with } on the same line"),
    ("Unclosed array", "close it with ]"),
    ("Unterminated string", "close the text with the quotes that it begins with"),
    ("Unescaped '\\'", "write / or \\\\ for \\, or put the text into 'single quotes'"),
    ("Expected ']]'", "close the name of the table with ]]"),
    ("Expected ']'", "close the name of the table with ]"),
    ("Expected newline", "one key = value on each line, nothing behind the value; a number has a point: 9.5"),
    ("Expected '='", "a line is key = value; a key has no blanks, or stands in quotes"),
    ("Duplicate inline table key", "leave one of them out"),
    ("Cannot overwrite a value", "the key is there already: leave one of them out"),
    ("Cannot redefine namespace", "the name is there already: leave one of them out, or write [[ ]] each time"),
    ("Cannot mutate immutable", "write all its keys where it stands first"),
    ("Invalid date or datetime", "text stands in quotes"),
    ("Invalid hex value", "a colour or other text stands in quotes"),
    ("Invalid initial character for a key", "a key is of letters, digits, - and _, or stands in quotes"),
    ("Invalid statement", "a line is key = value, [table], [[table]], or begins with #"),
    ("Illegal character", "close the text with quotes on the same line"),
    ("Found invalid character", "leave that character out"),
)


def toml_remedy(message: str, text: str, line: int) -> str:
    """Return the remedy for a `tomllib.TOMLDecodeError` message about `line` (from 1) of `text`."""
    lines = text.splitlines()
    written = lines[line - 1] if 0 < line <= len(lines) else ""
    if message.startswith("Cannot declare"):
        found = _KEY.search(message)
        key = "table" if found is None else found["key"].replace("', '", ".")
        return f"write [[{key}]] each time where there may be several, else all its keys under one [{key}]"
    if message.startswith("Invalid value"):
        return _value_remedy(written)
    return next((remedy for begins, remedy in _REMEDIES if message.startswith(begins)), "a line is key = value")


def _value_remedy(written: str) -> str:
    """Return the remedy for a line with an invalid value."""
    found = _ASSIGNED.match(written)
    value = "" if found is None else found["value"].partition("#")[0].strip()
    if value.lower() in ("true", "false"):
        return f"write {value.lower()}"
    if value.startswith(("“", "”", "„", "‘", "’", "«", "»")):
        return 'text stands in plain quotes: "..."'
    if re.fullmatch(r"[+-]?(\.[0-9]+|[0-9]+\.)", value):
        return "a number has a digit on both sides of its point: 0.5"
    if found is not None and not value:
        return "a value is missing behind ="
    if re.fullmatch(r"[^\W\d][\w /.:*-]*", value) and found is not None:
        return f'text stands in quotes: {found["key"]} = "{value[:60]}"'
    return "text stands in quotes, lists in [ ]; true and false are written small"


MAX_DOTTED_KEYS: Final = 32
"""Maximum number of keys joined by dots: `tomllib` takes quadratic time, and code that walks the tables recurses as
deep."""
_JOINED: Final = re.compile(
    r"""(?<![\w.'"-])(?:(?:"[^"\n]*"|'[^'\n]*'|[A-Za-z0-9_-]++)[ \t]*+\.[ \t]*+){""" + str(MAX_DOTTED_KEYS) + "}"
)
_DIGITS: Final = re.compile(r"[0-9][0-9_]{3999}|0[xob][0-9A-Fa-f_]{17}")
"""A number with too many digits for `int`, or for conversion back to text."""


def parse_toml(text: str) -> dict[str, Any]:
    """Return the values of a text; tomllib.TOMLDecodeError, with the line in its message, for everything unusable.

    RecursionError for too deeply nested brackets.
    """
    joined = _JOINED.search(text)
    if joined is not None:
        raise _error(f"More than {MAX_DOTTED_KEYS} keys joined by dots", text, joined)
    number = _DIGITS.search(text)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # int() takes no more than 4,300 digits
        raise _error("Number with too many digits", text, number) from None
    if number is not None and any(abs(each) >> 64 for each in _whole_numbers(values)):
        raise _error("Number with too many digits", text, number)
    return values


def _whole_numbers(values: object) -> Iterator[int]:
    """Return all integers within tables and lists."""
    waiting = [values]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
        elif isinstance(value, int):
            yield value


def _error(words: str, text: str, found: re.Match[str] | None) -> tomllib.TOMLDecodeError:
    line = 1 if found is None else text.count("\n", 0, found.start()) + 1
    return tomllib.TOMLDecodeError(f"{words} (at line {line}, column 1)")
