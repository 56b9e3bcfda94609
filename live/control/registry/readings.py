"""Readings: what can only be read of a running show, under /dance/status, as the values of controls are."""

from dataclasses import dataclass
from typing import Final, Literal

STATUS: Final = "/dance/status/"


@dataclass(frozen=True, slots=True)
class Reading:
    """One figure of a running show."""

    name: str
    type: Literal["float", "int", "text"]
    description: str
    unit: str = ""

    @property
    def address(self) -> str:
        """Its OSC address."""
        return STATUS + self.name


READINGS: Final = (
    Reading("measure", "int", "The measure of the show, from 1."),
    Reading("beat", "int", "The beat of the measure, from 1."),
    Reading("bpm", "float", "The tempo that is danced.", "bpm"),
    Reading("source", "text", "Which source the beat comes from."),
    Reading("clock", "text", "How sure that source is: internal, listening, following or locked."),
    Reading("dancers", "int", "Dancers on the stage."),
    Reading("phones", "int", "Phones of the audience that play along."),
    Reading("section", "text", "The section of the score; empty outside of all."),
    Reading("cue", "text", "The cue that stands by; empty if none does."),
    Reading("count_in", "float", "Beats until the cue comes that counts in; 0 if none does.", "beats"),
    Reading("note_energy", "float", "How hard notes over MIDI are struck, dying away; 0 to 1."),
    Reading("note_density", "float", "Strokes of notes over MIDI per beat.", "1/beat"),
    Reading("notes", "int", "Notes over MIDI that sound."),
    Reading("pitch", "float", "Where on the piano's keys they lie, 0 to 1."),
    Reading("fading", "int", "Numbers that are on their way to another value."),
    Reading("frame_ms", "float", "From one frame to the next; 99 of 100 are not longer.", "ms"),
    Reading("late_frames", "int", "Frames that came late, since the start."),
    Reading("accepted", "int", "Events that acted, since the start."),
    Reading("refused", "int", "Messages and events that were refused, since the start."),
)
"""All of them."""
