"""Section: the base of all tables of a patch, and the kinds of values that several of them have."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Far = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
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


class Amiss(ValueError):
    """What is wrong below the table that is being checked, with the keys that lead there, so that its line is named."""

    def __init__(self, message: str, *place: str | int) -> None:
        """`place` as in ("element", 2, "measure"): the third element's measure, from the checked table on."""
        super().__init__(message)
        self.place = place


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)
