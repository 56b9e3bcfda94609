"""Music, sound and clock of a patch."""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.show.patch.section_base import Section


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


SourceName = Literal["link", "midi", "mtc", "audio", "tap", "internal"]
PRIORITY: Final[tuple[SourceName, ...]] = ("link", "midi", "mtc", "audio", "tap", "internal")
Bpm = Annotated[float, Field(ge=20, le=400)]


class ClockSection(Section):
    """`[clock]`: musical time: what it is while nothing is heard, and who is followed."""

    bpm: Bpm = 112.0
    """Tempo of the internal clock."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    """Beats of a measure; all steps must have it."""
    priority: Annotated[tuple[SourceName, ...], Field(max_length=6)] = (
        "link",
        "midi",
        "mtc",
        "audio",
        "tap",
        "internal",
    )
    """Who is followed first; a source that is left out is never followed unless it is chosen by hand."""
    tempo_range: tuple[Bpm, Bpm] = (40.0, 240.0)
    """Music outside this range [bpm] is danced at half or double tempo."""
    tracker: Literal["network", "aubio"] = "network"
    """Who listens to sound: the network that also knows the measure, or aubio's tempo."""
    follow_metre: bool = False
    """Whether music may change how many beats a measure has; if not, only a hand does."""

    @model_validator(mode="after")
    def _range_is_an_octave(self) -> "ClockSection":
        lowest, highest = self.tempo_range
        if highest < 2.0 * lowest:
            raise ValueError(f"tempo_range [{lowest:g}, {highest:g}]: the second must be at least twice the first")
        return self

    @model_validator(mode="after")
    def _nobody_twice(self) -> "ClockSection":
        if len(set(self.priority)) < len(self.priority):
            raise ValueError("priority: a source stands there twice")
        return self
