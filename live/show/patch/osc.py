"""OSC of a patch."""

from typing import Annotated

from pydantic import Field

from live.show.patch.section_base import Section

Target = Annotated[str, Field(pattern=r"^(\[[0-9A-Fa-f:.]+\]|[^:\s]+):\d{1,5}$", max_length=200)]
Endpoint = Annotated[str, Field(pattern=r"^((\[[0-9A-Fa-f:.]+\]|[^:\s]+):)?\d{1,5}$", max_length=200)]
Endpoints = Annotated[tuple[Endpoint, ...], Field(max_length=8)]
Targets = Annotated[tuple[Target, ...], Field(max_length=8)]


class OscSection(Section):
    """`[osc]`: whom the show tells over OSC what happens in it: beat, measure, tempo, steps, feet, places."""

    out: Targets = ()
    """Addresses like `127.0.0.1:57120`; `--osc-out` or the venue name others instead."""
    positions_per_second: Annotated[float, Field(ge=0, le=60, allow_inf_nan=False)] = 10.0
    """How often the dancers' places are told; 0 for never."""
    feet: bool = True
    """Whether each foot is told that comes down, to make sounds of."""
