"""Reactions to music: `Reactions` (the patch's `[[react]]` tables), `Mood` and `Occasions` (T016).

`Mood` smooths music features over the last beats for improvisation. `Occasions` turns music events (louder, build-up,
drop) into named signals.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

from live.control.events.events import ControlEvent, MusicHeard, NotesHeard, SetMotion, SetPicture
from live.show.patch.patch import Patch
from live.show.patch.score_checks import UNIT
from live.show.patch.section_music import ReactSection
from live.show.patch.section_score import SignalSection

DENSE: Final = 6.0
"""Onsets per beat that map to level 1."""
BEATS: Final = 4.0
"""Time constant of the smoothing [beats]."""
NAMES: Final = ("loudness", "density", "brightness", "low", "build")
NOTE_NAMES: Final = ("note_energy", "note_density", "chord", "pitch")
"""Features of MIDI notes."""
FULL: Final = 8.0
"""Simultaneous notes that map to level 1."""


def level_of(event: MusicHeard, name: str) -> float:
    """Return the music feature `name` of `NAMES`, 0 to 1."""
    return min(event.density / DENSE, 1.0) if name == "density" else float(getattr(event, name))


def note_level_of(event: NotesHeard, name: str) -> float:
    """Return the note feature `name` of `NOTE_NAMES`, 0 to 1."""
    match name:
        case "note_energy":
            return event.energy
        case "note_density":
            return min(event.density / DENSE, 1.0)
        case "chord":
            return min(event.chord / FULL, 1.0)
    return event.pitch


class Mood:
    """Smoothed features of the music.

    Takes MusicHeard and NotesHeard in order. Before any music, features are 0.5 and build-up is 0; before any note,
    note features are 0 and pitch is 0.5.
    """

    def __init__(self) -> None:
        self._values = {**dict.fromkeys(NAMES, 0.5), "build": 0.0}
        self._values |= {**dict.fromkeys(NOTE_NAMES, 0.0), "pitch": 0.5}
        self._heard = False
        self.notes: NotesHeard | None = None
        """The last NotesHeard event."""

    def hear_notes(self, event: NotesHeard) -> None:
        """Update the note features."""
        share = 1.0 - math.exp(-event.beats / BEATS) if self.notes is not None else 1.0
        self.notes = event
        for name in NOTE_NAMES:
            self._values[name] += share * (note_level_of(event, name) - self._values[name])

    def hear(self, event: MusicHeard) -> None:
        """Update the music features by one beat."""
        share = 1.0 - math.exp(-1.0 / BEATS) if self._heard else 1.0
        self._heard = True
        for name in NAMES:
            self._values[name] += share * (level_of(event, name) - self._values[name])

    def of(self, name: str) -> float:
        """Return a feature by name, 0 to 1.

        `energy` is the mean of loudness and density, of the music or of the notes, whichever is higher.
        """
        if name != "energy":
            return self._values[name]
        values = self._values
        music, notes = values["loudness"] + values["density"], values["note_energy"] + values["note_density"]
        if self.notes is None:
            return 0.5 * music
        return 0.5 * (max(music, notes) if self._heard else notes)


BUILDING: Final = 0.5
"""Level at which a build-up begins."""

NOT_BUILDING: Final = 0.2
"""Level at which a build-up ends."""

SMOOTH: Final = 0.25
"""Fade time of light that follows the music [measures]: about until the next beat."""
STRENGTH: Final = "strength"


class Reactions:
    """State of the `[[react]]` tables.

    Takes MusicHeard and NotesHeard in order; the same events give the same changes. Thread: the show's.
    """

    def __init__(self, patch: Patch) -> None:
        self._follows = [section for section in patch.react if section.to is not None]
        self._calls = [section for section in patch.react if section.on is not None]
        self._values: list[float | None] = [None] * len(self._follows)
        self._waiting: list[ReactSection] = []
        self.soon: list[ReactSection] = []
        """Sections whose calls are due before the next line; the caller empties it."""
        self.calm = False
        """Whether calls are suppressed; values still follow the music."""
        self._building = False
        self._last: MusicHeard | None = None
        self.strength = 1.0
        """Strength factor for elements that begin now."""
        self.drops = 0
        """Drops heard so far."""

    def take_patch(self, fresh: "Reactions") -> None:
        """Adopt the tables of an edited patch; values that are already followed continue smoothly."""
        known = dict(zip(self._follows, self._values, strict=True))
        self._follows, self._calls = fresh._follows, fresh._calls
        self._values = [known.get(section) for section in self._follows]
        self._waiting = [section for section in self._waiting if section in self._calls]
        self.soon = [section for section in self.soon if section in self._calls]
        if not any(section.sets == STRENGTH for section in self._follows):
            self.strength = 1.0

    def hear(self, event: MusicHeard) -> list[ControlEvent]:
        """Return the immediate changes caused by one beat of the music."""
        self._last = event
        self.drops += event.drop
        begins = event.build >= BUILDING and not self._building
        self._building = event.build >= (NOT_BUILDING if self._building else BUILDING)
        self._happens([*(["drop"] if event.drop else []), *(["build"] if begins else [])])
        return self._follow(event.time, {name: level_of(event, name) for name in NAMES}, 1.0)

    def hear_notes(self, event: NotesHeard) -> list[ControlEvent]:
        """Return the immediate changes caused by the current notes."""
        return self._follow(event.time, {name: note_level_of(event, name) for name in NOTE_NAMES}, event.beats)

    def _follow(self, time: float, levels: Mapping[str, float], beats: float) -> list[ControlEvent]:
        """Return the changes that follow these levels, `beats` after the previous levels."""
        changes: list[ControlEvent] = []
        for index, section in enumerate(self._follows):
            heard = levels.get(section.to or "")
            if heard is None:
                continue
            value = self._smoothed(index, section, heard, beats)
            if section.sets == STRENGTH:
                self.strength = max(value, 0.0)
            elif section.sets is not None and section.sets.startswith("/"):
                changes.append(SetPicture(time=time, source="music", parameter=section.sets, x=value, measures=SMOOTH))
            elif section.sets is not None:
                group = "" if section.group == "*" else section.group
                changes.append(SetMotion(time=time, source="music", parameter=section.sets, value=value, group=group))
        return changes

    def signal(self, name: str) -> None:
        """Handle a signal."""
        self._happens([name.casefold()])

    def unit(self, label: str) -> None:
        """Handle a unit danced by an answering partner: `turn/2` triggers `unit:turn/2` and `unit:turn`."""
        name = UNIT + label.casefold()
        self._happens([name, name.rpartition("/")[0]])

    def _happens(self, names: list[str]) -> None:
        if self.calm:
            return
        for section in self._calls:
            if (section.on or "").casefold() in names and section not in self._waiting + self.soon:
                (self._waiting if section.when == "measure" else self.soon).append(section)

    def forget(self) -> None:
        """Discard all waiting calls."""
        self._waiting.clear()
        self.soon.clear()

    def cross_measure_line(self, time: float) -> list[ControlEvent]:
        """Return the calls that waited for the measure line."""
        waiting, self._waiting = self._waiting, []
        return [event for section in waiting if isinstance(event := section.event(time), ControlEvent)]

    def facts(self) -> dict[str, Any]:
        """Return music features for the status."""
        last = self._last
        if last is None:
            return {"drops": self.drops}
        names = ("loudness", "density", "brightness", "low", "build", "loudness_db")
        return {**{name: round(getattr(last, name), 3) for name in names}, "drops": self.drops}

    def _smoothed(self, index: int, section: ReactSection, heard: float, beats: float) -> float:
        before = self._values[index]
        share = 1.0 if before is None or section.beats == 0.0 else 1.0 - math.exp(-beats / section.beats)
        value = heard if before is None else before + share * (heard - before)
        self._values[index] = value
        return section.low + (section.high - section.low) * value


MUCH: Final = 0.75
LITTLE: Final = 0.25
BACK: Final = 0.1
"""Hysteresis: a passed level triggers again after it was left by this much (three times as much for a build-up)."""
_HEARD: Final = {
    "build": ("build", True, BUILDING),
    "loud": ("loudness", True, MUCH),
    "quiet": ("loudness", False, LITTLE),
    "dense": ("density", True, MUCH),
    "sparse": ("density", False, LITTLE),
    "bright": ("brightness", True, MUCH),
    "dark": ("brightness", False, LITTLE),
}


class Occasions:
    """Detector for the patch's music signals. Takes MusicHeard in order. Thread: the show's."""

    def __init__(self, signals: Iterable[SignalSection]) -> None:
        self._signals = [signal for signal in signals if signal.on is not None]
        self._there = [False] * len(self._signals)

    def take_patch(self, fresh: "Occasions") -> None:
        """Adopt the signals of an edited patch."""
        known = dict(zip(self._signals, self._there, strict=True))
        self._signals = fresh._signals
        self._there = [known.get(signal, False) for signal in self._signals]

    def hear(self, event: MusicHeard) -> list[str]:
        """Return the names of the signals that one beat of the music triggers."""
        names = []
        for index, signal in enumerate(self._signals):
            if signal.on == "drop":
                comes = event.drop
            else:
                name, high, level = _HEARD[signal.on or "build"]
                level = level if signal.level is None else signal.level
                heard = level_of(event, name)
                back = 3.0 * BACK if name == "build" else BACK
                if self._there[index]:
                    is_there = heard > level - back if high else heard < level + back
                else:
                    is_there = heard >= level if high else heard <= level
                comes = is_there and not self._there[index]
                self._there[index] = is_there
            if comes:
                names.append(signal.name)
        return names
