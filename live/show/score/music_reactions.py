"""Reactions: what the music that is heard changes in a show, as the patch's `[[react]]` tables say.

Mood: what the music has been like over the last beats, for whoever improvises to it.

Occasions: what is heard in the music as signals by name: it becomes louder, a build-up begins, a drop (T016).
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


BUILDING: Final = 0.5
"""From here on a build-up counts as begun ..."""

NOT_BUILDING: Final = 0.2
"""... until it has come down to this."""

SMOOTH: Final = 0.25
"""Light goes to what a beat asks for within so many measures: until the next one."""
STRENGTH: Final = "strength"


class Reactions:
    """Takes MusicHeard and NotesHeard in order; the same events give the same changes. Thread: the show's."""

    def __init__(self, patch: Patch) -> None:
        self._follows = [section for section in patch.react if section.to is not None]
        self._calls = [section for section in patch.react if section.on is not None]
        self._values: list[float | None] = [None] * len(self._follows)
        self._waiting: list[ReactSection] = []
        self.soon: list[ReactSection] = []
        """What is to be called before the next line, for whoever calls it."""
        self.calm = False
        """Whether nothing is called, whatever happens in the music; values go on following it."""
        self._building = False
        self._last: MusicHeard | None = None
        self.strength = 1.0
        """How much stronger elements are that begin now."""
        self.drops = 0
        """Drops heard so far."""

    def take_patch(self, fresh: "Reactions") -> None:
        """Follow the music as another patch says; what is followed already goes on smoothly."""
        known = dict(zip(self._follows, self._values, strict=True))
        self._follows, self._calls = fresh._follows, fresh._calls
        self._values = [known.get(section) for section in self._follows]
        self._waiting = [section for section in self._waiting if section in self._calls]
        self.soon = [section for section in self.soon if section in self._calls]
        if not any(section.sets == STRENGTH for section in self._follows):
            self.strength = 1.0

    def hear(self, event: MusicHeard) -> list[ControlEvent]:
        """What one beat of the music changes at once."""
        self._last = event
        self.drops += event.drop
        begins = event.build >= BUILDING and not self._building
        self._building = event.build >= (NOT_BUILDING if self._building else BUILDING)
        self._happens([*(["drop"] if event.drop else []), *(["build"] if begins else [])])
        return self._follow(event.time, {name: level_of(event, name) for name in NAMES}, 1.0)

    def hear_notes(self, event: NotesHeard) -> list[ControlEvent]:
        """What the notes that are played change at once."""
        return self._follow(event.time, {name: note_level_of(event, name) for name in NOTE_NAMES}, event.beats)

    def _follow(self, time: float, levels: Mapping[str, float], beats: float) -> list[ControlEvent]:
        """What follows these levels, `beats` after they were heard last."""
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
        """A signal is given."""
        self._happens([name.casefold()])

    def unit(self, label: str) -> None:
        """A unit of an example is danced by who answers a leader: `turn/2` is `unit:turn/2`, and `unit:turn`."""
        name = UNIT + label.casefold()
        self._happens([name, name.rpartition("/")[0]])

    def _happens(self, names: list[str]) -> None:
        if self.calm:
            return
        for section in self._calls:
            if (section.on or "").casefold() in names and section not in self._waiting + self.soon:
                (self._waiting if section.when == "measure" else self.soon).append(section)

    def forget(self) -> None:
        """What was waiting to be called is not."""
        self._waiting.clear()
        self.soon.clear()

    def cross_measure_line(self, time: float) -> list[ControlEvent]:
        """What was waiting for the measure line."""
        waiting, self._waiting = self._waiting, []
        return [event for section in waiting if isinstance(event := section.event(time), ControlEvent)]

    def facts(self) -> dict[str, Any]:
        """What the music is like, for the status."""
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
"""A level that was passed counts again once it has been left by so much; a build-up by three times as much."""
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
    """Takes MusicHeard in order. Thread: the show's."""

    def __init__(self, signals: Iterable[SignalSection]) -> None:
        self._signals = [signal for signal in signals if signal.on is not None]
        self._there = [False] * len(self._signals)

    def take_patch(self, fresh: "Occasions") -> None:
        """Listen for the signals of another patch."""
        known = dict(zip(self._signals, self._there, strict=True))
        self._signals = fresh._signals
        self._there = [known.get(signal, False) for signal in self._signals]

    def hear(self, event: MusicHeard) -> list[str]:
        """The names of the signals that one beat of the music gives."""
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
