"""Music, sound and clock of a patch."""

from typing import Annotated

from pydantic import Field

from live.show.sections.section import Section


class MusicSection(Section):
    """`[music]`: what is played when no `--audio` is given."""

    file: str | None = None
    """An audio file, looked up in the patch's folder, then in the project's patches."""
    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """Its tempo if it is known: the clock starts with it."""
    one_at_s: Annotated[float, Field(ge=0, le=3600, allow_inf_nan=False)] | None = None
    """Where its first downbeat is, if that is known."""


class SoundSection(Section):
    """`[sound]`: what a film of `live render` is heard with beside the music (T130)."""

    click: bool = False
    """A click on every beat, another one on the first of each measure."""
    taps: bool = False
    """The sound of tap shoes wherever a foot comes down."""


class ClockSection(Section):
    """`[clock]`: musical time while nothing is heard."""

    bpm: Annotated[float, Field(ge=20, le=400)] = 112.0
    """Tempo of the internal clock."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    """Beats of a measure; all steps must have it."""
