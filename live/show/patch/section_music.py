"""Music, sound and clock of a patch.

`[[react]]`: what the music that is heard changes in the dance, beat by beat or when something happens in it.
"""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.base.picture_parameters import BY_ADDRESS
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
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


Value = Annotated[float, Field(ge=-10, le=10, allow_inf_nan=False)]


Picture = Annotated[str, Field(min_length=1, max_length=64, pattern="^/dance/")]


class ReactSection(Section):
    """`[[react]]`: either `to` what is heard something is `sets`, or `on` an event something is `call`ed."""

    to: (
        Literal["loudness", "density", "brightness", "low", "build", "note_energy", "note_density", "chord", "pitch"]
        | None
    ) = None
    """What is followed, 0 to 1 in the range heard so far: loudness, onsets, brightness, bass, how far it builds up; of
    notes over MIDI how hard they are struck, how densely, how many sound, and where on the keys."""
    sets: (
        Literal["larger", "amplitude", "mix", "arms", "texture", "head", "warp_beats", "strength"] | Picture | None
    ) = None
    """What follows it: a parameter of `[motion]`, the strength of elements that begin from then on, or a number of the
    picture by its address, as in `/dance/light/rim`."""
    low: Value = 0.0
    """Its value when that is 0."""
    high: Value = 1.0
    """Its value when that is 1; it may be the smaller one."""
    beats: Annotated[float, Field(ge=0, le=64)] = 4.0
    """Beats over which it is smoothed."""
    group: Annotated[str, Field(min_length=1, max_length=64)] = "*"
    """The group whose motion it is; * is all."""
    on: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """What happens: `drop`, the bass comes back after a build-up or a break; `build`, a build-up begins; or a signal,
    as a `[[signal]]` names it; or `unit:turn`, a partner dances a unit of that step or recording (`unit:turn/2`: the
    second one)."""
    when: Literal["measure", "beat", "now"] = "measure"
    """When it is called: at the next measure line, at the next beat, or at once."""
    call: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    """The control that is called, by its address, as in `/dance/step`."""
    values: Annotated[tuple[str | float | bool, ...], Field(max_length=16)] = ()
    """Its values, as by OSC."""

    @model_validator(mode="after")
    def _one_or_the_other(self) -> "ReactSection":
        if (self.to is None) != (self.sets is None) or (self.on is None) != (self.call is None):
            raise ValueError("`to` goes with `sets`, and `on` with `call`")
        if (self.to is None) == (self.on is None):
            raise ValueError("either `to` and `sets`, or `on` and `call` expected")
        if self.sets is not None and self.sets.startswith("/"):
            self._can_follow(self.sets)
        if self.call is not None and not isinstance(self.event(0.0), ControlEvent):
            raise ValueError(f"call {self.call!r} with {list(self.values)!r}: {self.event(0.0)}; see docs/osc.md")
        return self

    def _can_follow(self, address: str) -> None:
        known = BY_ADDRESS.get(address)
        if known is None or known.kind != "number":
            numbers = ", ".join(one.address for one in BY_ADDRESS.values() if one.kind == "number")
            raise ValueError(f"sets {address!r}: no number of the picture is called so; there are: {numbers}")
        if self.group != "*":
            raise ValueError(f"sets {address!r}: light and camera belong to no group")
        for value in (self.low, self.high):
            if not known.low <= value <= known.high:
                raise ValueError(f"sets {address!r} to {value:g}: {known.low:g} to {known.high:g} expected")

    def event(self, time: float) -> object:
        """What the call makes: a ControlEvent, for one that was checked."""
        return REGISTRY.call(self.call or "", self.values, time, "music")
