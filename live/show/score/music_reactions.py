"""Reactions to music: `Reactions` (the patch's `[[react]]` tables), `Mood` and `MusicSignals` (T016).

`Mood` smooths music features over the last beats for improvisation. `MusicSignals` turns music events
(louder, build-up, drop) into named signals.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

from live.base.motion_parameters import MOTION_KEYS
from live.control.events.events import ControlEvent, CurveMoved, MusicHeard, NotesHeard, SetParameter
from live.control.registry.registry import REGISTRY
from live.show.patch.patch import Patch
from live.show.patch.section_music import CURVE_PREFIX, PERFORMER_PREFIX, UNIT_PREFIX, ReactSection
from live.show.patch.section_score import SignalSection

FULL_DENSITY: Final = 6.0
"""Onsets per beat that map to level 1."""
SMOOTHING_BEATS: Final = 4.0
"""Time constant of the smoothing [beats]."""
NAMES: Final = ("loudness", "density", "brightness", "low", "build")
NOTE_NAMES: Final = ("note_energy", "note_density", "chord", "pitch")
"""Features of MIDI notes."""
FULL_CHORD: Final = 8.0
"""Simultaneous notes that map to level 1."""


def music_level(event: MusicHeard, name: str) -> float:
    """Return the music feature `name` of `NAMES`, 0 to 1."""
    return min(event.density / FULL_DENSITY, 1.0) if name == "density" else float(getattr(event, name))


def note_level(event: NotesHeard, name: str) -> float:
    """Return the note feature `name` of `NOTE_NAMES`, 0 to 1."""
    match name:
        case "note_energy":
            return event.energy
        case "note_density":
            return min(event.density / FULL_DENSITY, 1.0)
        case "chord":
            return min(event.chord / FULL_CHORD, 1.0)
    return event.pitch


def reaction_event(section: ReactSection, time: float) -> object:
    """Return the event of a reaction's call: a ControlEvent, if the call was checked."""
    return REGISTRY.call(section.call or "", section.values, time, "music")


class Mood:
    """Smoothed features of the music.

    Takes MusicHeard and NotesHeard in order. Before any music, features are 0.5 and build-up is 0; before any note,
    note features are 0 and pitch is 0.5.
    """

    def __init__(self) -> None:
        self._values = {**dict.fromkeys(NAMES, 0.5), "build": 0.0}
        self._values |= {**dict.fromkeys(NOTE_NAMES, 0.0), "pitch": 0.5}
        self._has_music = False
        self.notes: NotesHeard | None = None
        """The last NotesHeard event."""

    def update_notes(self, event: NotesHeard) -> None:
        """Update the note features."""
        share = 1.0 - math.exp(-event.beats / SMOOTHING_BEATS) if self.notes is not None else 1.0
        self.notes = event
        for name in NOTE_NAMES:
            self._values[name] += share * (note_level(event, name) - self._values[name])

    def update(self, event: MusicHeard) -> None:
        """Update the music features by one beat."""
        share = 1.0 - math.exp(-1.0 / SMOOTHING_BEATS) if self._has_music else 1.0
        self._has_music = True
        for name in NAMES:
            self._values[name] += share * (music_level(event, name) - self._values[name])

    @property
    def heard(self) -> bool:
        """Whether any music or note was heard."""
        return self._has_music or self.notes is not None

    def value(self, name: str) -> float:
        """Return a feature by name, 0 to 1.

        `energy` is the mean of loudness and density, of the music or of the notes, whichever is higher.
        """
        if name != "energy":
            return self._values[name]
        values = self._values
        music, notes = values["loudness"] + values["density"], values["note_energy"] + values["note_density"]
        if self.notes is None:
            return 0.5 * music
        return 0.5 * (max(music, notes) if self._has_music else notes)


BUILD_BEGIN: Final = 0.5
"""Level at which a build-up begins."""

BUILD_END: Final = 0.2
"""Level at which a build-up ends."""

FADE_MEASURES: Final = 0.25
"""Fade time of light that follows the music [measures]: about until the next beat."""
STRENGTH: Final = "strength"
CURVE_BEATS: Final = 0.25
"""Beats between two values of a curve."""
CURVE_FADE_MEASURES: Final = 0.0625
"""The same for a curve [measures]: about until its next value."""


