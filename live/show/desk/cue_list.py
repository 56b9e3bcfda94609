"""Cue list: the standby cue, cues that count in, and the events of a cue at its beat.

Beats are danced beats: (measure + phase) times the beats of a measure, so a "this is the one" tap moves cues with the
measure line. A GO triggers a cue once; the show applies its events in the tick of its beat.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.registry import REGISTRY
from live.show.patch.section_cues import CueSection
from live.show.score.playhead import END, Playhead

DEBOUNCE: Final = 0.25
"""A second GO of one source within this time [s] is ignored as a bounce."""
MAX_SOURCES: Final = 64
"""Maximum number of sources remembered for this; the oldest is dropped."""
MAX_COUNTING: Final = 16
"""Maximum number of cues that count in at the same time."""


@dataclass(frozen=True, slots=True)
class _TriggeredCue:
    """A triggered cue whose beat has not come."""

    index: int
    due: float
    """Its danced beat."""
    earliest: float
    """Earliest danced beat, because of the count-in."""
    revert_event: ControlEvent | None = None
    """If its jump is already requested: the event that reverts it."""


def _cue_events(cue: CueSection, time: float, source: str) -> list[ControlEvent]:
    """Return the events of a cue's scene and calls, in order."""
    made: list[object] = []
    if cue.scene is not None:
        fade = () if cue.measures is None else (cue.measures,)
        made.append(REGISTRY.call("/dance/scene", (cue.scene, *fade), time, source))
    made += [REGISTRY.call(str(call[0]), call[1:], time, source) for call in cue.calls]
    return [event for event in made if isinstance(event, ControlEvent)]


