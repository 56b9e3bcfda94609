"""Aggregate of all voices, sent to the show at most once per tick and only when it changed.

It also rotates highlights: a few voices at a time are visible on the projector, and each voice gets a turn.
"""

from collections import deque
from collections.abc import Callable
from typing import Any, Final, TypeVar

import numpy as np
import numpy.typing as npt

from live.control.audience.participant_state import PLACES, Force, Voices
from live.control.audience.phone_registry import hue_of
from live.control.events.audience import VoiceLight, VoicePlace

Rows = TypeVar("Rows", bound=tuple[Any, ...])

HIGHLIGHT_SECONDS: Final = 8.0
"""A highlight lasts this long [s] while others wait."""


class HighlightRotation:
    """Round robin of highlighted rows. Thread: one."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._since: dict[int, float] = {}
        self._waiting: deque[int] = deque()

    @property
    def rows(self) -> list[int]:
        """Highlighted rows, longest first."""
        return list(self._since)

    def prune(self, speaks: Callable[[int], bool]) -> None:
        """Remove highlights of rows that no longer speak."""
        for row in [row for row in self._since if not speaks(row)]:
            del self._since[row]

    def update(self, speaking: list[int], now: float) -> None:
        """Update the highlights from the rows that speak at `now` [s]; rows beyond the limit wait for a place."""
        there = set(speaking)
        self._since = {row: since for row, since in self._since.items() if row in there}
        self._waiting = deque(row for row in self._waiting if row in there)
        known = {*self._since, *self._waiting}
        self._waiting.extend(row for row in speaking if row not in known)
        for row, since in list(self._since.items()):
            waiting = len(self._waiting) - max(self.most - len(self._since), 0)
            if len(self._since) > self.most or (waiting > 0 and now - since > HIGHLIGHT_SECONDS):
                del self._since[row]
                self._waiting.append(row)
        while self._waiting and len(self._since) < self.most:
            self._since[self._waiting.popleft()] = now


REPEAT_INTERVAL: Final = 0.5
"""Unchanged state is repeated at this interval [s], because the show's elements end by themselves."""
LIGHTS_EVERY: Final = 0.1
"""Interval of highlight updates [s]; the picture interpolates between them."""
CHOICE_EVERY: Final = 0.25
VOTES_EVERY: Final = 0.2
MIN_MOVE_CM: Final = 2
"""Minimum movement of a place [cm]."""
MAX_WAIT_TIMES: Final = 16384
"""Number of messages whose waiting time is recorded."""


class Aggregator:
    """Aggregator of all voices. Thread: one."""

    def __init__(self, voices: Voices, visible: int) -> None:
        self._voices = voices
        self.highlights = HighlightRotation(visible)
        self.order = 0
        self._sent: tuple[Any, ...] = ()
        self._known: dict[str, tuple[Any, ...]] = {}
        self._places: dict[int, tuple[int, int, int, int]] = {}
        self._next_lights = self._next_choice = self._next_votes = self._repeat_at = 0.0
        self._waits = np.zeros(MAX_WAIT_TIMES)
        self._wait_count = 0
        self._updated_at = -np.inf

    def update(
        self, now: float, phones: int, is_open: bool, votes: Callable[[], tuple[int, ...]]
    ) -> tuple[Any, ...] | None:
        """Return the fields of the event for the show at `now` [s]; None if nothing is new."""
        voices = self._voices
        weight = voices.weights(now) if is_open else np.zeros(len(voices.number))
        rows = np.flatnonzero(weight)
        force = voices.force(now, weight) if len(rows) else Force(0.0, (), voices.shaken_share(now) if is_open else 0.0)
        places = self._slots(force)
        lights: tuple[VoiceLight, ...] | None = None
        if now >= self._next_lights:
            self._next_lights = now + LIGHTS_EVERY
            if now >= self._next_choice:
                self._next_choice = now + CHOICE_EVERY
                self.highlights.update(rows.tolist(), now)
            else:
                self.highlights.prune(lambda row: bool(weight[row]))
            lights = self._highlight_rows()
        tally: tuple[int, ...] | None = None
        if now >= self._next_votes:
            self._next_votes = now + VOTES_EVERY
            tally = votes() or None
        if self._sent[1:2] != (self.order,):  # the show may have ignored data of an older order
            self._known = {}
        lights, tally = self._if_changed("lights", lights), self._if_changed("votes", tally)
        said = (phones, self.order, round(50 * force.share) * 20, places, round(20 * force.shaken) * 50)
        still = not places and not force.shaken  # no element is active that would end by itself
        if said == self._sent and (still or now < self._repeat_at) and lights is None and tally is None:
            self._updated_at = now  # the messages received confirm the known state
            return None
        self._record_waits(now, rows)
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

    def _highlight_rows(self) -> tuple[VoiceLight, ...]:
        """Return the highlights, positions in steps of 5 cm."""
        voices, rows = self._voices, []
        for row in self.highlights.rows:
            number = int(voices.number[row])
            x, z = (round(float(value) * 20) * 5 for value in (voices.x[row], voices.z[row]))
            rows.append((number, x, z, hue_of(number), int(voices.mode[row])))
        return tuple(rows)

    def _record_waits(self, now: float, rows: npt.NDArray[np.intp]) -> None:
        """Record the waiting times of messages received since the show was last informed."""
        said = self._voices.message_time[rows]
        waited = now - said[said > self._updated_at]
        self._updated_at = now
        for begin in range(0, len(waited), MAX_WAIT_TIMES):
            part = waited[begin : begin + MAX_WAIT_TIMES]
            self._waits[(self._wait_count + np.arange(len(part))) % MAX_WAIT_TIMES] = part
            self._wait_count += len(part)

    def wait_times(self) -> list[float]:
        """Return the waiting time of recent messages until the show was informed: median and 99th percentile [ms]."""
        known = self._waits[: min(self._wait_count, MAX_WAIT_TIMES)]
        return (
            [round(1000.0 * float(value), 2) for value in np.percentile(known, (50, 99))] if len(known) else [0.0] * 2
        )
