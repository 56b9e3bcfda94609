"""Patch sections for music: `[music]`, `[sound]`, `[clock]`, and reactions of the dance to it: `[[react]]`."""

import itertools
from typing import Annotated, Final, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from live.base.motion_parameters import MOTION_KEYS
from live.clock.bar_pointer.metre import DEFAULT, Metre
from live.clock.follower.clock_source import PRIORITY, SourceName
from live.clock.measure_map import MIN_MEASURE_S, MeasureLine, MeasureMap, Phrase
from live.show.patch.section_base import InvalidEntry, Section, run_check


class MusicLine(Section):
    """`[[music.line]]`: a measure line of the music, as `live music map` proposes them (`live docs measures`, T007)."""

    time_s: Annotated[float, Field(ge=0, le=36000, allow_inf_nan=False)]
    """Its time in the music [s]; lines are written in their order."""
    measure: Annotated[int, Field(ge=1, le=100000)]
    """The measure that it begins, counted on by one from line to line."""
    beats: Annotated[int, Field(ge=1, le=16)] = 4
    """Beats of this measure."""
    tempo: Literal["step", "ramp"] = "step"
    """The tempo within the measure: constant, or running evenly from that of the measure before."""


class MusicPhrase(Section):
    """`[[music.phrase]]`: a phrase of the music, until the next one begins."""

    measure: Annotated[int, Field(ge=1, le=100000)]
    """The measure with which it begins."""
    name: Annotated[str, Field(max_length=64)] = ""
    """Its name."""


class MusicSection(Section):
    """`[music]`: the music that is played without `--audio`."""

    file: str | None = None
    """An audio file, looked up in the patch's folder, then in the project's patches."""
    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """Its tempo if it is known: the clock starts with it."""
    one_at_s: Annotated[float, Field(ge=0, le=3600, allow_inf_nan=False)] | None = None
    """Time of its first downbeat, if known; with `bpm` the simplest map of its measures."""
    line: Annotated[tuple[MusicLine, ...], Field(max_length=20000)] = ()
    """Its measure lines: the show follows them exactly, instead of the beats that it hears."""
    phrase: Annotated[tuple[MusicPhrase, ...], Field(max_length=2000)] = ()
    """Its phrases."""

    @model_validator(mode="after")
    def _lines_go_forward(self) -> "MusicSection":
        for index, (before, line) in enumerate(itertools.pairwise(self.line), start=1):
            if line.time_s < before.time_s + MIN_MEASURE_S:
                words = f"{line.time_s:g} s after a line at {before.time_s:g} s: lines go forward; sort them by time"
                raise InvalidEntry(words, "line", index, "time_s")
            if line.measure != before.measure + 1:
                words = f"measure {line.measure} after measure {before.measure}; they are counted on by one"
                raise InvalidEntry(words, "line", index, "measure")
        return self

    @property
    def first_downbeat(self) -> float | None:
        """Time of the first downbeat [s], given or that of the first line; None if neither is known."""
        return self.line[0].time_s if self.one_at_s is None and self.line else self.one_at_s

    @property
    def known_tempo(self) -> float | None:
        """The tempo [bpm], given or that of the first measure; None if neither is known."""
        measures = self.measures
        if self.bpm is not None or measures is None:
            return self.bpm
        return min(max(60.0 / (measures.time_at(1.0) - measures.time_at(0.0)), 20.0), 400.0)

    @property
    def tempo_span(self) -> tuple[float, float] | None:
        """Least and most tempo of the music [bpm], without the fastest and slowest twentieth of its measures; None if
        it is not known."""
        if len(self.line) < 3:
            return None if self.known_tempo is None else (self.known_tempo, self.known_tempo)
        tempi = [60.0 * one.beats / (after.time_s - one.time_s) for one, after in itertools.pairwise(self.line)]
        low, high = np.clip(np.percentile(tempi, (5.0, 95.0)), 20.0, 400.0)
        return float(low), float(high)

    @property
    def measures(self) -> MeasureMap | None:
        """The map of its measure lines; None if it has none."""
        if not self.line:
            return None
        lines = [MeasureLine(one.time_s, one.measure, one.beats, one.tempo) for one in self.line]
        return MeasureMap(lines, [Phrase(one.measure, one.name) for one in self.phrase])


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
    metres: Annotated[tuple[int | str, ...], Field(min_length=1, max_length=16)] = tuple(m.beats for m in DEFAULT)
    """Metres that the music may have: beats of a measure, 2 to 9, or its groups, such as "3+2"."""
    follow_metre: bool = False
    """Whether the music may change the number of beats of a measure; otherwise only manual control does."""
    likely_bpm: Annotated[float, Field(ge=40, le=240)] | None = None
    """The tempo that the beat of the music is likely to have; it decides between half and double."""

    @model_validator(mode="after")
    def _range_is_an_octave(self) -> "ClockSection":
        lowest, highest = self.tempo_range
        if highest < 2.0 * lowest:
            raise ValueError(f"tempo_range [{lowest:g}, {highest:g}]: the second must be at least twice the first")
        return self

    @field_validator("metres")
    @classmethod
    def _metres_are_known(cls, metres: tuple[int | str, ...]) -> tuple[int | str, ...]:
        for metre in metres:
            Metre.parse(metre)
        return metres

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
CURVE_PREFIX: Final = "curve:"
"""Prefix in `[[react]] to` for the names of curves."""
PERFORMER_PREFIX: Final = "mocap:"
"""Prefix in `[[react]] to` for the movement of captured performers: `mocap:anna/energy`, `mocap:energy`."""
PerformerFeature = Annotated[str, Field(min_length=10, max_length=80, pattern=f"^{PERFORMER_PREFIX}")]
CurveName = Annotated[str, Field(min_length=7, max_length=70, pattern=f"^{CURVE_PREFIX}")]
PictureAddress = Annotated[str, Field(min_length=1, max_length=64, pattern="^/dance/")]


