"""Conversion of plain values to dataclasses, checked by their annotations, and patterns of texts."""

import contextlib
import types
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

Kind = TypeVar("Kind")

HOST_NAME_PATTERN: Final = r"^[A-Za-z0-9]([A-Za-z0-9.-]{0,190}[A-Za-z0-9])?(:[0-9]{1,5})?$"
"""Regular expression for NAME or NAME:PORT, as in `show.example` or `show.example:443`."""


def build_dataclass(cls: type[Kind], values: dict[str, Any]) -> Kind:
    """Return the dataclass `cls` with these fields; ValueError names a field that is unknown, missing or of a wrong
    type.

    Where the annotation says so, sequences become tuples, texts become paths, and dictionaries become dataclasses.
    """
    hints = _hints(cls)  # type: ignore[arg-type]
    unknown = sorted(map(str, set(values) - set(hints)))
    if unknown:
        raise ValueError(f"{cls.__name__}: there is no field {unknown[0]:.80}")
    found = {name: convert_value(hints[name], value, f"{cls.__name__}.{name}") for name, value in values.items()}
    try:
        return cls(**found)
    except TypeError as error:
        raise ValueError(f"{cls.__name__}: {error}") from None


@cache
def _hints(cls: type) -> dict[str, Any]:
    hints = get_type_hints(cls)
    return {each.name: hints[each.name] for each in fields(cls)}


def convert_value(hint: Any, value: Any, where: str) -> Any:
    """Return the value converted to the annotation `hint`; ValueError otherwise."""
    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        for each in get_args(hint):
            with contextlib.suppress(ValueError):
                return convert_value(each, value, where)
    elif origin is Literal:
        if any(type(value) is type(each) and value == each for each in get_args(hint)):
            return value
    elif origin is tuple:
        if isinstance(value, list | tuple):
            return _tuple(get_args(hint), value, where)
    elif isinstance(hint, type) and is_dataclass(hint):
        if isinstance(value, dict):
            return build_dataclass(hint, value)
    elif hint in _PLAIN and type(value) in _PLAIN[hint]:
        return hint(value) if hint in (float, Path) else value
    raise ValueError(f"{where} cannot be {value!r:.80}")


_PLAIN: Final = {
    bool: (bool,), int: (int,), float: (int, float), str: (str,), bytes: (bytes,), Path: (str,),
    type(None): (type(None),),
}  # fmt: skip
"""Accepted classes of values by annotation."""


def _tuple(inside: tuple[Any, ...], value: Sequence[Any], where: str) -> tuple[Any, ...]:
    if len(inside) == 2 and inside[1] is Ellipsis:
        return tuple([convert_value(inside[0], each, where) for each in value])
    if len(value) != len(inside):
        raise ValueError(f"{where} cannot be {value!r:.80}: {len(inside)} values expected")
    return tuple([convert_value(each, part, where) for each, part in zip(inside, value, strict=True)])
