"""Base class of all tables of a patch, and value types that several of them share."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

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


class InvalidEntry(ValueError):
    """An error below the table that is being validated, with the keys that lead to its line."""

    def __init__(self, message: str, *place: str | int) -> None:
        """`place` is relative to the validated table: ("element", 2, "measure") is the third element's measure."""
        super().__init__(message)
        self.key_path = place


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)
