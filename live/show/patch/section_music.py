"""Patch sections for music: `[music]`, `[sound]`, `[clock]`, and reactions of the dance to it: `[[react]]`."""

from typing import Annotated, Final, Literal

from pydantic import Field, ValidationInfo, model_validator

from live.base.motion_parameters import MOTION_KEYS
from live.clock.follower.clock_source import PRIORITY, SourceName
from live.show.patch.section_base import Section, run_check


class MusicSection(Section):
    """`[music]`: the music that is played without `--audio`."""

    file: str | None = None
    """An audio file, looked up in the patch's folder, then in the project's patches."""
    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """Its tempo if it is known: the clock starts with it."""
    one_at_s: Annotated[float, Field(ge=0, le=3600, allow_inf_nan=False)] | None = None
    """Time of its first downbeat, if known."""


class SoundSection(Section):
    """`[sound]`: sounds added to the music of a film of `live render` (T130)."""

    click: bool = False
    """A click on every beat, another one on the first of each measure."""
    taps: bool = False
    """The sound of a tap shoe for each foot that lands."""


Bpm = Annotated[float, Field(ge=20, le=400)]


class ClockSection(Section):
    """`[clock]`: musical time: the internal clock, and the priority of external sources."""

    bpm: Bpm = 112.0
    """Tempo of the internal clock."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    """Beats of a measure; the same for all steps."""
    priority: Annotated[tuple[SourceName, ...], Field(max_length=len(PRIORITY))] = PRIORITY
    """Sources in order of priority; a source left out is followed only if it is selected by hand."""
    tempo_range: tuple[Bpm, Bpm] = (40.0, 240.0)
    """Music outside this range [bpm] is danced at half or double tempo."""
    tracker: Literal["network", "aubio"] = "network"
    """Beat tracker for sound: the neural network, which also finds the measure, or aubio's tempo tracker."""
    follow_metre: bool = False
    """Whether the music may change the number of beats of a measure; otherwise only manual control does."""

    @model_validator(mode="after")
    def _range_is_an_octave(self) -> "ClockSection":
        lowest, highest = self.tempo_range
        if highest < 2.0 * lowest:
            raise ValueError(f"tempo_range [{lowest:g}, {highest:g}]: the second must be at least twice the first")
        return self

    @model_validator(mode="after")
    def _sources_differ(self) -> "ClockSection":
        if len(set(self.priority)) < len(self.priority):
            raise ValueError("priority: a source is given twice")
        return self


Value = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]


ReactTarget = Literal[(*MOTION_KEYS, "strength")]  # type: ignore[valid-type]
UNIT_PREFIX: Final = "unit:"
"""Prefix in `[[react]] on` for the names of partner units."""
Feature = Literal["loudness", "density", "brightness", "low", "build", "note_energy", "note_density", "chord", "pitch"]
PictureAddress = Annotated[str, Field(min_length=1, max_length=64, pattern="^/dance/")]


class ReactSection(Section):
    """`[[react]]`: a value that follows a feature of the music (`to`, `sets`), or a control that is called on an event
    (`on`, `call`)."""

    to: Feature | None = None
    """The feature, 0 to 1 in the range heard so far: loudness, onset density, brightness, bass, progress of a build-up;
    of MIDI notes their velocity, density, number sounding, and pitch."""
    sets: ReactTarget | PictureAddress | None = None
    """What it sets: a parameter of `[motion]`, the strength of elements that begin from then on, or a number of the
    picture by its address, as in `/dance/light/rim`."""
    low: Value = 0.0
    """The value for a feature of 0."""
    high: Value = 1.0
    """The value for a feature of 1; it may be less than `low`."""
    beats: Annotated[float, Field(ge=0, le=64)] = 4.0
    """Beats over which it is smoothed."""
    group: Annotated[str, Field(min_length=1, max_length=64)] = "*"
    """The group whose motion is changed; * is all."""
    on: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """The event: `drop`, the bass returns after a build-up or a break; `build`, a build-up begins; a signal, by the
    name of its `[[signal]]`; or `unit:turn`, a partner dances a unit of that step or recording (`unit:turn/2`: the
    second one)."""
    when: Literal["measure", "beat", "now"] = "measure"
    """When the control is called: at the next measure line, at the next beat, or at once."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address, as in `/dance/step`."""
    values: Annotated[tuple[str | float | bool, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""

    @model_validator(mode="after")
    def _one_or_the_other(self, info: ValidationInfo) -> "ReactSection":
        if (self.to is None) != (self.sets is None) or (self.on is None) != (self.call is None):
            raise ValueError("`to` goes with `sets`, and `on` with `call`")
        if (self.to is None) == (self.on is None):
            raise ValueError("either `to` and `sets`, or `on` and `call` expected")
        run_check(info, "react", self)
        return self
