"""Patch section of the lamps: which value each DMX channel has."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from live.bridges.lamps.dmx_mapping import SENDS, Channel, channel_count
from live.show.patch.section_base import Section


class DmxSection(Section):
    """`[[dmx]]`: the source of one DMX channel of the hall's lamps, or of several in a row."""

    channel: Annotated[int, Field(ge=1, le=512)]
    """Its first channel, from 1."""
    sends: Annotated[str, Field(min_length=1, max_length=200)]
    """beat, measure, steps, feet (flashes), tempo [bpm], dancer (x, then z, each coarse and fine), or the address of a
    value, such as /dance/light/key/colour: a channel for each of its numbers, over its whole range."""
    dancer: Annotated[int, Field(ge=1, le=10_000)] = 1
    """For `dancer`: the dancer's number, from 1."""
    beats: Annotated[float, Field(gt=0, le=64)] = 1.0
    """Length of a flash in beats."""
    fine: bool = False
    """Whether each number takes two channels, coarse and fine."""

    @model_validator(mode="after")
    def _known(self) -> Self:
        width = channel_count(self.sends) * (2 if self.fine and self.sends != "dancer" else 1)
        if not width:
            raise ValueError(f"nothing is called {self.sends!r}: {', '.join(SENDS)}, or the address of a number")
        if self.channel + width > 513:
            raise ValueError(f"it takes {width} channels from {self.channel} on, and there are 512")
        return self

    @property
    def dmx_channel(self) -> Channel:
        """The channel in the form of the DMX process."""
        return Channel(self.channel, self.sends, self.dancer, self.beats, self.fine)


class DmxTables(Section):
    """The tables of a patch that the lamps read."""

    dmx: Annotated[tuple[DmxSection, ...], Field(max_length=512)] = ()
    """What each channel follows, instead of the default channels."""
