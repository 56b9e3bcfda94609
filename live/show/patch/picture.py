"""`[picture]`: which passes draw the picture, in which order, and where its parameters begin."""

from functools import cached_property
from typing import Annotated

from pydantic import Field, model_validator

from live.base.custom_pass import MOST_CHARACTERS, MOST_PASSES, OwnPass, own_numbers, read_own_pass
from live.base.errors import PersonError
from live.base.picture import BY_ADDRESS
from live.base.stage_snapshot import PASSES
from live.show.desk.parameter_table import numbers_of
from live.show.patch.section_base import Amiss, Name, Section

Number = float | tuple[float, float, float]


class OwnPassSection(Section):
    """`[[picture.own]]`: a pass of the patch's own, as it stands in its folder: nobody need write this."""

    name: Annotated[str, Field(max_length=32)]
    """What it is called: the name of its file."""
    source: Annotated[str, Field(max_length=MOST_CHARACTERS)]
    """Its text in GLSL."""


class PictureSection(Section):
    """`[picture]`: the passes of the picture."""

    passes: Annotated[tuple[Name, ...], Field(max_length=32)] = PASSES
    """Passes in the order in which they are done; one that is left out is never drawn. What each does is set by
    `/dance/pass/...`, so one that is named here need not be seen. A name that is none of the engine's is that of a file
    `passes/NAME.glsl` beside the patch."""
    set: Annotated[dict[str, Number], Field(max_length=200)] = Field(default={})
    """Where parameters of the picture begin, by the control's address, as in `"/dance/pass/ink" = 1`."""
    own: Annotated[tuple[OwnPassSection, ...], Field(max_length=MOST_PASSES)] = ()
    """The texts of the patch's own passes, taken from their files, so that a journal holds them."""

    @cached_property
    def own_passes(self) -> tuple[OwnPass, ...]:
        """The patch's own passes; PersonError if one is none."""
        return tuple(read_own_pass(one.name, one.source) for one in self.own)

    @model_validator(mode="after")
    def _passes_are_there(self) -> "PictureSection":
        own = [one.name for one in self.own]
        try:
            assert self.own_passes is not None
        except PersonError as error:
            raise Amiss(str(error), "passes") from None
        for name in self.passes:
            if name not in PASSES and name not in own:
                known = f"there are {', '.join(PASSES)}, and files passes/NAME.glsl beside the patch"
                raise Amiss(f"there is no pass {name!r}: {known}", "passes")
            if self.passes.count(name) > 1 or (name in PASSES and name in own):
                raise Amiss(f"the pass {name!r} is there twice: leave one out", "passes")
        return self

    @model_validator(mode="after")
    def _can_be_set(self) -> "PictureSection":
        own = own_numbers(self.own_passes)
        for address, value in self.set.items():
            if address in own:
                known = own[address]
                if not isinstance(value, float) or not known.low <= value <= known.high:
                    raise Amiss(f"{address!r} = {value!r}: {known.low:g} to {known.high:g} expected", "set", address)
                continue
            if address not in BY_ADDRESS:
                raise Amiss(f"{address!r} is no parameter of the picture; docs/osc.md lists them", "set", address)
            try:
                numbers_of(address, value)
            except PersonError as error:
                raise Amiss(str(error), "set", address) from None
        return self

    def start(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Addresses and the numbers with which they begin."""
        return tuple(
            (address, value if isinstance(value, tuple) else (float(value),)) for address, value in self.set.items()
        )
