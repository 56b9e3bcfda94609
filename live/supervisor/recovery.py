"""Recovery: a show goes on after an engine has died, without what killed it (crash-only software, Candea & Fox 2003).

What was applied in the tick that died is tried once more. If the tick dies again, its events are left out
(quarantine); if it dies without them, or had none, the stage it died in is put out of service (`live/show/breakers`).
Whoever follows, and a replay, is told by lines of the journal, so that all come to the same state.
"""

import contextlib
import json
from collections import Counter
from dataclasses import dataclass
from typing import Final

from live.clock.ticks import TICK
from live.control.events.system import BreakerTripped, ResetBreaker
from live.show.circuit_breakers import Stage, escalation, out_of_service
from live.show.journal.journal import line_of
from live.show.journal.skipped_events import SINCE, left_out_line
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.state.snapshot import SnapshotError, Snapshots, restore
from live.supervisor.state_follower import Following, Line, TickFailed, is_event

ATTEMPTS: Final = 32
"""So often at most a show is run on from where it stood: each time something more is left out."""
TRANSIENT: Final = 2
"""A tick that another engine ran well is tried so often again before its stage is to blame."""
RESET: Final = ResetBreaker.__name__
SOURCE: Final = "supervisor"


@dataclass(frozen=True, slots=True)
class Death:
    """How the engine before this one ended."""

    tick: int = 0
    """The tick that ran, if `stage` is one; else the last that was told."""
    stage: int = int(Stage.OUTSIDE)
    """The stage that ran."""
    times: int = 1
    """So many engines in a row ended there."""
    trip: bool = False
    """Whether that stage has ended so many engines, in whatever ticks, that it is put out of service."""

    @classmethod
    def of(cls, told: object) -> "Death":
        """From what the supervisor says; what makes no sense is taken as nothing known."""
        if not isinstance(told, dict):
            return cls()
        tick, stage, times = (told.get(key) for key in ("tick", "stage", "times"))
        if not (isinstance(tick, int) and isinstance(stage, int) and isinstance(times, int)):
            return cls()
        return cls(tick, stage, times, trip=bool(told.get("trip")))


@dataclass(frozen=True, slots=True)
class Recovered:
    """A show that can go on."""

    show: Show
    lines: tuple[str, ...] = ()
    """What belongs into the journal before anything else: who is left out, what is out of service, measures."""
    notes: tuple[str, ...] = ()
    """The same in a person's words."""


