"""Base class of all tables of a patch, value types that several of them share, and the door for a reader's checks."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo

WorldCoordinate = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Place = tuple[
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Colour = tuple[Share, Share, Share]
Name = Annotated[str, Field(min_length=1, max_length=64)]
Size = tuple[
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
]
Measures = Annotated[float, Field(ge=0, le=1024, allow_inf_nan=False)]
Setting = float | bool | str | tuple[float, float, float]
Draw = Annotated[dict[str, Setting], Field(max_length=400)]
"""Values by the control's address without `/dance/draw/`, with `_` or `/` between words: `ink_width`."""


class InvalidEntry(ValueError):
    """An error below the table that is being validated, with the keys that lead to its line."""

    def __init__(self, message: str, *place: str | int) -> None:
        """`place` is relative to the validated table: ("element", 2, "measure") is the third element's measure."""
        super().__init__(message)
        self.key_path = place


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


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
