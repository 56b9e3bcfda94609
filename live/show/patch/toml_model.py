"""Models from TOML texts: errors name file, line, field and the allowed values; several texts are merged."""

import difflib
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol, TypeVar

from pydantic import BaseModel, ValidationError

from live import __version__
from live.base.errors import PersonError
from live.base.toml import KeyPath, error_line, line_of, parse_toml, toml_line_numbers, toml_remedy
from live.library.disk_cache import read_regular_file
from live.show.patch.section_base import Checks, InvalidEntry, Section, WholeFile
from live.show.patch.table_batches import validate_model


class FileValues(Protocol):
    """One file's name in messages, its values, and the lines of its keys."""

    @property
    def file(self) -> str: ...
    @property
    def data(self) -> dict[str, Any]: ...
    def line(self, path: KeyPath) -> int: ...


@dataclass(eq=False)
class TomlText:
    """One file that was read: its name in messages, its text and its values."""

    file: str
    text: str
    data: dict[str, Any]

    @cached_property
    def lines(self) -> dict[KeyPath, int]:
        """Line of every key; computed only when an error needs it."""
        return toml_line_numbers(self.text)

    def line(self, path: KeyPath) -> int:
        """Return the line of a key of this file, or of the nearest table around it."""
        return line_of(self.lines, path)


def parse_text(text: str, file: str, what: str) -> TomlText:
    """Parse a text; PersonError with file and line if it is not TOML. `what` names its kind, as in "patch"."""
    try:
        return TomlText(file, text, parse_toml(text))
    except tomllib.TOMLDecodeError as error:
        line = error_line(str(error), text)
        raise PersonError(
            f"{file}, line {line}: not valid TOML: {error}", toml_remedy(str(error), text, line)
        ) from None
    except RecursionError:
        raise PersonError(f"{file}: not a {what}: its brackets are nested too deep") from None


@dataclass(eq=False)
class TomlSources:
    """Several texts merged: arrays of tables are concatenated, keys of one table united.

    The first text is the main one: a key found nowhere is reported there.
    """

    texts: Sequence[FileValues]
    data: dict[str, Any] = field(default_factory=dict)
    """The merged values."""
    _rows: dict[str, list[tuple[FileValues, int]]] = field(default_factory=dict)  # each text's number of tables
    _keys: dict[KeyPath, FileValues] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for text in self.texts:
            for key, value in text.data.items():
                self._merge((key,), value, self.data, text)

    def _merge(self, path: KeyPath, value: Any, into: dict[str, Any], text: FileValues) -> None:
        """Merge one key of one text; PersonError if another text has it already."""
        key = str(path[-1])
        if len(path) == 1 and isinstance(value, list) and isinstance(into.get(key, []), list):
            self._keys.setdefault(path, text)
            into.setdefault(key, []).extend(value)
            self._rows.setdefault(key, []).append((text, len(value)))
        elif isinstance(value, dict) and isinstance(into.get(key, {}), dict):
            self._keys.setdefault(path, text)
            table = into.setdefault(key, {})
            for name, inner in value.items():
                self._merge((*path, name), inner, table, text)
        elif key in into:
            there = self._keys[path]
            raise PersonError(
                f"{text.file}, line {text.line(path)}: {'.'.join(map(str, path))}: already given in {there.file}, "
                f"line {there.line(path)}",
                "leave one of them out",
            )
        else:
            into[key] = value
            self._keys[path] = text

    def location(self, path: KeyPath) -> tuple[str, int]:
        """Return file and line of a merged key, as ("element", 57, "measure"), or of the nearest table around it."""
        if len(path) > 1 and isinstance(path[1], int):
            index = path[1]
            for text, count in self._rows.get(str(path[0]), []):
                if index < count:
                    return text.file, text.line((path[0], index, *path[2:]))
                index -= count
        for length in range(len(path), 0, -1):
            found = self._keys.get(path[:length])
            if found is not None:
                return found.file, found.line(path)
        return self.texts[0].file, self.texts[0].line(path)

    def location_text(self, path: KeyPath) -> str:
        """Return the same in words."""
        file, line = self.location(path)
        return f"{file}, line {line}"


MAX_BYTES: Final = 4_000_000
SHOWN_PROBLEMS: Final = 8

Model = TypeVar("Model", bound=BaseModel)
BridgeTables = Sequence[type[Section]]
"""Sections whose fields are the tables that bridges add to a file."""


