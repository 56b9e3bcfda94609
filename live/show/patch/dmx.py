"""What the lamps of the hall are told, over sACN or Art-Net."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from live.control.dmx_mapping import SENDS, Channel, widths_of
from live.show.patch.section_base import Section


class DmxSection(Section):
    """`[[dmx]]`: what one channel of the hall's lamps follows, or several in a row."""

    channel: Annotated[int, Field(ge=1, le=512)]
    """The first of its channels, from 1."""
    sends: Annotated[str, Field(min_length=1, max_length=200)]
    """beat, measure, steps, feet (flashes), tempo [bpm], dancer (x, then z, each coarse and fine), or the address of a
    value, as /dance/light/key/colour: a channel for each of its numbers, over its whole range."""
    dancer: Annotated[int, Field(ge=1, le=4000)] = 1
    """For `dancer`: which one, from 1."""
    beats: Annotated[float, Field(gt=0, le=64)] = 1.0
    """After how many beats a flash is gone."""
    fine: bool = False
    """Whether each number takes two channels, coarse and fine."""

    @model_validator(mode="after")
    def _known(self) -> Self:
        width = widths_of(self.sends) * (2 if self.fine and self.sends != "dancer" else 1)
        if not width:
            raise ValueError(f"nothing is called {self.sends!r}: {', '.join(SENDS)}, or the address of a number")
        if self.channel + width > 513:
            raise ValueError(f"it takes {width} channels from {self.channel} on, and there are 512")
        return self

    @property
    def made(self) -> Channel:
        """As the lamps' process knows it."""
        return Channel(self.channel, self.sends, self.dancer, self.beats, self.fine)
