"""A formation as a table of TOML or JSON, and back (T087: stored once, referenced by name)."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Final

from live.agents.formations.spec import FormationSpec
from live.base.errors import PersonError

_FIELDS: Final = {field.name: field.default for field in dataclasses.fields(FormationSpec)}


def spec_from_table(table: Mapping[str, Any], where: str = "formation") -> FormationSpec:
    """The spec that a table says; keys are the fields of FormationSpec. PersonError, naming the key, if it is none.

    `where` names the table in the message. `path` may be one text, `points` one line or several.
    """
    if not isinstance(table, Mapping):
        raise PersonError(f"{where}: a table expected, not {type(table).__name__}")
    unknown = [str(key) for key in table if key not in _FIELDS]
    if unknown:
        raise PersonError(f"{where}: {unknown[0][:60]!r} is no key of a formation; there are: {', '.join(_FIELDS)}")
    values = {key: _plain(value) for key, value in table.items()}
    if isinstance(values.get("path"), str):
        values["path"] = (values["path"],)
    points = values.get("points")
    if isinstance(points, tuple) and points and _is_point(points[0]):
        values["points"] = (points,)
    try:
        return FormationSpec(**values)
    except TypeError:  # nested otherwise than any value of that field can be
        raise PersonError(f"{where}: a value is nested otherwise than expected", "compare docs/formations.md") from None


def spec_to_table(spec: FormationSpec) -> dict[str, Any]:
    """What differs from the defaults, as a table that TOML and JSON can hold; `spec_from_table` gives the same spec."""
    table = {name: getattr(spec, name) for name, default in _FIELDS.items() if getattr(spec, name) != default}
    return {"shape": spec.shape, **{name: _lists(value) for name, value in table.items()}}


def _plain(value: Any) -> Any:
    """Lists as tuples, all the way down."""
    return tuple(_plain(each) for each in value) if isinstance(value, list | tuple) else value


def _lists(value: Any) -> Any:
    return [_lists(each) for each in value] if isinstance(value, tuple) else value


def _is_point(value: object) -> bool:
    return isinstance(value, tuple) and len(value) > 0 and not isinstance(value[0], tuple)