def read_text(path: Path, what: str) -> str:
    """Return the text of a file; PersonError if it cannot be read. `what` names its kind, as in "patch"."""
    try:
        data = read_regular_file(path, MAX_BYTES)
        if len(data) > MAX_BYTES:
            raise PersonError(f"{path}: {path.stat().st_size} bytes; a {what} has at most {MAX_BYTES}")
        return data.decode("utf-8-sig")  # some editors write a byte order mark
    except OSError as error:
        raise PersonError(f"cannot read the {what} {path}: {error.strerror}") from None
    except ValueError as error:
        if not isinstance(error, UnicodeDecodeError):  # a zero byte in the name
            raise PersonError(f"cannot read the {what} {path}: no file can have this name") from None
        raise PersonError(f"{path}: not a text in UTF-8 (byte {error.start})") from None


def parse_model(
    text: str, file: str, model: type[Model], what: str, checks: Checks | None = None, tables: BridgeTables = ()
) -> Model:
    """Return the model of `text`; PersonError with file, line and problem. `file` is its name in errors."""
    return validate_sources(TomlSources([parse_text(text, file, what)]), model, what, checks, tables)


def validate_sources(
    sources: TomlSources, model: type[Model], what: str, checks: Checks | None = None, tables: BridgeTables = ()
) -> Model:
    """Return the model of all `sources` together, checked by `checks`; PersonError with file, line and problem.

    Of a `WholeFile`, the bridges' `tables` are checked, too; a table that no bridge reads is kept if it looks like no
    other.
    """
    data, wrong = (
        _read_bridge_tables(sources.data, model, tables) if issubclass(model, WholeFile) else (sources.data, [])
    )
    try:
        made = validate_model(model, data, checks)
        if not wrong:
            return made
    except ValidationError as error:
        wrong = [*error.errors(include_url=False), *wrong]
    raise InvalidModel(wrong, sources, (model, *tables), what)


def _read_bridge_tables(
    data: dict[str, Any], model: type[WholeFile], tables: BridgeTables
) -> tuple[dict[str, Any], list[Any]]:
    """Return the values, with the bridges' tables as their sections give them, and the errors of pydantic's form."""
    read, wrong = dict(data), []
    known = [name for section in (model, *tables) for name in section.model_fields]
    for section in tables:
        own = {name: data[name] for name in section.model_fields if name in data}
        try:
            read |= section.model_validate(own).model_dump(mode="json", exclude_unset=True)
        except ValidationError as error:
            wrong += error.errors(include_url=False)
    for key, value in data.items():
        if key not in known and (not _is_table(value) or difflib.get_close_matches(key, known, n=1)):
            wrong.append({"type": "extra_forbidden", "loc": (key,), "msg": "", "input": value})
    return read, wrong


def _is_table(value: Any) -> bool:
    """Return whether a value of TOML is a table or a list of tables."""
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


class Problem(NamedTuple):
    """One error in files."""

    file: str
    line: int
    key_path: KeyPath
    text: str
    """The value read, and what is allowed."""


UNKNOWN_KEY: Final = "unknown key"


class InvalidModel(PersonError):
    """All errors that a validation found; its message shows the first ones."""

    def __init__(
        self, found: Sequence[Any], sources: TomlSources, models: Sequence[type[BaseModel]], what: str
    ) -> None:
        """`found` are pydantic's errors of the values of `sources`."""
        self._sources, self._models = sources, models
        self._found: list[tuple[KeyPath, Any]] = []
        entries = {tuple(problem["loc"])[:end] for problem in found for end in range(1, len(problem["loc"]))}
        for problem in found:
            where: KeyPath = tuple(problem["loc"])
            if problem["type"] == "too_short" and where in entries:
                continue  # faulty entries were left out before it was counted
            fault = problem.get("ctx", {}).get("error")
            if isinstance(fault, InvalidEntry):  # of a check that found several at once
                self._found += [(where + one.key_path, one) for one in (fault, *fault.others)]
            else:
                self._found.append((where, problem))
        shown = self.problems(SHOWN_PROBLEMS)
        more = len(self._found) - len(shown)
        words = [
            f"{each.file}, line {each.line}: {key_text(each.key_path) or f'the {what}'}: {each.text}" for each in shown
        ]
        words += [f"and {more} more"] if more > 0 else []
        newer = any(each.text.startswith(f"{UNKNOWN_KEY}; allowed") for each in shown)
        remedy = f"remove what is unknown; version {__version__} of the program may be older than the {what}"
        super().__init__("; ".join(words), remedy if newer else None, faults=tuple(words) if len(words) > 1 else ())

    def problems(self, limit: int) -> list[Problem]:
        """Return the first `limit` errors."""
        return [
            Problem(
                *self._sources.location(where),
                where,
                str(one) if isinstance(one, InvalidEntry) else _problem_text(one, self._models),
            )
            for where, one in self._found[:limit]
        ]