class Reactions:
    """State of the `[[react]]` tables.

    Takes MusicHeard and NotesHeard in order; the same events give the same changes. Thread: the show's.
    """

    def __init__(self, patch: Patch) -> None:
        self._value_sections = [section for section in patch.react if section.to is not None]
        self._call_sections = [section for section in patch.react if section.on is not None]
        self._values: list[float | None] = [None] * len(self._value_sections)
        self._line_calls: list[ReactSection] = []
        self.pending_calls: list[ReactSection] = []
        """Sections whose calls are due before the next line; the caller empties it."""
        self.suppressed = False
        """Whether calls are suppressed; values still follow the music."""
        self._building = False
        self._last: MusicHeard | None = None
        self.strength = 1.0
        """Strength factor for elements that begin now."""
        self.drops = 0
        """Drops heard so far."""

    def apply_patch(self, fresh: "Reactions") -> None:
        """Adopt the tables of an edited patch; values that are already followed continue smoothly."""
        known = dict(zip(self._value_sections, self._values, strict=True))
        self._value_sections, self._call_sections = fresh._value_sections, fresh._call_sections
        self._values = [known.get(section) for section in self._value_sections]
        self._line_calls = [section for section in self._line_calls if section in self._call_sections]
        self.pending_calls = [section for section in self.pending_calls if section in self._call_sections]
        if not any(section.sets == STRENGTH for section in self._value_sections):
            self.strength = 1.0

    def handle_music(self, event: MusicHeard) -> list[ControlEvent]:
        """Return the immediate changes caused by one beat of the music."""
        self._last = event
        self.drops += event.drop
        begins = event.build >= BUILD_BEGIN and not self._building
        self._building = event.build >= (BUILD_END if self._building else BUILD_BEGIN)
        self._trigger([*(["drop"] if event.drop else []), *(["build"] if begins else [])])
        return self._follow(event.time, {name: music_level(event, name) for name in NAMES}, 1.0)

    def handle_notes(self, event: NotesHeard) -> list[ControlEvent]:
        """Return the immediate changes caused by the current notes."""
        return self._follow(event.time, {name: note_level(event, name) for name in NOTE_NAMES}, event.beats)

    def handle_curve(self, event: CurveMoved) -> list[ControlEvent]:
        """Return the immediate changes caused by a curve of the score."""
        levels = {CURVE_PREFIX + event.name.casefold().strip(): event.value}
        return self._follow(event.time, levels, CURVE_BEATS, fade=CURVE_FADE_MEASURES)

    @property
    def follows_performers(self) -> bool:
        """Whether any value follows the movement of a captured performer."""
        return any((section.to or "").startswith(PERFORMER_PREFIX) for section in self._value_sections)

    def handle_movement(self, time: float, levels: Mapping[str, float], beats: float) -> list[ControlEvent]:
        """Return the changes that follow captured performers, whose movement is `levels` by the words of `to`, `beats`
        after the previous ones."""
        return self._follow(time, levels, beats, fade=CURVE_FADE_MEASURES, source="mocap")

    def _follow(
        self,
        time: float,
        levels: Mapping[str, float],
        beats: float,
        *,
        fade: float = FADE_MEASURES,
        source: str = "music",
    ) -> list[ControlEvent]:
        """Return the changes that follow these levels, `beats` after the previous levels; numbers of the picture fade
        in `fade` measures."""
        changes: list[ControlEvent] = []
        for index, section in enumerate(self._value_sections):
            heard = levels.get((section.to or "").casefold().strip())
            if heard is None:
                continue
            value = self._smoothed(index, section, heard, beats)
            if section.sets == STRENGTH:
                self.strength = max(value, 0.0)
            elif section.sets is not None:
                row = MOTION_KEYS.get(section.sets)
                number = value if row is None else min(max(value, row.low), row.high)
                changes.append(SetParameter(
                    time=time, source=source, value=(number,), group=section.group,
                    address=section.sets if row is None else row.address,
                    measures=fade if row is None else 0.0,
                ))  # fmt: skip
        return changes

    def handle_signal(self, name: str) -> None:
        """Handle a signal."""
        self._trigger([name.casefold()])

    def handle_unit(self, label: str) -> None:
        """Handle a unit danced by an answering partner: `turn/2` triggers `unit:turn/2` and `unit:turn`."""
        name = UNIT_PREFIX + label.casefold()
        self._trigger([name, name.rpartition("/")[0]])

    def _trigger(self, names: list[str]) -> None:
        if self.suppressed:
            return
        for section in self._call_sections:
            if (section.on or "").casefold() in names and section not in self._line_calls + self.pending_calls:
                (self._line_calls if section.when == "measure" else self.pending_calls).append(section)

    def clear_calls(self) -> None:
        """Discard all waiting calls."""
        self._line_calls.clear()
        self.pending_calls.clear()

    def cross_measure_line(self, time: float) -> list[ControlEvent]:
        """Return the calls that waited for the measure line."""
        waiting, self._line_calls = self._line_calls, []
        return [event for section in waiting if isinstance(event := reaction_event(section, time), ControlEvent)]

    def facts(self) -> dict[str, Any]:
        """Return music features for the status."""
        last = self._last
        if last is None:
            return {"drops": self.drops}
        names = ("loudness", "density", "brightness", "low", "build", "loudness_db")
        return {**{name: round(getattr(last, name), 3) for name in names}, "drops": self.drops}

    def _smoothed(self, index: int, section: ReactSection, level: float, beats: float) -> float:
        before = self._values[index]
        exact = section.beats == 0.0 or (section.is_curve and "beats" not in section.model_fields_set)
        share = 1.0 if before is None or exact else 1.0 - math.exp(-beats / section.beats)
        value = level if before is None else before + share * (level - before)
        self._values[index] = value
        return section.low + (section.high - section.low) * value


