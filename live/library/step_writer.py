"""Writer that appends a step to a TOML text and keeps everything that a person wrote in it."""

import tomllib
from collections.abc import Mapping
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.base.toml import toml_line_numbers
from live.library.recording_file import Recording


def append_step(text: str, table: Mapping[str, Any], comments: Mapping[str, str] | None = None) -> str | None:
    """Return the TOML `text` (empty for a new file) with one more `[[step]]` at its end; comments and blanks are kept.

    `table` has the step's values by the fields of Recording; those equal to the file's defaults are not written.
    `comments` are written behind the lines of their fields. A file with one recording at its top level becomes one
    with two `[[step]]`. None if the text cannot take the step: it is another kind of file, or one of its defaults
    does not hold for the step and cannot be overridden.
    """
    try:
        before = tomllib.loads(text)
        if before and "step" not in before:
            text = _as_first_step(text)
        document = tomlkit.parse(text)
    except (tomllib.TOMLDecodeError, TOMLKitError, RecursionError):
        return None
    old = document.unwrap()
    steps = old.get("step", [])
    if "pair" in old or not isinstance(steps, list) or (not steps and old) or not all(map(_is_table, steps)):
        return None
    written = _without_defaults({key: value for key, value in old.items() if key != "step"}, table)
    if written is None:
        return None
    step = tomlkit.table()
    for key in Recording.model_fields:
        if key in written:
            step.add(key, _toml_value(written[key]))
            if comments and key in comments:
                step[key].comment(comments[key])
    if steps:
        document["step"].append(step)
        result = tomlkit.dumps(document)
        at = result.rfind("[[step]]")
        result = result[:at].rstrip("\n") + "\n\n" + result[at:] if at > 0 else result
    else:
        array = tomlkit.aot()
        array.append(step)
        document["step"] = array
        result = tomlkit.dumps(document)
    expected = old | {"step": [*steps, {key: _toml_value(value) for key, value in written.items()}]}
    return result if tomllib.loads(result) == expected else None


def _as_first_step(text: str) -> str:
    """Turn a recording at the top level into the first of a list: a header before its first key; comments stay."""
    lines = text.splitlines(keepends=True)
    first = min(toml_line_numbers(text).values()) - 1
    return "".join([*lines[:first], "[[step]]\n", *lines[first:]])


def _without_defaults(defaults: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any] | None:
    """The values of `table` that must be written given `defaults`; None if a default cannot be overridden."""
    written = {key: value for key, value in table.items() if key not in defaults or defaults[key] != value}
    for key in defaults.keys() - table.keys():
        if key not in Recording.model_fields:
            return None
        default = Recording.model_fields[key].get_default()
        if defaults[key] == default:
            continue
        if default is None or Recording.model_fields[key].is_required():
            return None
        written[key] = default
    return written


def _is_table(value: object) -> bool:
    return isinstance(value, dict)


def _toml_value(value: Any) -> Any:
    """Convert whole floats to integers, and tuples to lists."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return list(value) if isinstance(value, tuple) else value