class ReactSection(Section):
    """`[[react]]`: a value that follows a feature of the music (`to`, `sets`), or a control that is called on an event
    (`on`, `call`)."""

    to: Feature | CurveName | PerformerFeature | None = None
    """The feature, 0 to 1 in the range heard so far: loudness, onset density, brightness, bass, progress of a build-up;
    of MIDI notes their velocity, density, number sounding, and pitch.
    Or `mocap:NAME/energy`, `size`, `speed`, `hands` (their height) or `tempo` (60 to 180 bpm) of a captured performer;
    without `NAME/` the highest of all performers'. Or `curve:NAME`: a `[[curve]]` of the score, which is followed at
    once unless `beats` is given."""
    sets: ReactTarget | PictureAddress | None = None
    """What it sets: a parameter of `[motion]`, the strength of elements that begin from then on, or a number of the
    picture by its address, as in `/dance/light/rim`."""
    low: Value = 0.0
    """The value for a feature of 0."""
    high: Value = 1.0
    """The value for a feature of 1; it may be less than `low`."""
    beats: Annotated[float, Field(ge=0, le=64)] = 4.0
    """Beats over which it is smoothed."""
    group: Annotated[str, Field(min_length=1, max_length=400)] = "*"
    """The dancers whose motion is changed: a group, or groups, attributes, numbers and places; * is all."""
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

    @property
    def is_curve(self) -> bool:
        """Whether it follows a curve of the score."""
        return self.to is not None and self.to.startswith(CURVE_PREFIX)

    @model_validator(mode="after")
    def _one_or_the_other(self, info: ValidationInfo) -> "ReactSection":
        if (self.to is None) != (self.sets is None) or (self.on is None) != (self.call is None):
            raise ValueError("`to` goes with `sets`, and `on` with `call`")
        if (self.to is None) == (self.on is None):
            raise ValueError("either `to` and `sets`, or `on` and `call` expected")
        run_check(info, "react", self)
        return self
