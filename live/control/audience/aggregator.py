"""Events for the show from the reports of gateways: at most one per tick, and only when something changed."""

from typing import Any, Final, TypeVar

from live.control.audience.voice_report import VoiceReport
from live.control.audience.voice_sketch import PLACES, Force
from live.control.events.audience import VoicePlace

Rows = TypeVar("Rows", bound=tuple[Any, ...])

REPEAT_INTERVAL: Final = 0.5
"""Unchanged state is repeated at this interval [s], because the show's elements end by themselves."""
MIN_MOVE_CM: Final = 2
"""Minimum movement of a place [cm]."""


class Aggregator:
    """Makes the events of one show. Thread: one."""

    def __init__(self) -> None:
        self._sent: tuple[Any, ...] = ()
        self._known: dict[str, tuple[Any, ...]] = {}
        self._places: dict[int, tuple[int, int, int, int]] = {}
        self._repeat_at = 0.0

    def update(self, now: float, report: VoiceReport) -> tuple[Any, ...] | None:
        """Return the fields of the event for the show at `now` [s]; None if nothing is new."""
        force = report.sketch.force()
        places = self._slots(force)
        if self._sent[1:2] != (report.order,):  # the show may have ignored data of an older order
            self._known = {}
        lights, tally = self._if_changed("lights", report.lights), self._if_changed("votes", report.tally or None)
        said = (report.phones, report.order, round(50 * force.share) * 20, places, round(20 * force.shaken) * 50)
        still = not places and not force.shaken  # no element is active that would end by itself
        if said == self._sent and (still or now < self._repeat_at) and lights is None and tally is None:
            return None
        self._sent, self._repeat_at = said, now + REPEAT_INTERVAL
        return ("heard", now, *said[:4], lights, tally, said[4])

    def _if_changed(self, what: str, rows: Rows | None) -> Rows | None:
        """Return `rows`, or None if the show has them already."""
        if rows is None or self._known.get(what) == rows:
            return None
        self._known[what] = rows
        return rows

    def resend(self) -> None:
        """Send everything again next time, because the show did not receive the last event."""
        self._sent, self._known = (), {}

    def _slots(self, force: Force) -> tuple[VoicePlace, ...]:
        """Return the places; each keeps its slot between calls, so that its element moves with it."""
        left, taken = dict(self._places), {}
        rows = [(round(p.x * 100), round(p.z * 100), round(p.weight * 50) * 20, p.mode) for p in force.places]
        waiting = []
        for row in rows:
            near = min(
                (slot for slot, old in left.items() if old[3] == row[3]),
                key=lambda slot: abs(left[slot][0] - row[0]) + abs(left[slot][1] - row[1]), default=None,
            )  # fmt: skip
            if near is None:
                waiting.append(row)
                continue
            old = left.pop(near)
            still = max(abs(old[0] - row[0]), abs(old[1] - row[1])) < MIN_MOVE_CM
            taken[near] = (old[0], old[1], row[2], row[3]) if still else row
        for row in waiting:
            taken[next(slot for slot in range(PLACES) if slot not in taken)] = row
        self._places = taken
        count = max(taken, default=-1) + 1
        return tuple(taken.get(slot, (0, 0, 0, 1)) for slot in range(count))
