"""Base class of all tables of a patch, and value types that several of them share."""

from collections.abc import Iterable
from typing import Annotated, Any, TypeVar

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
