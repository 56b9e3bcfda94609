"""Score interpreter: follows the score with playhead and scheduler, and emits its events at their beats (T015,
T016)."""

import math
from collections import Counter
from dataclasses import replace
from typing import Any, Final

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.patch.patch import Patch
from live.show.patch.section_score import AtSection
from live.show.score.beat_scheduler import Agenda
from live.show.score.improviser import ImprovisedMotion
from live.show.score.music_reactions import Mood, Occasions, Reactions
from live.show.score.playhead import END, Playhead, When
from live.show.score.score import Score, stretches_of

AHEAD: Final = (events.CallStep, events.SetSequence, events.Improvise)
"""Calls that must be known before their measure begins: those at its line are sent ahead of it."""
AHEAD_BEATS: Final = 2.0
"""Lead time of these calls [beats]: a little before the measure is planned."""
GIVEN_AHEAD: Final = "score ahead"
"""Source of these calls."""
SCORE_EVENTS: Final = (events.JumpTo, events.Advance, events.HoldScore, events.Practice, events.Signal)
"""Events that `act` handles."""


class Prompter:
    """Position in the score of a show, and the events at its beats. Thread: the show's."""

    def __init__(self, patch: Patch, reactions: Reactions, *, seed: int) -> None:
        """`reactions` receive the signals."""
        self.playhead = Playhead(stretches_of(patch))
        self.score = Score(patch, self.playhead)
        self.agenda = Agenda()
        """Events that wait for their danced beat, from the score or other sources."""
        self.mood = Mood()
        """Music features for improvisation."""
        self.signals: Counter[str] = Counter()
        """Count of each signal, by name."""
        self.last_signal = ""
        self._given: list[AtSection] = []  # calls of the next measure that were sent ahead of it
        self._reactions = reactions
        self._occasions = Occasions(patch.signal)
        self._motion = ImprovisedMotion(patch.improvise, self.score, seed)
        self._known = {"drop", "build", *(one.name.casefold() for one in patch.signal)}
        self._known |= {one.signal.casefold() for one in patch.at if one.signal is not None}
        self._known |= {one.on.casefold() for one in patch.react if one.on is not None}
        self.late_jumps = 0
        """Jumps requested after the steps of their first measure were already chosen."""
        self.said = ""
        """Message about the last jump that came too late; kept until the next one."""
        self.said_measure = 0
        """Measure of the show, from 1, of that message."""
        self._beats = patch.clock.beats_per_measure
        self._names = {stretch.name.casefold(): i for i, stretch in enumerate(self.playhead.stretches)}

    def take_patch(self, fresh: "Prompter") -> None:
        """Adopt the sections and signals of an edited score; waiting events still fire."""
        self._names, self._known = fresh._names, fresh._known

    def begin_measure(self, measure: int, time: float) -> None:
        """Begin `measure` (from 0) at `time` [s]: schedule the score's events for their beats."""
        self.playhead.cross(measure)
        line = measure * self._beats
        given, self._given = self._given, []
        for call in self.score.calls(measure):
            event = call.event(time)
            if isinstance(event, ControlEvent) and call not in given:
                self.agenda.put(line + call.beat - 1.0, event)
        self._look_ahead(measure + 1, time)
        for event in self._motion.calls(measure, time):
            self.agenda.put(line, event)
        for signal in self.score.signals(measure):
            self.agenda.put(line + signal.beat - 1.0, events.Signal(time=time, source="score", name=signal.name))

    def _look_ahead(self, measure: int, time: float) -> None:
        """Schedule the step calls at the line of the next `measure` before that measure is planned."""
        for call in self.score.calls(measure):
            event = call.event(time)
            if call.beat == 1.0 and isinstance(event, AHEAD):
                self._given.append(call)
                self.agenda.put(measure * self._beats - AHEAD_BEATS, replace(event, source=GIVEN_AHEAD))

    def act(self, event: ControlEvent) -> bool:
        """Handle an event of `SCORE_EVENTS`; return whether the next measure changed. Raises PersonError for a
        missing place."""
        coming = self.playhead.measure + 1
        before = self.playhead.place(coming), self.playhead.entered(coming)
        try:
            match event:
                case events.JumpTo():
                    self.playhead.jump(self.section(event.section), event.measure - 1, _when(event.when))
                case events.Advance():
                    self.playhead.advance(_when(event.when))
                case events.HoldScore():
                    self.playhead.hold(event.on)
                case events.Practice():
                    practice = None if not event.first and not event.last else (event.first - 1, event.last - 1)
                    self.playhead.loop(practice)
                case events.Signal():
                    self._signal(event)
                    return False
        except ValueError as error:
            raise PersonError(str(error)) from None
        moved = before != (self.playhead.place(coming), self.playhead.entered(coming))
        if moved:
            self.agenda.withdraw(GIVEN_AHEAD, -math.inf)
            self._given.clear()
            self._look_ahead(coming, event.time)
        return moved

    def hear(self, event: events.MusicHeard) -> list[events.Signal]:
        """Update the mood by one beat of the music, and return the signals it triggers."""
        self.mood.hear(event)
        names = self._occasions.hear(event)
        return [events.Signal(time=event.time, source="music", name=name) for name in names]

    def hear_notes(self, event: events.NotesHeard) -> None:
        """Update the mood by notes played over MIDI."""
        self.mood.hear_notes(event)

    def _signal(self, event: events.Signal) -> None:
        """Pass a signal to the reactions. Raises PersonError for an unknown name."""
        name = event.name.casefold().strip()
        if name not in self._known:
            raise PersonError(f"no signal is called {event.name!r}", f"there are: {', '.join(sorted(self._known))}")
        self.signals[name] += 1
        self.last_signal = name
        self._reactions.signal(name)

    def take_reactions(self, danced: float, time: float) -> None:
        """Schedule the calls due before the next line, at once or at their beat; the danced beat is `danced`."""
        for section in self._reactions.soon:
            event = section.event(time)
            if isinstance(event, ControlEvent):
                self.agenda.put(danced if section.when == "now" else math.ceil(danced - 1e-9), event)
        self._reactions.soon.clear()

    def calm(self, on: bool) -> None:
        """Suppress waiting events and calls from reactions, or allow them again."""
        self._reactions.calm = on
        if on:
            self.agenda.clear()
            self._reactions.forget()

    def came_late(self) -> None:
        """Record a jump that changed the next measure after its steps were chosen; those steps are danced."""
        self.late_jumps += 1
        self.said = "the steps of the first measure were decided already: the old ones are danced"
        self.said_measure = self.playhead.measure + 1

    def section(self, name: str) -> int:
        """Return the index of a section; raises PersonError for an unknown name."""
        index = self._names.get(name.casefold().strip())
        if index is None:
            known = ", ".join(stretch.name for stretch in self.playhead.stretches if stretch.name)
            raise PersonError(
                f"no section is called {name!r}", f"there are: {known}" if known else "the patch has none"
            )
        return index

    def words(self) -> tuple[str, ...]:
        """Return the overlay's line on the score; none for a single section without requests."""
        playhead = self.playhead
        place = playhead.place(playhead.measure)
        if place.section == END:
            return () if place.measure < 0 else ("score: over",)
        stretch = playhead.stretches[place.section]
        asked = [
            "held" if playhead.held else "",
            "waits for GO" if playhead.waiting else "",
            "practice" if playhead.practice is not None else "",
            "" if playhead.going is None or playhead.going[0] == END else "goes to " + self._going(playhead.going),
            self.said if playhead.measure <= self.said_measure else "",  # shown for that measure and the next
        ]
        told = [word for word in asked if word]
        if not stretch.name and not told:
            return ()
        of = "" if stretch.measures is None else f" of {stretch.measures}"
        again = f", pass {playhead.passes} of {stretch.repeat}" if stretch.repeat > 1 else ""
        line = f"{stretch.name or 'score'}: measure {place.measure + 1}{of}{again}"
        return (", ".join([line, *told]),)

    def _going(self, going: tuple[int, int, When]) -> str:
        section, measure, when = going
        name = self.playhead.stretches[section].name or "score"
        return name + (f" {measure + 1}" if measure else "") + (" at the section's end" if when == "section" else "")

    def facts(self) -> dict[str, Any]:
        """Return the position in the score for the status; measures and turns count from 1."""
        playhead = self.playhead
        place = playhead.place(playhead.measure)
        over = place.section == END
        going = playhead.going
        return {
            "section": None if over else playhead.stretches[place.section].name,
            "section_measure": None if over else place.measure + 1,
            "section_turn": None if over else place.turn + 1,
            "score": {
                "measure": None if over else playhead.written(place) + 1,
                "measures": None if over else playhead.stretches[place.section].measures,
                "pass": playhead.passes,
                "waiting": playhead.waiting,
                "held": playhead.held,
                "going": None if going is None or going[0] == END else playhead.stretches[going[0]].name,
                "practice": None if playhead.practice is None else [playhead.practice[0] + 1, playhead.practice[1] + 1],
                "late_jumps": self.late_jumps,
                "said": self.said,
                "said_measure": self.said_measure or None,
                "signals": dict(self.signals),
                "last_signal": self.last_signal,
            },
        }


def _when(word: str) -> When:
    match word:
        case "measure" | "section":
            return word
    raise PersonError(f"when {word!r} is unknown", "there are: measure, section")
