"""Events that concern what is played over MIDI."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnMidi(ControlEvent):
    """What is moved next on a MIDI controller works a control from then on."""

    address: str
    """Of the control; empty: nothing is learned after all."""
    given: str = ""
    """Values of the control that are always the same, a line each: `name=value`, or a text for its next text."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForgetMidi(ControlEvent):
    """What was learned for a control is forgotten."""

    address: str


@dataclass(frozen=True, slots=True, kw_only=True)
class NotesHeard(ControlEvent):
    """What the notes that are played over MIDI are like; told several times a beat while that changes."""

    beats: float
    """Beats since it was told last."""
    energy: float
    """0 to 1: how hard notes are struck, dying away after the stroke."""
    density: float
    """Strokes per beat over the last beats."""
    chord: int
    """Notes that sound."""
    pitch: float
    """0 to 1 over the piano's keys: where what sounds lies, or did last."""
