"""Events of the clock: manual control and observations of clock sources."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class Tap(ControlEvent):
    """A beat was tapped at `time`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class One(ControlEvent):
    """ "This is the one": the beat at `time` is the first of a measure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetTempo(ControlEvent):
    """The tempo is set by hand [bpm]; the beat position continues without a jump."""

    tempo: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Nudge(ControlEvent):
    """The beats move by `seconds` relative to the active source; later if positive."""

    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ShiftBeats(ControlEvent):
    """The measure lines move by `beats`, later if positive; half a beat moves the beat to the off-beat."""

    beats: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleTempo(ControlEvent):
    """Half (0.5) or double (2) tempo, from the next beat common to both."""

    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldTempo(ControlEvent):
    """The tempo is frozen, so that no source corrects tempo or phase, or released."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetMetre(ControlEvent):
    """Sets the beats per measure, 2 to 12, from the next measure line on."""

    beats: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CountIn(ControlEvent):
    """Counts `measures` before the one, from the next beat, or after a measure of taps."""

    measures: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseSource(ControlEvent):
    """Selects the clock source by name; "auto": by priority."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BeatHeard(ControlEvent):
    """A source's beat observation: a beat at `beat_time` [s of the show], `period` [s], confidence 0 to 1.

    The source is the event's `source`: "audio", "midi", "link", "mtc" …
    """

    beat_time: float
    """May be in the future (a prediction)."""
    period: float
    confidence: float
    beat: int = -1
    """Beat of the measure, from 0; -1 if unknown."""
    beats_per_measure: int = 0
    """0 if unknown."""
    measure: int = -1
    """The source's measure number, from 0 (song position, Link); -1 if it has none."""
    jump: bool = False
    """Whether the source reports a jump (start, song position), so that its grid applies at once."""
    anchored: bool = True
    """False if the source has a tempo but no beat phase, such as MIDI clock that was never started."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceChanged(ControlEvent):
    """A clock source appeared ("found"), paused longer than usual ("paused"), fell "silent", or is "lost".

    MIDI and Link also report "started" and "stopped".
    """

    state: str
    detail: str = ""
