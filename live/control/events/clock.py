"""Commands of the clock and blackout, and observations of clock sources."""

from dataclasses import dataclass
from typing import Annotated

from live.clock.follower.clock_source import PRIORITY
from live.clock.timeline import METRE_MAX, METRE_MIN, TEMPO_MAX_BPM, TEMPO_MIN_BPM
from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument


@command("/dance/clock/tap", "musician")
class Tap(ControlEvent):
    """Taps a beat; several taps give the tempo."""


@command("/dance/clock/one", "musician")
class One(ControlEvent):
    """ "This is the one": a measure starts now."""


@command("/dance/clock/tempo", "musician", value=1)
class SetTempo(ControlEvent):
    """Sets the tempo; the beat continues without a jump. Tracked music takes over again after 8 s."""

    tempo: Annotated[float, Argument.number("the new tempo", TEMPO_MIN_BPM, TEMPO_MAX_BPM, "bpm")]


@command("/dance/clock/half", "musician", "Half as many beats, from the next strong beat on.", fixed={"factor": 0.5})
@command("/dance/clock/double", "musician", "Twice as many beats, from the next beat on.", fixed={"factor": 2.0})
class ScaleTempo(ControlEvent):
    """Half (0.5) or double (2) tempo, from the next beat common to both."""

    factor: float


@command("/dance/clock/nudge", "musician")
class Nudge(ControlEvent):
    """Moves the beats a little relative to the active source; nudges add up."""

    seconds: Annotated[float, Argument.number("later, or earlier if negative", -0.25, 0.25, "s")] = 0.01


@command("/dance/clock/shift", "musician")
class ShiftBeats(ControlEvent):
    """Moves the measure line by beats; half a beat moves the beats to the off-beat."""

    beats: Annotated[float, Argument.number("later, or earlier if negative", -8, 8, "beats")] = 1.0


@command("/dance/clock/take", "musician")
class TakeRunnerUp(ControlEvent):
    """Takes the measure line that the music suggests: the runner-up, which the overlay and the status show."""


@command("/dance/clock/hold", "musician", value=1, start=(False,))
class HoldTempo(ControlEvent):
    """Freezes the tempo: no source corrects tempo or beat."""

    on: Annotated[bool, Argument.switch("1: the tempo is frozen, 0: it follows the source again")] = True


@command("/dance/clock/metre", "musician", value=1)
class SetMetre(ControlEvent):
    """Sets the beats per measure from the next measure line on; a step fills the measure."""

    beats: Annotated[int, Argument.number("beats of a measure, rounded", METRE_MIN, METRE_MAX, "beats")]


@command("/dance/clock/count_in", "musician")
class CountIn(ControlEvent):
    """Counts in to the one, from the next beat if there is one, else after a measure of taps."""

    measures: Annotated[float, Argument.number("measures counted before the one, rounded", 0, 8, "measures")] = 1.0


@command("/dance/clock/source", "operator", value=1, start=("auto",))
class ChooseSource(ControlEvent):
    """Selects the clock source; it takes over at a measure line, once it is available."""

    name: Annotated[str, Argument.label(f'"auto", or one of {", ".join(PRIORITY)}')] = "auto"


@command("/dance/blackout", "operator", value=1, start=(False,))
class Blackout(ControlEvent):
    """Switches the light of the show off or on."""

    on: Annotated[bool, Argument.switch("1: light off, 0: light on")]


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
    runner_up: int = 0
    """By how many beats later measures would begin on the most likely other line; 0 if unknown."""
    runner_up_share: float = 0.0
    """Probability of that line, 0 to 1."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceChanged(ControlEvent):
    """A clock source appeared ("found"), paused longer than usual ("paused"), fell "silent", or is "lost".

    MIDI and Link also report "started" and "stopped".
    """

    state: str
    detail: str = ""
