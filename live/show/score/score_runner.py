"""Score interpreter: follows the score with playhead and scheduler, and emits its events at their beats (T015,
T016)."""

import math
from collections import Counter
from dataclasses import replace
from typing import Any, Final

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.show.patch.patch import Patch
from live.show.patch.section_score import AtSection
from live.show.score.beat_scheduler import BeatScheduler
from live.show.score.improviser import ImprovisedMotion
from live.show.score.music_reactions import Mood, MusicSignals, Reactions, reaction_event
from live.show.score.playhead import END, Playhead, When
from live.show.score.score import Score, section_timings

AHEAD_EVENTS: Final = (events.CallStep, events.SetSequence, events.Improvise)
"""Calls that must be known before their measure begins: those at its line are sent ahead of it."""
AHEAD_BEATS: Final = 2.0
"""Lead time of these calls [beats]: a little before the measure is planned."""
CURVE_PARTS: Final = 4
"""Values of a curve that are told in each beat."""
AHEAD_SOURCE: Final = "score ahead"
"""Source of these calls."""
SCORE_EVENTS: Final = (events.JumpTo, events.Advance, events.HoldScore, events.Practice, events.Signal)
"""Events that `handle` handles."""


def _call_event(at: AtSection, time: float) -> object:
    """Return the event of an `[[at]]`: a ControlEvent, if its call was checked."""
    if at.signal is not None:
        return events.Signal(time=time, source="score", name=at.signal)
    return REGISTRY.call(*at.called, time, "score")


