"""Commands of learned MIDI bindings, and features of MIDI notes."""

from dataclasses import dataclass
from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument

Given = Annotated[str, Argument.text("a fixed value: a group, a scene's name …, or `name=value`")]


@command("/dance/midi/learn", "operator")
class LearnMidi(ControlEvent):
    """Binds this control to the next MIDI controller, pad or key that is moved; saved with the patch."""

    address: Annotated[str, Argument.text("of the control; empty: cancel")] = ""
    first: Given = ""
    second: Given = ""
    third: Given = ""
    fourth: Given = ""

    @property
    def given(self) -> list[str]:
        """The fixed values: `name=value`, or a text for the control's next text argument."""
        return [value for value in (self.first, self.second, self.third, self.fourth) if value]


@command("/dance/midi/forget", "operator")
class ForgetMidi(ControlEvent):
    """Removes the learned bindings of this control."""

    address: Annotated[str, Argument.text("of the control")]


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
