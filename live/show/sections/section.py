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


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)