class ScoreRunner:
    """Position in the score of a show, and the events at its beats. Thread: the show's."""

    def __init__(self, patch: Patch, reactions: Reactions, *, seed: int) -> None:
        """`reactions` receive the signals."""
        self.playhead = Playhead(section_timings(patch))
        self.score = Score(patch, self.playhead)
        self.beat_scheduler = BeatScheduler()
        """Events that wait for their danced beat, from the score or other sources."""
        self.mood = Mood()
        """Music features for improvisation."""
        self.signals: Counter[str] = Counter()
        """Count of each signal, by name."""
        self.last_signal = ""
        self._sent_ahead: list[AtSection] = []  # calls of the next measure that were sent ahead of it
        self._reactions = reactions
        self._music_signals = MusicSignals(patch.signal)
        self._motion = ImprovisedMotion(patch.improvise, self.score, seed)
        self._known_signals = {"drop", "build", *(one.name.casefold() for one in patch.signal)}
        self._known_signals |= {one.name.casefold() for one in patch.gesture}
        self._known_signals |= {one.signal.casefold() for one in patch.at if one.signal is not None}
        self._known_signals |= {one.on.casefold() for one in patch.react if one.on is not None}
        self.late_jumps = 0
        """Jumps requested after the steps of their first measure were already chosen."""
        self.late_message = ""
        """Message about the last jump that came too late; kept until the next one."""
        self.late_message_measure = 0
        """Measure of the show, from 1, of that message."""
        self._beats = patch.clock.beats_per_measure
        self._names = {stretch.name.casefold(): i for i, stretch in enumerate(self.playhead.sections)}

    def add_signal(self, name: str) -> None:
        """Let a signal of this name be given from now on, because its gesture was learned."""
        self._known_signals.add(name.casefold().strip())

    def apply_patch(self, fresh: "ScoreRunner") -> None:
        """Adopt the sections and signals of an edited score; waiting events still fire."""
        self._names, self._known_signals = fresh._names, fresh._known_signals

    def begin_measure(self, measure: int, time: float) -> None:
        """Begin `measure` (from 0) at `time` [s]: schedule the score's events for their beats."""
        self.playhead.begin_measure(measure)
        line = measure * self._beats
        given, self._sent_ahead = self._sent_ahead, []
        for call in self.score.calls(measure):
            event = _call_event(call, time)
            if isinstance(event, ControlEvent) and call not in given:
                self.beat_scheduler.schedule(line + call.beat - 1.0, event)
        self._look_ahead(measure + 1, time)
        for event in self._motion.calls(measure, time):
            self.beat_scheduler.schedule(line, event)
        for curve, since in self.score.curves(measure):
            for part in range(self._beats * CURVE_PARTS):
                value = curve.value_at(since + part / (self._beats * CURVE_PARTS))
                if value is not None:
                    moved = events.CurveMoved(time=time, source="score", name=curve.name, value=value)
                    self.beat_scheduler.schedule(line + part / CURVE_PARTS, moved)
        for signal in self.score.signals(measure):
            self.beat_scheduler.schedule(
                line + signal.beat - 1.0, events.Signal(time=time, source="score", name=signal.name)
            )

    def _look_ahead(self, measure: int, time: float) -> None:
        """Schedule the step calls at the line of the next `measure` before that measure is planned."""
        for call in self.score.calls(measure):
            event = _call_event(call, time)
            if call.beat == 1.0 and isinstance(event, AHEAD_EVENTS):
                self._sent_ahead.append(call)
                self.beat_scheduler.schedule(measure * self._beats - AHEAD_BEATS, replace(event, source=AHEAD_SOURCE))

    def handle(self, event: ControlEvent) -> bool:
        """Handle an event of `SCORE_EVENTS`; return whether the next measure changed. Raises PersonError for a
        missing place."""
        coming = self.playhead.measure + 1
        before = self.playhead.place(coming), self.playhead.entered(coming)
        try:
            match event:
                case events.JumpTo():
                    self.playhead.jump(self.section_index(event.section), event.measure - 1, _parse_when(event.when))
                case events.Advance():
                    self.playhead.advance(_parse_when(event.when))
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
            self.beat_scheduler.remove(AHEAD_SOURCE, -math.inf)
            self._sent_ahead.clear()
            self._look_ahead(coming, event.time)
        return moved

    def handle_music(self, event: events.MusicHeard) -> list[events.Signal]:
        """Update the mood by one beat of the music, and return the signals it triggers."""
        self.mood.update(event)
        names = self._music_signals.detect(event)
        return [events.Signal(time=event.time, source="music", name=name) for name in names]

    @property
    def drops(self) -> int:
        """Drops of the music heard so far."""
        return self._reactions.drops

    def handle_curve(self, event: events.CurveMoved) -> list[events.Signal]:
        """Return the signals that a curve gives."""
        names = self._music_signals.detect_curve(event)
        return [events.Signal(time=event.time, source="score", name=name) for name in names]

    def handle_notes(self, event: events.NotesHeard) -> None:
        """Update the mood by notes played over MIDI."""
        self.mood.update_notes(event)

    def _signal(self, event: events.Signal) -> None:
        """Pass a signal to the reactions. Raises PersonError for an unknown name."""
        name = event.name.casefold().strip()
        if name not in self._known_signals:
            raise PersonError(
                f"no signal is called {event.name!r}", f"there are: {', '.join(sorted(self._known_signals))}"
            )
        self.signals[name] += 1
        self.last_signal = name
        self._reactions.handle_signal(name)

    def schedule_reactions(self, danced_beats: float, time: float) -> None:
        """Schedule the calls due before the next line, at once or at their beat; the danced beat is `danced_beats`."""
        for section in self._reactions.pending_calls:
            event = reaction_event(section, time)
            if isinstance(event, ControlEvent):
                self.beat_scheduler.schedule(
                    danced_beats if section.when == "now" else math.ceil(danced_beats - 1e-9), event
                )
        self._reactions.pending_calls.clear()

    def suppress(self, on: bool) -> None:
        """Suppress waiting events and calls from reactions, or allow them again."""
        self._reactions.suppressed = on
        if on:
            self.beat_scheduler.clear()
            self._reactions.clear_calls()

    def record_late_jump(self) -> None:
        """Record a jump that changed the next measure after its steps were chosen; those steps are danced."""
        self.late_jumps += 1
        self.late_message = "the steps of the first measure were decided already: the old ones are danced"
        self.late_message_measure = self.playhead.measure + 1

    def section_index(self, name: str) -> int:
        """Return the index of a section; raises PersonError for an unknown name."""
        index = self._names.get(name.casefold().strip())
        if index is None:
            known = ", ".join(stretch.name for stretch in self.playhead.sections if stretch.name)
            raise PersonError(
                f"no section is called {name!r}", f"there are: {known}" if known else "the patch has none"
            )
        return index

    def status_lines(self) -> tuple[str, ...]:
        """Return the overlay's line on the score; none for a single section without requests."""
        playhead = self.playhead
        place = playhead.place(playhead.measure)
        if place.section == END:
            return () if place.measure < 0 else ("score: over",)
        stretch = playhead.sections[place.section]
        asked = [
            "held" if playhead.held else "",
            "waits for GO" if playhead.waiting else "",
            "practice" if playhead.practice is not None else "",
            ""
            if playhead.pending_jump is None or playhead.pending_jump[0] == END
            else "goes to " + self._jump_text(playhead.pending_jump),
            self.late_message
            if playhead.measure <= self.late_message_measure
            else "",  # shown for that measure and the next
        ]
        told = [word for word in asked if word]
        if not stretch.name and not told:
            return ()
        of = "" if stretch.measures is None else f" of {stretch.measures}"
        again = f", pass {playhead.passes} of {stretch.repeat}" if stretch.repeat > 1 else ""
        line = f"{stretch.name or 'score'}: measure {place.measure + 1}{of}{again}"
        return (", ".join([line, *told]),)

    def _jump_text(self, jump: tuple[int, int, When]) -> str:
        section, measure, when = jump
        name = self.playhead.sections[section].name or "score"
        return name + (f" {measure + 1}" if measure else "") + (" at the section's end" if when == "section" else "")

    def facts(self) -> dict[str, Any]:
        """Return the position in the score for the status; measures and turns count from 1."""
        playhead = self.playhead
        place = playhead.place(playhead.measure)
        over = place.section == END
        going = playhead.pending_jump
        return {
            "section": None if over else playhead.sections[place.section].name,
            "section_measure": None if over else place.measure + 1,
            "section_turn": None if over else place.turn + 1,
            "score": {
                "measure": None if over else playhead.written_measure(place) + 1,
                "measures": None if over else playhead.sections[place.section].measures,
                "pass": playhead.passes,
                "waiting": playhead.waiting,
                "held": playhead.held,
                "going": None if going is None or going[0] == END else playhead.sections[going[0]].name,
                "practice": None if playhead.practice is None else [playhead.practice[0] + 1, playhead.practice[1] + 1],
                "late_jumps": self.late_jumps,
                "said": self.late_message,
                "said_measure": self.late_message_measure or None,
                "signals": dict(self.signals),
                "last_signal": self.last_signal,
            },
        }


def _parse_when(word: str) -> When:
    match word:
        case "measure" | "section":
            return word
    raise PersonError(f"when {word!r} is unknown", "there are: measure, section")
