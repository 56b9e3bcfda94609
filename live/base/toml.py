"""Which line of a TOML text a key stands on, so that messages about a value can name it.

`tomllib` gives values without places. This scanner reads a text that `tomllib` has already accepted and only follows
keys, tables, strings and brackets; it judges nothing.

What to type where a text is no TOML: `tomllib` says what it met, and a person has to know what would do.

The text of a TOML file as plain values, whoever wrote it: what `tomllib` stumbles over is no valid TOML either.
"""

import contextlib
import re
import tomllib
from collections.abc import Iterator
from typing import Any, Final

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
    """What would mend what a `tomllib.TOMLDecodeError` says of `line` (from 1) of `text`."""
    lines = text.splitlines()
    written = lines[line - 1] if 0 < line <= len(lines) else ""
    if message.startswith("Cannot declare"):
        found = _KEY.search(message)
        key = "table" if found is None else found["key"].replace("', '", ".")
        return f"write [[{key}]] each time where there may be several, else all its keys under one [{key}]"
    if message.startswith("Invalid value"):
        return _of_value(written)
    return next((remedy for begins, remedy in _REMEDIES if message.startswith(begins)), "a line is key = value")


def _of_value(written: str) -> str:
    """What would do in place of the value of a line."""
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


MOST_KEYS: Final = 32
"""Keys joined by dots at most: `tomllib` takes the square of their number, and who walks the tables goes as deep."""
_JOINED: Final = re.compile(
    r"""(?<![\w.'"-])(?:(?:"[^"\n]*"|'[^'\n]*'|[A-Za-z0-9_-]++)[ \t]*+\.[ \t]*+){""" + str(MOST_KEYS) + "}"
)
_DIGITS: Final = re.compile(r"[0-9][0-9_]{3999}|0[xob][0-9A-Fa-f_]{17}")
"""A number that `int` refuses to read, or one that it refuses to write again."""


def toml_values(text: str) -> dict[str, Any]:
    """What a text says; tomllib.TOMLDecodeError, with the line in its message, for all that cannot be used.

    RecursionError for brackets in brackets without end.
    """
    joined = _JOINED.search(text)
    if joined is not None:
        raise _error(f"More than {MOST_KEYS} keys joined by dots", text, joined)
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
    """All whole numbers within tables and lists."""
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
