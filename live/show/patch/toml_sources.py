"""TomlSources: tables merged from several TOML files, and for every key of the whole the file and line it stands on."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from live.base.errors import PersonError
from live.base.toml_lines import KeyPath, error_line, line_of, toml_lines
from live.base.toml_remedy import toml_remedy
from live.base.toml_text import toml_values


@dataclass(eq=False)
class TomlText:
    """One file that has been read: its name in messages, its text and what that says."""

    file: str
    text: str
    data: dict[str, Any]

    @cached_property
    def lines(self) -> dict[KeyPath, int]:
        """Line of every key; found out when somebody asks, which is when something is wrong."""
        return toml_lines(self.text)

    def line(self, path: KeyPath) -> int:
        """Line of a key of this file, or of the nearest table around it."""
        return line_of(self.lines, path)


def parse_text(text: str, file: str, what: str) -> TomlText:
    """What a text says; PersonError with file and line if it is not TOML. `what` it is in words, as in "patch"."""
    try:
        return TomlText(file, text, toml_values(text))
    except tomllib.TOMLDecodeError as error:
        line = error_line(str(error), text)
        raise PersonError(
            f"{file}, line {line}: not valid TOML: {error}", toml_remedy(str(error), text, line)
        ) from None
    except RecursionError:
        raise PersonError(f"{file}: not a {what}: its brackets are nested too deep") from None


@dataclass(eq=False)
class TomlSources:
    """Several texts as one: tables of one kind follow each other, keys of one table come together.

    The first text is the main one: what stands nowhere is looked for there.
    """

    texts: Sequence[TomlText]
    data: dict[str, Any] = field(default_factory=dict)
    """All of them together."""
    _rows: dict[str, list[tuple[TomlText, int]]] = field(default_factory=dict)
    _keys: dict[KeyPath, TomlText] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for text in self.texts:
            for key, value in text.data.items():
                self._take((key,), value, self.data, text)

    def _take(self, path: KeyPath, value: Any, into: dict[str, Any], text: TomlText) -> None:
        """One key of one text into the whole; PersonError if it stands in another one already."""
        key = str(path[-1])
        if len(path) == 1 and isinstance(value, list) and isinstance(into.get(key, []), list):
            self._keys.setdefault(path, text)
            into.setdefault(key, []).extend(value)
            self._rows.setdefault(key, []).extend((text, index) for index in range(len(value)))
        elif isinstance(value, dict) and isinstance(into.get(key, {}), dict):
            self._keys.setdefault(path, text)
            table = into.setdefault(key, {})
            for name, inner in value.items():
                self._take((*path, name), inner, table, text)
        elif key in into:
            there = self._keys[path]
            raise PersonError(
                f"{text.file}, line {text.line(path)}: {'.'.join(map(str, path))}: stands already in {there.file}, "
                f"line {there.line(path)}",
                "leave one of them out",
            )
        else:
            into[key] = value
            self._keys[path] = text

    def where(self, path: KeyPath) -> tuple[str, int]:
        """File and line of a key of the whole, ("element", 57, "measure"); of the nearest table around it."""
        if len(path) > 1 and isinstance(path[1], int):
            rows = self._rows.get(str(path[0]), [])
            if path[1] < len(rows):
                text, index = rows[path[1]]
                return text.file, text.line((path[0], index, *path[2:]))
        for length in range(len(path), 0, -1):
            found = self._keys.get(path[:length])
            if found is not None:
                return found.file, found.line(path)
        return self.texts[0].file, self.texts[0].line(path)

    def told(self, path: KeyPath) -> str:
        """Where that is, in words."""
        file, line = self.where(path)
        return f"{file}, line {line}"
