"""Recovery of a show after an engine has died, without the event or stage that killed it.

This is crash-only software (Candea & Fox 2003). The events applied in the failed tick are tried once more. If the tick
fails again, they are left out (quarantine). If it fails without them, or had none, the stage it failed in is put out of
service (`live/show/breakers`). Journal lines record this, so that followers and replays reach the same state.
"""

import contextlib
import json
from collections import Counter
from dataclasses import dataclass
from typing import Final

from live.clock.ticks import TICK
from live.control.events.system import BreakerTripped, ResetBreaker
from live.show.circuit_breakers import Stage, describe_tripped, escalation
from live.show.journal.journal import event_line
from live.show.journal.skipped_events import SINCE_KEY, gap_line
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.state.snapshot import SnapshotError, Snapshotter, restore
from live.supervisor.state_follower import Line, StateFollower, TickFailed, is_event

ATTEMPTS: Final = 32
"""Most attempts to run the show from where it stood; each time something more is left out."""
MAX_RETRIES: Final = 2
"""Retries of a tick that another engine ran well, before its stage is blamed."""
RESET: Final = ResetBreaker.__name__
SOURCE: Final = "supervisor"


@dataclass(frozen=True, slots=True)
class Death:
    """How the engine before this one ended."""

    tick: int = 0
    """The tick that ran if `stage` is set, else the last one received."""
    stage: int = int(Stage.OUTSIDE)
    """The stage that ran."""
    times: int = 1
    """Number of engines in a row that ended there."""
    trip: bool = False
    """Whether that stage has ended so many engines, in any tick, that it is put out of service."""

    @classmethod
    def from_message(cls, value: object) -> "Death":
        """Read it from the supervisor's message; invalid values count as unknown."""
        if not isinstance(value, dict):
            return cls()
        tick, stage, times = (value.get(key) for key in ("tick", "stage", "times"))
        if not (isinstance(tick, int) and isinstance(stage, int) and isinstance(times, int)):
            return cls()
        return cls(tick, stage, times, trip=bool(value.get("trip")))


@dataclass(frozen=True, slots=True)
class RecoveredShow:
    """A show that can resume."""

    show: Show
    lines: tuple[str, ...] = ()
    """Lines to write into the journal first: events left out, stages out of service, measures."""
    notes: tuple[str, ...] = ()
    """The same as notes for the person."""


