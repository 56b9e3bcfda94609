"""`[picture]`: which passes draw the picture, in which order, and where its parameters begin."""

from typing import Annotated

from pydantic import Field, field_validator

from live.base.errors import PersonError
from live.base.picture import BY_ADDRESS
from live.base.stage_view import PASSES
from live.show.parameter_table import numbers_of
from live.show.sections.section import Name, Section

Number = float | tuple[float, float, float]


class PictureSection(Section):
    """`[picture]`: the passes of the picture."""

    passes: Annotated[tuple[Name, ...], Field(max_length=32)] = PASSES
    """Passes in the order in which they are done; one that is left out is never drawn. What each does is set by
    `/dance/pass/...`, so one that is named here need not be seen."""
    set: Annotated[dict[str, Number], Field(max_length=200)] = Field(default={})
    """Where parameters of the picture begin, by the control's address, as in `"/dance/pass/ink" = 1`."""

    @field_validator("passes")
    @classmethod
    def _known(cls, passes: tuple[str, ...]) -> tuple[str, ...]:
        for name in passes:
            if name not in PASSES:
                raise ValueError(f"there is no pass {name!r}: there are {', '.join(PASSES)}")
            if passes.count(name) > 1:
                raise ValueError(f"the pass {name!r} stands there twice: leave one out")
        return passes

    @field_validator("set")
    @classmethod
    def _can_be_set(cls, said: dict[str, Number]) -> dict[str, Number]:
        for address, value in said.items():
            if address not in BY_ADDRESS:
                raise ValueError(f"{address!r} is no parameter of the picture; docs/osc.md lists them")
            try:
                numbers_of(address, value)
            except PersonError as error:
                raise ValueError(str(error)) from None
        return said

    def start(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Addresses and the numbers with which they begin."""
        return tuple((address, numbers_of(address, value)) for address, value in self.set.items())
