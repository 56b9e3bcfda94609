"""Patch sections for what a seen performer brings about: answers to recognised steps."""

from typing import Annotated, Literal

from pydantic import Field

from live.show.patch.section_base import Name, Section

Words = Annotated[str, Field(min_length=1, max_length=250)]
AnswerHow = Literal["same", "next", "other", "map"]


class AnswerSection(Section):
    """`[[answer]]`: call and response with a captured performer: each step that is recognised is answered by dancers;
    see `live docs learn-this`."""

    name: Name
    """Name of the answer, as in `/dance/answer/on`."""
    performer: Name
    """The captured performer, by its name in `[[mocap]]`; `live` if there is none."""
    group: Words = "*"
    """Dancers who answer, such as `mist` or `mist & 13-16`; `*` is all."""
    how: AnswerHow = "same"
    """`same`: the same step in the next measure, recognised before the measure is over; `next`: the same step a measure
    later, as a canon, recognised in the whole measure; `other`: another step of the group; `map`: the step in `map`."""
    map: dict[Name, Name] = Field(default={}, max_length=200)
    """For `how = "map"` the answers by recognised step: `map = { groove = "kick" }`; others are not answered."""
    sure: Annotated[float, Field(ge=0, le=1)] = 0.3
    """Least confidence with which a step is answered."""
    on: bool = True
    """Whether steps are answered from the beginning."""
