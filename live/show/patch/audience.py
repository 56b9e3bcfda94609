"""The audience of a patch."""

from typing import Annotated

from pydantic import Field

from live.show.patch.section_base import Name, Section


class AudienceSection(Section):
    """`[audience]`: what phones may do in this show; `live play --audience` lets them in."""

    regions: Annotated[tuple[Name, ...], Field(max_length=8)] = ()
    """Rows or groups of seats, among which people choose their own: `["stalls", "balcony"]`; none if left out."""
    vote_measures: Annotated[int, Field(ge=1, le=64)] = 4
    """How many whole measures a vote lasts."""
    gain: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = 1.0
    """How strongly dancers hear the audience at first."""
    open: bool = True
    """Whether phones may play from the beginning."""
    shake: bool = True
    """Whether dancers spread when many phones are shaken."""
    visible: Annotated[int, Field(ge=0, le=24)] = 24
    """How many voices are seen as lights on the floor at a time."""
    phones: Annotated[int, Field(ge=1, le=8000)] = 4000
    """How many phones may play at a time."""
    phones_per_address: Annotated[int, Field(ge=1, le=8000)] = 4
    """How many of one network address may play at a time, where each has its own; together they have one voice. Behind
    one address for all (the venue's `network`) there is no such limit, nor where this is as high as `phones`."""