class Recovery:
    """Runs the received lines until the show stands where the dead engine stood. Thread: one."""

    def __init__(self, follower: StateFollower, death: Death | None = None) -> None:
        """`follower` stands at a measure line, or has run nothing yet."""
        self._follower, self._death = follower, death or Death()
        self._received = follower.pending
        self._start = self._starting_state()
        self._lines: list[str] = []
        self._notes: list[str] = []
        self._trips: Counter[int] = Counter()
        self._quarantined: set[int] = set()
        self._failures: Counter[int] = Counter()
        self._last = max((value["tick"] for value in self._received if len(value) > 1), default=follower.tick)
        told = max((value["tick"] for value in self._received), default=follower.tick)
        self._fatal_tick = self._death.tick if self._death.stage else 0
        self._until = max(told, self._fatal_tick)  # later ticks belong to the next engine
        self._last_good_tick = min(told, self._until - 1) if self._fatal_tick else told
        self._rerun = False  # whether everything since the last snapshot is rerun
        self._refused: list[Line] = []
        self._inserted: list[Line] = []  # lines that this recovery has inserted

    def run(self) -> RecoveredShow:
        """Return the show without the cause of the failure; TickFailed if no attempt has helped."""
        following = self._follower
        self._apply_death(self._death)
        for _ in range(ATTEMPTS):
            before = following.last_measure
            try:
                following.run(self._received, self._until)
            except TickFailed as failed:
                self._handle_failure(failed)
                self._begin_again()
                continue
            assert following.show is not None
            self._record_measure(following.show, before)
            lines = sorted(self._lines, key=lambda line: int(json.loads(line)["tick"]))
            return RecoveredShow(following.show, tuple(lines), tuple(self._notes))
        raise TickFailed(following.tick, int(Stage.TICK), RuntimeError("nothing has helped"))

    # -- where it begins -----------------------------------------------------------------------------------------

    def _starting_state(self) -> tuple[LoadedShow, bytes, int] | None:
        """Return the state to restart from; None if the show is rerun from the last received snapshot."""
        following = self._follower
        if following.show is None:
            return None
        with contextlib.suppress(SnapshotError):
            taken = Snapshotter(following.show).capture(following.tick)
            if taken is not None:
                return following.loaded, taken.seal(), following.tick
        self._received = following.lines_from_snapshot()
        following.reset_to(None, 0)
        return None

    def _begin_again(self) -> None:
        if self._start is None:
            self._follower.reset_to(None, 0)
            return
        loaded, data, tick = self._start
        self._follower.reset_to(restore(loaded, data), tick)

    # -- what is left out ----------------------------------------------------------------------------------------

    def _apply_death(self, death: Death) -> None:
        """Leave out at once what has ended engines without an error message: they were killed or hung."""
        if not death.stage:
            return
        trips = death.times - 1
        if trips and self._quarantine(death.tick, f"{death.times} engines ended with it"):
            trips -= 1
        for _ in range(max(trips, int(death.trip))):
            self._trip(death.tick, death.stage, "engines ended in it again and again")

    def _handle_failure(self, failed: TickFailed) -> None:
        """Decide what to leave out after a tick has failed here, too."""
        tick = failed.tick
        self._failures[tick] += 1
        if tick <= self._last_good_tick:  # the dead engine had run it without error: it may be chance
            if self._failures[tick] > MAX_RETRIES:
                self._trip_before(failed)
        elif (tick == self._fatal_tick or self._failures[tick] > 1) and not self._quarantine(tick, failed.why):
            self._trip(tick, failed.stage, failed.why)

    def _quarantine(self, tick: int, why: str) -> bool:
        """Leave out the events applied for that tick; False if there are none or it is already done."""
        events = [value for value in self._received if value["tick"] == tick - 1 and is_event(value)]
        if not events or tick in self._quarantined:
            return False
        self._quarantined.add(tick)
        self._refused += events
        self._received = [value for value in self._received if not any(value is one for one in events)]
        self._add_journal_line(gap_line(tick - 1, len(events)) | {"why": why})
        kinds = ", ".join(sorted({_kind(value) for value in events}))
        self._notes.append(f"{kinds} ended the engine twice and is refused ({why})")
        return True

    def _trip(self, tick: int, stage: int, why: str) -> None:
        """Put a stage out of service for that tick and all after it."""
        line = json.loads(event_line(tick - 1, self._tripped(stage, why, tick - 1)))
        self._insert(line)
        self._add_journal_line(line)
        self._inserted.append(line)

    def _insert(self, line: Line) -> None:
        """Insert a line after all others up to its tick; lines of later ticks may already have been inserted."""
        tick = line["tick"]
        place = 1 + max((at for at, value in enumerate(self._received) if value["tick"] <= tick), default=-1)
        self._received.insert(place, line)

    def _trip_before(self, failed: TickFailed) -> None:
        """Put a stage out of service from the last snapshot or a later reset on, and rerun everything since, because
        this stage cannot be run here."""
        if not self._rerun:
            self._start, self._rerun = None, True
            self._received = [value for value in self._follower.lines_from_snapshot() if value not in self._refused]
            for line in self._inserted:  # they are in the journal
                self._insert(line)
        since = self._received[0]["tick"] if "snapshot" in self._received[0] else 0
        resets = [value["tick"] for value in self._received if value["tick"] < failed.tick and _kind(value) == RESET]
        since = max(since, *resets) if resets else since  # a reset would put the stage back into service at once
        event = json.loads(event_line(since, self._tripped(failed.stage, failed.why, since)))
        self._insert(event)
        self._add_journal_line({**event, "tick": max(value["tick"] for value in self._received), SINCE_KEY: since})

    def _tripped(self, stage: int, why: str, tick: int) -> BreakerTripped:
        show, names = self._follower.show, escalation(stage)
        tripped = self._trips[stage] if show is None else max(self._trips[stage], show.breakers.trip_count(stage))
        name = names[min(tripped, len(names) - 1)]
        self._trips[stage] += 1
        self._notes.append(describe_tripped(name, why))
        return BreakerTripped(time=tick * TICK, source=SOURCE, name=name, why=why)

    def _record_measure(self, show: Show, before: tuple[int, str]) -> None:
        """Record a measure that began after the last received line, as an engine would have."""
        tick, state = self._follower.last_measure
        if (tick, state) != before and tick > self._last:
            self._add_journal_line({"tick": tick, "measure": show.span.number + 1, "hash": state})

    def _add_journal_line(self, line: Line) -> None:
        self._lines.append(json.dumps(line, separators=(",", ":")))


def _kind(value: Line) -> str:
    event = value.get("event")
    if isinstance(event, list):
        return str(event[0]) if event else ""
    return str(event.get("type", "")) if isinstance(event, dict) else ""
