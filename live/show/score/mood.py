"""Mood: what the music has been like over the last beats, for whoever improvises to it."""

import math
from typing import Final

from live.control.events.events import MusicHeard, NotesHeard

DENSE: Final = 6.0
"""Onsets per beat that count as 1."""
BEATS: Final = 4.0
"""Beats over which it is smoothed."""
NAMES: Final = ("loudness", "density", "brightness", "low", "build")
NOTE_NAMES: Final = ("note_energy", "note_density", "chord", "pitch")
"""What notes that are played over MIDI are like."""
FULL: Final = 8.0
"""Notes that sound together and count as 1."""


def level_of(event: MusicHeard, name: str) -> float:
    """What is heard by this name of `NAMES`, 0 to 1."""
    return min(event.density / DENSE, 1.0) if name == "density" else float(getattr(event, name))


def note_level_of(event: NotesHeard, name: str) -> float:
    """What is played by this name of `NOTE_NAMES`, 0 to 1."""
    match name:
        case "note_energy":
            return event.energy
        case "note_density":
            return min(event.density / DENSE, 1.0)
        case "chord":
            return min(event.chord / FULL, 1.0)
    return event.pitch


class Mood:
    """Takes MusicHeard and NotesHeard in order. Before any music is heard it is in the middle: 0.5, and no build-up;
    before any note is played, there is none."""

    def __init__(self) -> None:
        self._values = {**dict.fromkeys(NAMES, 0.5), "build": 0.0}
        self._values |= {**dict.fromkeys(NOTE_NAMES, 0.0), "pitch": 0.5}
        self._heard = False
        self.notes: NotesHeard | None = None
        """What was played last."""

    def hear_notes(self, event: NotesHeard) -> None:
        """What is played now."""
        share = 1.0 - math.exp(-event.beats / BEATS) if self.notes is not None else 1.0
        self.notes = event
        for name in NOTE_NAMES:
            self._values[name] += share * (note_level_of(event, name) - self._values[name])

    def hear(self, event: MusicHeard) -> None:
        """One beat of the music."""
        share = 1.0 - math.exp(-1.0 / BEATS) if self._heard else 1.0
        self._heard = True
        for name in NAMES:
            self._values[name] += share * (level_of(event, name) - self._values[name])

    def of(self, name: str) -> float:
        """What is heard by this name, 0 to 1.

        `energy` is the mean of loudness and density, of the music or of the notes: whichever has more of it.
        """
        if name != "energy":
            return self._values[name]
        values = self._values
        music, notes = values["loudness"] + values["density"], values["note_energy"] + values["note_density"]
        if self.notes is None:
            return 0.5 * music
        return 0.5 * (max(music, notes) if self._heard else notes)
