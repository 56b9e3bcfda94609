"""Cue list: the standby cue, cues that count in, and the events of a cue at its beat.

Beats are danced beats: (measure + phase) times the beats of a measure, so a "this is the one" tap moves cues with the
measure line. A GO triggers a cue once; the show applies its events in the tick of its beat.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.patch.section_cues import CueSection
from live.show.score.playhead import END, Playhead

DEBOUNCE: Final = 0.25
"""A second GO of one source within this time [s] is ignored as a bounce."""
SOURCES: Final = 64
"""Maximum number of sources remembered for this; the oldest is dropped."""
MOST: Final = 16
"""Maximum number of cues that count in at the same time."""
AHEAD: Final = 512
"""Look-ahead for the start of the section that a cue waits for [measures]."""


@dataclass(frozen=True, slots=True)
class _Given:
    """A triggered cue whose beat has not come."""

    index: int
    due: float
    """Its danced beat."""
    earliest: float
    """Earliest danced beat, because of the count-in."""
    back: ControlEvent | None = None
    """If its jump is already requested: the event that reverts it."""


class Cues:
    """The cue list of one show. Thread: the show's."""

    def __init__(self, cues: Sequence[CueSection], playhead: Playhead, *, beats: int) -> None:
        """`beats`: beats per danced measure."""
        self._cues, self._playhead, self._beats = tuple(cues), playhead, beats
        self.standby = 0
        """Index of the cue that GO triggers; the number of cues means none."""
        self.last = -1
        """Index of the last fired cue, -1: none yet."""
        self.fired = self.bounced = 0
        """Fired cues, and GO presses ignored as bounces."""
        self._given: list[_Given] = []
        self.late_ticks_max = 0
        """Largest delay of a cue after the tick that contains its beat [ticks]."""
        self._before, self._tick = -math.inf, 1.0
        self._pressed: dict[str, float] = {}
        self._ways: tuple[object, ...] = ()

    def take_patch(self, fresh: "Cues") -> None:
        """Adopt the cues of an edited patch. The standby cue and counting cues are kept by name if they still exist."""
        cues = fresh._cues
        names = [cue.name for cue in cues]

        def moved(index: int, lost: int) -> int:
            name = self._cues[index].name if 0 <= index < len(self._cues) else None
            return names.index(name) if name in names else lost

        self.standby = moved(self.standby, min(self.standby, len(names)))
        self.last = moved(self.last, -1)
        self._given = [replace(one, index=new) for one in self._given if (new := moved(one.index, -1)) >= 0]
        self._cues = cues

    # -- commands ------------------------------------------------------------------------------------------------

    def go(self, event: events.Go, danced: float) -> list[ControlEvent]:
        """Trigger the standby cue; raises PersonError if there is none."""
        last = self._pressed.get(event.source, -math.inf)
        if 0.0 <= event.time - last < DEBOUNCE:
            self.bounced += 1
            return []
        self._pressed.pop(event.source, None)
        self._pressed[event.source] = event.time
        if len(self._pressed) > SOURCES:
            del self._pressed[next(iter(self._pressed))]
        if self.standby >= len(self._cues):
            raise PersonError("no cue stands by", "/dance/standby names one" if self._cues else "the patch has none")
        return self._give(self.standby, danced)

    def give(self, name: str, danced: float) -> list[ControlEvent]:
        """Trigger this cue and put the next one on standby; raises PersonError if there is no such cue."""
        return self._give(self._find(name), danced)

    def stand_by(self, name: str) -> None:
        """Put this cue on standby."""
        self.standby = self._find(name)

    def back(self) -> list[ControlEvent]:
        """Cancel the last triggered cue that has not fired; otherwise put the previous cue on standby."""
        if not self._given:
            if self.standby == 0:
                raise PersonError("the first cue stands by already")
            self.standby -= 1
            return []
        given = self._given.pop()
        self.standby = given.index
        return [] if given.back is None else [given.back]

    def stop(self) -> None:
        """Cancel all counting cues; the first of them is on standby again."""
        if self._given:
            self.standby = min(given.index for given in self._given)
        self._given.clear()

    def _find(self, name: str) -> int:
        folded = name.casefold().strip()
        for index, cue in enumerate(self._cues):
            if folded == cue.name.casefold().strip() or (cue.number is not None and folded == f"{cue.number:g}"):
                return index
        known = ", ".join(cue.name for cue in self._cues)
        raise PersonError(f"no cue is called {name!r}", f"there are: {known}" if known else "the patch has none")

    def _give(self, index: int, danced: float) -> list[ControlEvent]:
        if len(self._given) >= MOST:
            raise PersonError(f"{MOST} cues are counting in already")
        earliest = danced + self._cues[index].count_in
        self._given.append(_Given(index, self._due(self._cues[index], earliest), earliest))
        self.standby = index + 1
        return self._jumps(danced)

    # -- time ----------------------------------------------------------------------------------------------------

    def fire(self, danced: float, time: float) -> list[ControlEvent]:
        """Return the events of all cues due by the danced beat, in the order of their beats."""
        self._look()
        before, self._before = self._before, max(danced, self._before)
        if danced > before > -math.inf:
            self._tick = danced - before
        made: list[ControlEvent] = []
        due = sorted((given for given in self._given if given.due <= danced), key=lambda given: given.due)
        for given in due:
            late = math.ceil((before - given.due) / self._tick) if given.due < before else 0
            self.late_ticks_max = max(self.late_ticks_max, late)
            self._given.remove(given)
            made += self._happen(given, time)
        return made

    def begin_measure(self, danced: float) -> list[ControlEvent]:
        """Begin a measure: return the jumps of cues that fire at its end."""
        self._look()
        return self._jumps(danced)

    def _look(self) -> None:
        """Update the due beat of cues that wait for a section, whenever the future of the score may have changed."""
        playhead = self._playhead
        ways = (playhead.measure, playhead.going, playhead.practice, playhead.held, playhead.waiting)
        if not self._given or ways == self._ways:
            return
        self._ways = ways
        for number, given in enumerate(self._given):
            if self._cues[given.index].when == "section":
                self._given[number] = replace(given, due=self._due(self._cues[given.index], given.earliest))

    def let_go(self, danced: float) -> None:
        """Resume after a hold: a cue whose beat has passed fires at the next line or beat of its kind."""
        for number, given in enumerate(self._given):
            if given.due < danced:
                due = self._due(self._cues[given.index], danced)
                self._given[number] = replace(given, due=due)

    def _happen(self, given: _Given, time: float) -> list[ControlEvent]:
        cue = self._cues[given.index]
        source = f"cue {cue.name}"
        made = cue.events(time, source)
        if cue.section is not None and given.back is None:
            made.append(events.JumpTo(time=time, source=source, section=cue.section))
        self.last, self.fired = given.index, self.fired + 1
        if cue.then == "auto" and given.index + 1 < len(self._cues) and len(self._given) < MOST:
            due = given.due + (cue.after or 1) * self._beats
            self._given.append(_Given(given.index + 1, due, due))
            self.standby = max(self.standby, given.index + 2)
        return made

    def _due(self, cue: CueSection, earliest: float) -> float:
        """Return the danced beat at which a cue fires, not before `earliest`."""
        line = math.ceil(earliest / self._beats - 1e-9)
        match cue.when:
            case "now":
                return earliest
            case "beat":
                return math.ceil(earliest - 1e-9)
            case "measure":
                return float(self._beats * max(line, self._playhead.measure + 1))
        first = max(line, self._playhead.measure + 1)
        for measure in range(first, first + AHEAD):
            place = self._playhead.ahead(measure)
            if place.section != END and place.measure == 0 and self._playhead.entered(measure):
                return self._beats * measure
        return math.inf

    def _jumps(self, danced: float) -> list[ControlEvent]:
        """Return jumps of cues that fire at the next line now, so that the measure can be planned ahead."""
        made: list[ControlEvent] = []
        line = (self._playhead.measure + 1) * self._beats
        for number, given in enumerate(self._given):
            cue = self._cues[given.index]
            if cue.section is None or given.back is not None or given.due != line or danced > line:
                continue
            source = f"cue {cue.name}"
            place = self._playhead.ahead(self._playhead.measure + 1)
            if place.section == END:
                continue
            there = self._playhead.stretches[place.section].name
            back = events.JumpTo(time=0.0, source=source, section=there, measure=place.measure + 1)
            self._given[number] = replace(given, back=back)
            made.append(events.JumpTo(time=0.0, source=source, section=cue.section))
        return made

    # -- reports ---------------------------------------------------------------------------------------------------

    def count_in(self, danced: float) -> tuple[float, str] | None:
        """Return beats left and name of the next cue that counts in; None if there is none."""
        given = min(self._given, key=lambda given: given.due, default=None)
        return None if given is None else (given.due - danced, self._cues[given.index].name)

    def state(self) -> list[float]:
        """Return the numbers that belong to the state hash."""
        return [self.standby, self.last, *(number for given in self._given for number in (given.index, given.due))]

    @property
    def standby_name(self) -> str:
        """Name of the standby cue; empty if there is none."""
        return self._cues[self.standby].name if self.standby < len(self._cues) else ""

    def facts(self, danced: float) -> dict[str, Any]:
        """Return names, and remaining beats of counting cues, for the status (null: no section begins)."""

        def told(index: int) -> str | None:
            return self._cues[index].name if 0 <= index < len(self._cues) else None

        waiting = sorted(self._given, key=lambda given: given.due)
        return {
            "standby": told(self.standby),
            "text": self._cues[self.standby].text if self.standby < len(self._cues) else "",
            "next": told(self.standby + 1),
            "last": told(self.last),
            "counting_in": [
                {
                    "cue": told(given.index),
                    "beats": round(given.due - danced, 2) if math.isfinite(given.due) else None,
                }
                for given in waiting
            ],
            "fired": self.fired,
            "bounced": self.bounced,
            "late_ticks_max": self.late_ticks_max,
        }
