"""Events of MIDI: learned bindings and features of notes."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnMidi(ControlEvent):
    """Binds a control to the next MIDI controller that is moved."""

    address: str
    """Address of the control; empty: cancel."""
    given: str = ""
    """Fixed values of the control, one per line: `name=value`, or a text for its next text argument."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForgetMidi(ControlEvent):
    """Removes the learned bindings of a control."""

    address: str


@dataclass(frozen=True, slots=True, kw_only=True)
class NotesHeard(ControlEvent):
    """Features of the notes played over MIDI; sent several times per beat while they change."""

    beats: float
    """Beats since the previous event."""
    energy: float
    """Velocity, 0 to 1, decaying after each note-on."""
    density: float
    """Note-ons per beat over the last beats."""
    chord: int
    """Number of sounding notes."""
    pitch: float
    """Mean position of the sounding, else the last, notes on the piano's keys, 0 to 1."""
