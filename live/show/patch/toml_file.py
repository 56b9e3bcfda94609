"""Reading a TOML file into a model of its sections, with errors that name file, line, field and what is allowed."""

import difflib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar

from pydantic import BaseModel, ValidationError

from live.base.errors import PersonError
from live.library.plain_file import read_plain
from live.show.patch.section_base import Amiss
from live.show.patch.toml_sources import TomlSources, parse_text

MAX_BYTES: Final = 4_000_000
SHOWN_PROBLEMS: Final = 8

Model = TypeVar("Model", bound=BaseModel)


def read_text(path: Path, what: str) -> str:
    """The text of a file; `what` it is in words, as in "patch". PersonError if it cannot be read."""
    try:
        data = read_plain(path, MAX_BYTES)
        if len(data) > MAX_BYTES:
            raise PersonError(f"{path}: {path.stat().st_size} bytes; a {what} has at most {MAX_BYTES}")
        return data.decode("utf-8-sig")  # some editors begin a file with a mark of its encoding
    except OSError as error:
        raise PersonError(f"cannot read the {what} {path}: {error.strerror}") from None
    except ValueError as error:
        if not isinstance(error, UnicodeDecodeError):  # a zero byte in the name
            raise PersonError(f"cannot read the {what} {path}: no file can be called so") from None
        raise PersonError(f"{path}: not a text in UTF-8 (byte {error.start})") from None


def parse_model(text: str, file: str, model: type[Model], what: str) -> Model:
    """What is written in `text`; `file` is named in errors. PersonError says what is wrong, and where."""
    return model_of(TomlSources([parse_text(text, file, what)]), model, what)


def model_of(
    sources: TomlSources,
    model: type[Model],
    what: str,
    check: Callable[[type[Model], dict[str, Any]], Model] | None = None,
) -> Model:
    """What is written in all `sources` together; PersonError says what is wrong, and where.

    `check` makes the model of the values, as `model_validate` does.
    """
    try:
        return model.model_validate(sources.data) if check is None else check(model, sources.data)
    except ValidationError as error:
        raise PersonError(_explain(error, sources, model, what)) from None


def _explain(error: ValidationError, sources: TomlSources, model: type[BaseModel], what: str) -> str:
    problems = []
    found = error.errors(include_url=False)
    for problem in found[:SHOWN_PROBLEMS]:
        where = tuple(problem["loc"])
        fault = problem.get("ctx", {}).get("error")
        if isinstance(fault, Amiss):
            where += fault.place
        problems.append(f"{sources.told(where)}: {field_words(where) or f'the {what}'}: {_words(problem, model)}")
    more = len(found) - SHOWN_PROBLEMS
    return "; ".join(problems) + (f"; and {more} more" if more > 0 else "")


def field_words(where: tuple[str | int, ...]) -> str:
    """A key as people are told of it: "element.3.measure", tables counted from 1."""
    return ".".join(str(part + 1) if isinstance(part, int) else part for part in where)


def _words(problem: Any, model: type[BaseModel]) -> str:
    """One problem in words: what was read, what is allowed."""
    kind, message, read = problem["type"], problem["msg"], problem["input"]
    if kind == "extra_forbidden":
        return f"unknown key; {_known_keys(problem['loc'], model)}"
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
    shown = repr(read) if isinstance(read, str | int | float | bool) else _KINDS.get(type(read), type(read).__name__)
    if isinstance(read, str) and kind.endswith(("_parsing", "_type")):
        message = message.partition(", unable to")[0]
        return f"{message[:1].lower()}{message[1:]}, found the text {shown[:60]}" + _unquoted(read)
    return f"{message[:1].lower()}{message[1:]}, found {shown[:60]}"


_KINDS: Final[dict[Any, str]] = {list: "a list", tuple: "a list", dict: "a table"}
"""Of what kind a value is, in words."""


def _unquoted(read: str) -> str:
    """What to do about a number or switch that stands in quotes."""
    value = read.strip().casefold()
    if value in ("true", "false"):
        return f"; write {value} without quotes"
    number = value.replace(",", ".", 1).lstrip("+-").replace(".", "", 1)
    return "; write the number without quotes, with a point" if number.isdecimal() else ""


def _known_keys(where: tuple[str | int, ...], of: type[BaseModel]) -> str:
    """The keys allowed where an unknown one stands, with the nearest spelling first if one is near."""
    model: Any = of
    for part in where[:-1]:
        if isinstance(part, int):
            continue
        annotation = model.model_fields[part].annotation
        inner = getattr(annotation, "__args__", None)
        model = inner[0] if inner else annotation
        if not hasattr(model, "model_fields"):
            return "see the reference"
    keys = list(model.model_fields)
    near = difflib.get_close_matches(str(where[-1]), keys, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    return f"{hint}allowed are {', '.join(keys)}"