class CueList:
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
        self._triggered: list[_TriggeredCue] = []
        self.late_ticks_max = 0
        """Largest delay of a cue after the tick that contains its beat [ticks]."""
        self._last_beat, self._tick_beats = -math.inf, 1.0
        self._last_go: dict[str, float] = {}
        self._score_state: tuple[object, ...] = ()

    def edited_values(self, event: ControlEvent) -> dict[str, int]:
        """Return the standby cue, see `EditablePart`."""
        return {"standby": self.standby}

    def restore_values(self, values: Mapping[str, int]) -> None:
        """See `EditablePart`."""
        self.standby = values["standby"]

    def apply_patch(self, fresh: "CueList") -> None:
        """Adopt the cues of an edited patch. The standby cue and counting cues are kept by name if they still exist."""
        cues = fresh._cues
        names = [cue.name for cue in cues]

        def moved(index: int, lost: int) -> int:
            name = self._cues[index].name if 0 <= index < len(self._cues) else None
            return names.index(name) if name in names else lost

        self.standby = moved(self.standby, min(self.standby, len(names)))
        self.last = moved(self.last, -1)
        self._triggered = [replace(one, index=new) for one in self._triggered if (new := moved(one.index, -1)) >= 0]
        self._cues = cues

    # -- commands ------------------------------------------------------------------------------------------------

    def go(self, event: events.Go, danced_beats: float) -> list[ControlEvent]:
        """Trigger the standby cue; raises PersonError if there is none."""
        last = self._last_go.get(event.source, -math.inf)
        if 0.0 <= event.time - last < DEBOUNCE:
            self.bounced += 1
            return []
        self._last_go.pop(event.source, None)
        self._last_go[event.source] = event.time
        if len(self._last_go) > MAX_SOURCES:
            del self._last_go[next(iter(self._last_go))]
        if self.standby >= len(self._cues):
            raise PersonError("no cue stands by", "/dance/standby names one" if self._cues else "the patch has none")
        return self._trigger(self.standby, danced_beats)

    def trigger(self, name: str, danced_beats: float) -> list[ControlEvent]:
        """Trigger this cue and put the next one on standby; raises PersonError if there is no such cue."""
        return self._trigger(self._find(name), danced_beats)

    def stand_by(self, name: str) -> None:
        """Put this cue on standby."""
        self.standby = self._find(name)

    def step_back(self) -> list[ControlEvent]:
        """Cancel the last triggered cue that has not fired; otherwise put the previous cue on standby."""
        if not self._triggered:
            if self.standby == 0:
                raise PersonError("the first cue stands by already")
            self.standby -= 1
            return []
        given = self._triggered.pop()
        self.standby = given.index
        return [] if given.revert_event is None else [given.revert_event]

    def stop(self) -> None:
        """Cancel all counting cues; the first of them is on standby again."""
        if self._triggered:
            self.standby = min(given.index for given in self._triggered)
        self._triggered.clear()

    def _find(self, name: str) -> int:
        folded = name.casefold().strip()
        for index, cue in enumerate(self._cues):
            if folded == cue.name.casefold().strip() or (cue.number is not None and folded == f"{cue.number:g}"):
                return index
        known = ", ".join(cue.name for cue in self._cues)
        raise PersonError(f"no cue is called {name!r}", f"there are: {known}" if known else "the patch has none")

    def _trigger(self, index: int, danced_beats: float) -> list[ControlEvent]:
        if len(self._triggered) >= MAX_COUNTING:
            raise PersonError(f"{MAX_COUNTING} cues are counting in already")
        earliest = danced_beats + self._cues[index].count_in
        self._triggered.append(_TriggeredCue(index, self._due(self._cues[index], earliest), earliest))
        self.standby = index + 1
        return self._jumps(danced_beats)

    # -- time ----------------------------------------------------------------------------------------------------

    def fire(self, danced_beats: float, time: float) -> list[ControlEvent]:
        """Return the events of all cues due by the danced beat, in the order of their beats."""
        self._update_due_beats()
        before, self._last_beat = self._last_beat, max(danced_beats, self._last_beat)
        if danced_beats > before > -math.inf:
            self._tick_beats = danced_beats - before
        made: list[ControlEvent] = []
        due = sorted((given for given in self._triggered if given.due <= danced_beats), key=lambda given: given.due)
        for given in due:
            late = math.ceil((before - given.due) / self._tick_beats) if given.due < before else 0
            self.late_ticks_max = max(self.late_ticks_max, late)
            self._triggered.remove(given)
            made += self._fire_cue(given, time)
        return made

    def begin_measure(self, danced_beats: float) -> list[ControlEvent]:
        """Begin a measure: return the jumps of cues that fire at its end."""
        self._update_due_beats()
        return self._jumps(danced_beats)

    def _update_due_beats(self) -> None:
        """Update the due beat of cues that wait for a section, whenever the future of the score may have changed."""
        course = self._playhead.course
        if not self._triggered or course == self._score_state:
            return
        self._score_state = course
        for number, given in enumerate(self._triggered):
            if self._cues[given.index].when == "section":
                self._triggered[number] = replace(given, due=self._due(self._cues[given.index], given.earliest))

    def resume(self, danced_beats: float) -> None:
        """Resume after a hold: a cue whose beat has passed fires at the next line or beat of its kind."""
        for number, given in enumerate(self._triggered):
            if given.due < danced_beats:
                due = self._due(self._cues[given.index], danced_beats)
                self._triggered[number] = replace(given, due=due)

    def _fire_cue(self, triggered: _TriggeredCue, time: float) -> list[ControlEvent]:
        cue = self._cues[triggered.index]
        source = f"cue {cue.name}"
        made = _cue_events(cue, time, source)
        if cue.section is not None and triggered.revert_event is None:
            made.append(events.JumpTo(time=time, source=source, section=cue.section))
        self.last, self.fired = triggered.index, self.fired + 1
        if cue.then == "auto" and triggered.index + 1 < len(self._cues) and len(self._triggered) < MAX_COUNTING:
            due = triggered.due + (cue.after or 1) * self._beats
            self._triggered.append(_TriggeredCue(triggered.index + 1, due, due))
            self.standby = max(self.standby, triggered.index + 2)
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
        begin = self._playhead.next_begin(max(line, self._playhead.measure + 1))
        return math.inf if begin is None else self._beats * begin

    def _jumps(self, danced_beats: float) -> list[ControlEvent]:
        """Return jumps of cues that fire at the next line now, so that the measure can be planned ahead."""
        made: list[ControlEvent] = []
        line = (self._playhead.measure + 1) * self._beats
        for number, given in enumerate(self._triggered):
            cue = self._cues[given.index]
            if cue.section is None or given.revert_event is not None or given.due != line or danced_beats > line:
                continue
            source = f"cue {cue.name}"
            place = self._playhead.ahead(self._playhead.measure + 1)
            if place.section == END:
                continue
            there = self._playhead.sections[place.section].name
            back = events.JumpTo(time=0.0, source=source, section=there, measure=place.measure + 1)
            self._triggered[number] = replace(given, revert_event=back)
            made.append(events.JumpTo(time=0.0, source=source, section=cue.section))
        return made

    # -- reports ---------------------------------------------------------------------------------------------------

    def count_in(self, danced_beats: float) -> tuple[float, str] | None:
        """Return beats left and name of the next cue that counts in; None if there is none."""
        given = min(self._triggered, key=lambda given: given.due, default=None)
        return None if given is None else (given.due - danced_beats, self._cues[given.index].name)

    def state(self) -> list[float]:
        """Return the numbers that belong to the state hash."""
        return [self.standby, self.last, *(number for given in self._triggered for number in (given.index, given.due))]

    @property
    def standby_name(self) -> str:
        """Name of the standby cue; empty if there is none."""
        return self._cues[self.standby].name if self.standby < len(self._cues) else ""

    def facts(self, danced_beats: float) -> dict[str, Any]:
        """Return names, and remaining beats of counting cues, for the status (null: no section begins)."""

        def told(index: int) -> str | None:
            return self._cues[index].name if 0 <= index < len(self._cues) else None

        waiting = sorted(self._triggered, key=lambda given: given.due)
        return {
            "standby": told(self.standby),
            "text": self._cues[self.standby].text if self.standby < len(self._cues) else "",
            "next": told(self.standby + 1),
            "last": told(self.last),
            "counting_in": [
                {
                    "cue": told(given.index),
                    "beats": round(given.due - danced_beats, 2) if math.isfinite(given.due) else None,
                }
                for given in waiting
            ],
            "fired": self.fired,
            "bounced": self.bounced,
            "late_ticks_max": self.late_ticks_max,
        }