class Recovery:
    """Runs what one show was told until it stands where the engine that died stood. Thread: one."""

    def __init__(self, following: Following, death: Death | None = None) -> None:
        """`following` stands at a measure line, or nothing of it is run yet."""
        self._following, self._death = following, death or Death()
        self._told = following.waiting
        self._start = self._stands()
        self._lines: list[str] = []
        self._notes: list[str] = []
        self._trips: Counter[int] = Counter()
        self._quarantined: set[int] = set()
        self._failures: Counter[int] = Counter()
        self._last = max((value["tick"] for value in self._told if len(value) > 1), default=following.tick)
        told = max((value["tick"] for value in self._told), default=following.tick)
        self._dies_at = self._death.tick if self._death.stage else 0
        self._until = max(told, self._dies_at)  # later ticks are the next engine's own
        self._passed = min(told, self._until - 1) if self._dies_at else told
        self._anew = False  # whether what was danced since the last snapshot is danced anew
        self._refused: list[Line] = []
        self._own: list[Line] = []  # what this recovery has put among what was told

    def run(self) -> Recovered:
        """The show, without what made it end; TickFailed if nothing has helped."""
        following = self._following
        self._foresee(self._death)
        for _ in range(ATTEMPTS):
            before = following.crossed
            try:
                following.run(self._told, self._until)
            except TickFailed as failed:
                self._judge(failed)
                self._begin_again()
                continue
            assert following.show is not None
            self._note_measure(following.show, before)
            lines = sorted(self._lines, key=lambda line: int(json.loads(line)["tick"]))
            return Recovered(following.show, tuple(lines), tuple(self._notes))
        raise TickFailed(following.tick, int(Stage.TICK), RuntimeError("nothing has helped"))

    # -- where it begins -----------------------------------------------------------------------------------------

    def _stands(self) -> tuple[LoadedShow, bytes, int] | None:
        """What brings the show back to where it stands; None where it is run from the last snapshot that was told."""
        following = self._following
        if following.show is None:
            return None
        with contextlib.suppress(SnapshotError):
            taken = Snapshots(following.show).take(following.tick)
            if taken is not None:
                return following.loaded, taken.seal(), following.tick
        self._told = following.whole()
        following.stand(None, 0)
        return None

    def _begin_again(self) -> None:
        if self._start is None:
            self._following.stand(None, 0)
            return
        loaded, data, tick = self._start
        self._following.stand(restore(loaded, data), tick)

    # -- what is left out ----------------------------------------------------------------------------------------

    def _foresee(self, death: Death) -> None:
        """Leave out at once what has ended engines that told no error: they were killed, or hung."""
        if not death.stage:
            return
        trips = death.times - 1
        if trips and self._quarantine(death.tick, f"{death.times} engines ended with it"):
            trips -= 1
        for _ in range(max(trips, int(death.trip))):
            self._trip(death.tick, death.stage, "engines ended in it again and again")

    def _judge(self, failed: TickFailed) -> None:
        """A tick ended in an error here, too: what is done about it before it is run again."""
        tick = failed.tick
        self._failures[tick] += 1
        if tick <= self._passed:  # the engine that died had run it well: it may be chance
            if self._failures[tick] > TRANSIENT:
                self._trip_before(failed)
        elif (tick == self._dies_at or self._failures[tick] > 1) and not self._quarantine(tick, failed.why):
            self._trip(tick, failed.stage, failed.why)

    def _quarantine(self, tick: int, why: str) -> bool:
        """Leave out what was applied for that tick; False if that is nothing, or done already."""
        events = [value for value in self._told if value["tick"] == tick - 1 and is_event(value)]
        if not events or tick in self._quarantined:
            return False
        self._quarantined.add(tick)
        self._refused += events
        self._told = [value for value in self._told if not any(value is one for one in events)]
        self._put(left_out_line(tick - 1, len(events)) | {"why": why})
        kinds = ", ".join(sorted({_kind(value) for value in events}))
        self._notes.append(f"{kinds} ended the engine twice and is refused ({why})")
        return True

    def _trip(self, tick: int, stage: int, why: str) -> None:
        """Put a stage out of service for that tick and all after it."""
        line = json.loads(line_of(tick - 1, self._tripped(stage, why, tick - 1)))
        self._insert(line)
        self._put(line)
        self._own.append(line)

    def _insert(self, line: Line) -> None:
        """Let it come after all that was told for its tick, or before; a line for a later tick may have been
        foreseen."""
        tick = line["tick"]
        place = 1 + max((at for at, value in enumerate(self._told) if value["tick"] <= tick), default=-1)
        self._told.insert(place, line)

    def _trip_before(self, failed: TickFailed) -> None:
        """Put a stage out of service from the last snapshot on, or from a later reset: what was danced after that
        is danced anew, for nothing that was danced in this stage can be run here."""
        if not self._anew:
            self._start, self._anew = None, True
            self._told = [value for value in self._following.whole() if value not in self._refused]
            for line in self._own:  # they are in the journal
                self._insert(line)
        since = self._told[0]["tick"] if "snapshot" in self._told[0] else 0
        resets = [value["tick"] for value in self._told if value["tick"] < failed.tick and _kind(value) == RESET]
        since = max(since, *resets) if resets else since  # one that was put back since would be back at once
        event = json.loads(line_of(since, self._tripped(failed.stage, failed.why, since)))
        self._insert(event)
        self._put({**event, "tick": max(value["tick"] for value in self._told), SINCE: since})

    def _tripped(self, stage: int, why: str, tick: int) -> BreakerTripped:
        show, names = self._following.show, escalation(stage)
        tripped = self._trips[stage] if show is None else max(self._trips[stage], show.breakers.tripped(stage))
        name = names[min(tripped, len(names) - 1)]
        self._trips[stage] += 1
        self._notes.append(out_of_service(name, why))
        return BreakerTripped(time=tick * TICK, source=SOURCE, name=name, why=why)

    def _note_measure(self, show: Show, before: tuple[int, str]) -> None:
        """A measure that began beyond the last line that was told is noted, as an engine would have."""
        tick, state = self._following.crossed
        if (tick, state) != before and tick > self._last:
            self._put({"tick": tick, "measure": show.span.number + 1, "hash": state})

    def _put(self, line: Line) -> None:
        self._lines.append(json.dumps(line, separators=(",", ":")))


def _kind(value: Line) -> str:
    event = value.get("event")
    if isinstance(event, list):
        return str(event[0]) if event else ""
    return str(event.get("type", "")) if isinstance(event, dict) else ""