HIGH_LEVEL: Final = 0.75
LOW_LEVEL: Final = 0.25
HYSTERESIS: Final = 0.1
"""Hysteresis: a passed level triggers again after it was left by this much (three times as much for a build-up)."""
_TRIGGERS: Final = {
    "build": ("build", True, BUILD_BEGIN),
    "loud": ("loudness", True, HIGH_LEVEL),
    "quiet": ("loudness", False, LOW_LEVEL),
    "dense": ("density", True, HIGH_LEVEL),
    "sparse": ("density", False, LOW_LEVEL),
    "bright": ("brightness", True, HIGH_LEVEL),
    "dark": ("brightness", False, LOW_LEVEL),
}


class MusicSignals:
    """Detector for the patch's music signals. Takes MusicHeard in order. Thread: the show's."""

    def __init__(self, signals: Iterable[SignalSection]) -> None:
        self._signals = [signal for signal in signals if signal.on is not None or signal.curve is not None]
        self._active = [False] * len(self._signals)

    def apply_patch(self, fresh: "MusicSignals") -> None:
        """Adopt the signals of an edited patch."""
        known = dict(zip(self._signals, self._active, strict=True))
        self._signals = fresh._signals
        self._active = [known.get(signal, False) for signal in self._signals]

    def detect_curve(self, event: CurveMoved) -> list[str]:
        """Return the names of the signals that a curve triggers: it has risen to their level."""
        names = []
        for index, signal in enumerate(self._signals):
            if (signal.curve or "").casefold().strip() != event.name.casefold().strip():
                continue
            level = HIGH_LEVEL if signal.level is None else signal.level
            before, there = self._active[index], event.value >= level - 1e-9
            self._active[index] = there or (before and event.value > level - HYSTERESIS)
            if there and not before:
                names.append(signal.name)
        return names

    def detect(self, event: MusicHeard) -> list[str]:
        """Return the names of the signals that one beat of the music triggers."""
        names = []
        for index, signal in enumerate(self._signals):
            if signal.curve is not None:
                continue
            if signal.on == "drop":
                comes = event.drop
            else:
                name, high, level = _TRIGGERS[signal.on or "build"]
                level = level if signal.level is None else signal.level
                heard = music_level(event, name)
                back = 3.0 * HYSTERESIS if name == "build" else HYSTERESIS
                if self._active[index]:
                    is_there = heard > level - back if high else heard < level + back
                else:
                    is_there = heard >= level if high else heard <= level
                comes = is_there and not self._active[index]
                self._active[index] = is_there
            if comes:
                names.append(signal.name)
        return names
