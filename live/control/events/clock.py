"""What the musician's hand says about the beat."""

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
    """The tempo is set by hand [bpm]; the beat position goes on without a step."""

    tempo: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Nudge(ControlEvent):
    """The beats of the source in force lie so much later [s] (earlier if negative) than it says."""

    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ShiftBeats(ControlEvent):
    """The measure lines move by so many beats, later if positive; a half moves the beat itself to the off-beat."""

    beats: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleTempo(ControlEvent):
    """Half (0.5) or double (2) tempo, from the next beat that both have."""

    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class HoldTempo(ControlEvent):
    """The tempo is frozen: nothing heard corrects tempo or phase until it is let go."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetMetre(ControlEvent):
    """Measures have so many beats, 2 to 12, from the next measure line on."""

    beats: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CountIn(ControlEvent):
    """So many measures are counted, then comes the one: from the next beat, or after a measure of taps."""

    measures: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseSource(ControlEvent):
    """Which source is followed, by name; "auto": by priority."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BeatHeard(ControlEvent):
    """What a source says: a beat at `beat_time` [s of the show], `period` [s] to the next, confidence 0 to 1.

    The source is the event's `source`: "audio", "midi", "link", "mtc" …
    """

    beat_time: float
    """It may lie ahead: a prediction."""
    period: float
    confidence: float
    beat: int = -1
    """Which beat of its measure it is, from 0; -1 where the source cannot tell."""
    beats_per_measure: int = 0
    """0 where the source cannot tell."""
    measure: int = -1
    """The source's own number of the measure, from 0 (song position, Link); -1 where it counts none."""
    jump: bool = False
    """Whether the source says that it has jumped (start, song position): its grid is to be taken at once."""
    anchored: bool = True
    """False where the source only counts evenly and cannot tell when a beat is: MIDI clock that was never started."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceChanged(ControlEvent):
    """A clock source came ("found"), rests longer than usual ("paused"), fell silent ("silent"), went away ("lost").

    MIDI and Link also say "started" and "stopped".
    """

    state: str
    detail: str = ""