def key_text(where: tuple[str | int, ...]) -> str:
    """Return a key as messages show it: "element.3.measure", with tables counted from 1."""
    return ".".join(str(part + 1) if isinstance(part, int) else part for part in where)


def _problem_text(problem: Any, models: Sequence[type[BaseModel]]) -> str:
    """One problem in words: the value read, and what is allowed."""
    kind, message, read = problem["type"], problem["msg"], problem["input"]
    if kind == "extra_forbidden":
        return f"{UNKNOWN_KEY}; {_allowed_keys(problem['loc'], models)}"
    if kind == "missing":
        return "missing; it must be given"
    if kind == "value_error":
        return str(message).removeprefix("Value error, ")
    context = problem.get("ctx", {})
    if kind == "too_short":
        return f"at least {context['min_length']} expected, found {context['actual_length']}"
    if kind == "too_long":
        return f"at most {context['max_length']} expected, found {context['actual_length']}"
    name = problem["loc"][-1]
    if kind == "model_type":
        several = isinstance(read, list) and read and isinstance(read[0], dict)
        return f"a table expected, found {str(read)[:40]}" + (f"; there is one: write [{name}]" if several else "")
    if kind == "tuple_type" and isinstance(read, dict):
        return f"a list of tables expected, found one table; write [[{name}]] each time"
    if kind == "tuple_type":
        message = "a list expected"
    shown = (
        repr(read) if isinstance(read, str | int | float | bool) else _TYPE_NAMES.get(type(read), type(read).__name__)
    )
    if isinstance(read, str) and kind.endswith(("_parsing", "_type")):
        message = message.partition(", unable to")[0]
        return f"{message[:1].lower()}{message[1:]}, found the text {shown[:60]}" + _quote_remedy(read)
    return f"{message[:1].lower()}{message[1:]}, found {shown[:60]}"


_TYPE_NAMES: Final[dict[Any, str]] = {list: "a list", tuple: "a list", dict: "a table"}
"""Names of TOML's compound types."""


def _quote_remedy(read: str) -> str:
    """Remedy for a number or boolean in quotes."""
    value = read.strip().casefold()
    if value in ("true", "false"):
        return f"; write {value} without quotes"
    number = value.replace(",", ".", 1).lstrip("+-").replace(".", "", 1)
    return "; write the number without quotes, with a point" if number.isdecimal() else ""


def _allowed_keys(where: tuple[str | int, ...], models: Sequence[type[BaseModel]]) -> str:
    """The allowed keys in place of an unknown one, with the nearest spelling first if one is near."""
    fields = {name: each for model in models for name, each in model.model_fields.items()}
    for part in where[:-1]:
        if isinstance(part, int):
            continue
        annotation = fields[part].annotation
        inner = getattr(annotation, "__args__", None)
        table: Any = inner[0] if inner else annotation
        if not hasattr(table, "model_fields"):
            return "see the reference"
        fields = table.model_fields
    keys, wrong = list(fields), str(where[-1])
    near = difflib.get_close_matches(wrong, keys, n=1)
    if near:
        return f"did you mean {near[0]!r}? allowed are {', '.join(keys)}"
    below = [(key, name) for name, each in fields.items() for key in _keys_below(each.annotation)]
    near = difflib.get_close_matches(wrong, {key for key, _ in below}, n=3, cutoff=0.66)
    places = [f"{key} in [{name}]" for key, name in below if key in near]
    hint = f"did you mean {' or '.join(places)}? " if places else ""
    return f"{hint}allowed are {', '.join(keys)}"


def _keys_below(annotation: Any) -> list[str]:
    """The keys of the table that is the value of a key; none if it is no table."""
    return list(getattr(annotation, "model_fields", ()))
