"""Base class of all tables of a patch, value types that several of them share, and the door for a reader's checks."""

import difflib
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, WithJsonSchema, create_model

from live.base.motion_parameters import MOTION_PARAMETERS
from live.base.parameter import Parameter
from live.base.picture_parameters import PARAMETERS

WorldCoordinate = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Place = tuple[
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


def colour_value(value: Any) -> Any:
    """Return a colour as linear RGB if it is a text, a word ("red") or sRGB as "#f80" or "#ff8800"; else as it is.

    ValueError for a text that is no colour.
    """
    if not isinstance(value, str):
        return value
    from PIL import ImageColor  # few patches need it

    try:
        levels = [level / 255.0 for level in ImageColor.getrgb(value)[:3]]
    except ValueError:
        near = difflib.get_close_matches(value.casefold(), ImageColor.colormap, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise ValueError(
            f"{hint}a colour expected: a word of the web such as 'gold', '#f80', or [1.0, 0.25, 0.0], "
            f"found {value[:40]!r}"
        ) from None
    return [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 4) for c in levels]


def colour_type(part: Any, low: float = 0, high: float = 1) -> Any:
    """Return the type of a colour whose parts are numbers of the type `part`, from `low` to `high`."""
    number = {"type": "number", "minimum": low, "maximum": high}
    numbers = {"type": "array", "prefixItems": [number] * 3, "minItems": 3, "maxItems": 3}
    schema = {"anyOf": [numbers, {"type": "string"}]}
    return Annotated[tuple[part, part, part], BeforeValidator(colour_value), WithJsonSchema(schema)]


if TYPE_CHECKING:
    Colour = tuple[float, float, float]
else:
    Colour = colour_type(Share)
Name = Annotated[str, Field(min_length=1, max_length=64)]
Size = tuple[
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
]
Measures = Annotated[float, Field(ge=0, le=1024, allow_inf_nan=False)]
Setting = float | bool | str | tuple[float, float, float] | tuple[str, ...]
"""A value of a parameter: a number, a switch, a name, a colour or place, or names."""
Draw = Annotated[dict[str, Setting], Field(max_length=400)]
"""Values by the control's address without `/dance/draw/`, with `_` or `/` between words: `ink_width`."""


class InvalidEntry(ValueError):
    """An error below the table that is being validated, with the keys that lead to its line."""

    def __init__(self, message: str, *place: str | int) -> None:
        """`place` is relative to the validated table: ("element", 2, "measure") is the third element's measure."""
        super().__init__(message)
        self.key_path = place
        self.others: tuple[InvalidEntry, ...] = ()
        """Further errors that were found with it."""


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused.

    A docstring below a field is its description in schemas and references: `live.show.patch.patch_schema` reads them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")


def parameter_rows(table: str) -> dict[str, Parameter]:
    """Return the rows of the parameters that are keys of this table of a patch, by key."""
    rows = (*MOTION_PARAMETERS, *PARAMETERS)
    return {row.patch.partition(".")[2]: row for row in rows if row.patch.startswith(f"{table}.")}


def parameter_section(table: str, *, optional: bool = False) -> Any:
    """Return a base class with the keys of the parameters that belong to this table, made from their rows.

    Keys have the start values of their rows or, if they are `optional`, none.
    """
    keys: dict[str, Any] = {}
    for key, row in parameter_rows(table).items():
        text = row.patch_text or (f"{row.description[:-1]} [{row.unit}]." if row.unit else row.description)
        default = None if optional else _key_default(row)
        keys[key] = (_key_type(row) | None if optional else _key_type(row), Field(default=default, description=text))
    return create_model(f"{table.capitalize()}Parameters", __base__=Section, **keys)


def _key_type(row: Parameter) -> Any:
    if row.choices:
        return Literal[tuple(row.choices)]
    if row.kind == "switch":
        return bool
    number = Annotated[float, Field(ge=row.low, le=row.high, allow_inf_nan=False)]
    if row.kind == "colour":
        return colour_type(number, row.low, row.high)
    return number if row.size == 1 else tuple[(number,) * row.size]  # type: ignore[misc]


def _key_default(row: Parameter) -> Any:
    """Return the start value of a parameter as its key has it: a word, a switch, a number or several."""
    if row.size > 1:
        return row.start
    (number,) = row.start
    if row.choices:
        return next(word for word, value in row.choices.items() if value == number)
    return bool(number) if row.kind == "switch" else number


def parameter_number(row: Parameter, value: float | bool | str) -> float:
    """Return the number of a parameter for the value of its key in the patch."""
    return row.choices[str(value)] if row.choices else float(value)


def parameter_values(table: str, section: Section) -> dict[str, Any]:
    """Return the values of a section's parameters by address; those that it leaves out are missing."""
    said = ((row, getattr(section, key)) for key, row in parameter_rows(table).items())
    return {
        row.address: parameter_number(row, value) if row.choices else value for row, value in said if value is not None
    }


Checks = Mapping[str, Callable[[Any], object]]
"""Checks of tables by name, as "cue"; each raises ValueError. They are the context of a validation."""


def run_check(info: ValidationInfo, table: str, entry: object) -> None:
    """Run the reader's check of `entry`, a table called `table`.

    Tables know no controls and no other tables: who reads a patch brings `live.show.patch_checks`. A patch that the
    program makes itself needs no check.
    """
    checks: Checks = info.context or {}
    if table in checks:
        checks[table](entry)


Tables = TypeVar("Tables", bound=Section)


class WholeFile(Section):
    """All tables of a file, among them those that only a bridge reads: they are kept as plain values.

    The reader refuses unknown keys; see `validate_sources`.
    """

    model_config = ConfigDict(extra="allow")

    @property
    def bridge_tables(self) -> dict[str, Any]:
        """The tables that only a bridge reads, by name."""
        return self.model_extra or {}

    def read_tables(self, model: type[Tables]) -> Tables:
        """Return a bridge's own tables as its model."""
        own = {name: value for name, value in self.bridge_tables.items() if name in model.model_fields}
        return model.model_validate(own)

    def unread_tables(self, models: Iterable[type[Section]]) -> list[str]:
        """Return the names of tables that none of the bridges' models reads."""
        known = {name for model in models for name in model.model_fields}
        return [name for name in self.bridge_tables if name not in known]
