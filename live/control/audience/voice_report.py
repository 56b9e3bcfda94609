"""What one gateway tells of its phones: the sketch of their voices, the voices that are highlighted, and votes.

Highlights rotate: a few voices at a time are visible on the projector, and each voice gets a turn.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.control.audience.participant_state import Voices
from live.control.audience.phone_registry import MOST_NUMBER, hue_of
from live.control.audience.voice_sketch import MAX_HALF, MODES, UNIT, VoiceSketch
from live.control.events.audience import VoiceLight

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


LIGHTS_EVERY: Final = 0.1
"""Interval of highlight updates [s]; the picture interpolates between them."""
CHOICE_EVERY: Final = 0.25
VOTES_EVERY: Final = 0.2
MAX_WAIT_TIMES: Final = 16384
"""Number of messages whose waiting time is recorded."""


@dataclass(frozen=True, slots=True)
class VoiceReport:
    """What one gateway, or several together, tell of their phones."""

    order: int
    """Number of operator commands that were applied."""
    phones: int
    speaking: int
    """Number of phones that speak."""
    sketch: VoiceSketch
    lights: tuple[VoiceLight, ...] = ()
    votes: tuple[int, ...] = ()
    """Number of the vote, then the weight of the votes for each choice in `UNIT`; empty: there is no vote."""

    @property
    def tally(self) -> tuple[int, ...]:
        """The votes in hundredths."""
        return self.votes[:1] + tuple(round(100 * weight / UNIT) for weight in self.votes[1:])


def is_light(row: VoiceLight) -> bool:
    """Whether a light that came from another process can be one: of a phone, somewhere on a stage [cm]."""
    number, x, z, hue, mode = row
    farthest = 100.0 * MAX_HALF + 5.0
    there = 0 < number < MOST_NUMBER and abs(x) <= farthest and abs(z) <= farthest
    return there and 0 <= hue < 1000 and mode in MODES


class VoiceReporter:
    """Makes the reports of one gateway. Thread: one."""

    def __init__(self, voices: Voices, visible: int) -> None:
        """`visible`: most highlights at a time."""
        self._voices = voices
        self.highlights = HighlightRotation(visible)
        self._next_lights = self._next_choice = self._next_votes = 0.0
        self._order = 0
        self._lights: tuple[VoiceLight, ...] = ()
        self._votes: tuple[int, ...] = ()
        self._waits = np.zeros(MAX_WAIT_TIMES)
        self._wait_count = 0
        self._reported_at = -np.inf

    def report(
        self, now: float, order: int, phones: int, is_open: bool, votes: Callable[[], tuple[int, ...]]
    ) -> VoiceReport:
        """Return the report at `now` [s]; `votes` counts the votes."""
        voices = self._voices
        if order != self._order:  # an operator's command acts at once
            self._order, self._next_lights, self._next_votes = order, now, now
        weight = voices.weights(now) if is_open else np.zeros(len(voices.number))
        rows = np.flatnonzero(weight)
        sketch = voices.sketch(now, weight) if is_open else voices.silence()
        if now >= self._next_lights:
            self._next_lights = now + LIGHTS_EVERY
            if now >= self._next_choice:
                self._next_choice = now + CHOICE_EVERY
                self.highlights.update(rows.tolist(), now)
            else:
                self.highlights.prune(lambda row: bool(weight[row]))
            self._lights = self._highlight_rows()
        if now >= self._next_votes:
            self._next_votes = now + VOTES_EVERY
            self._votes = votes()
        self._record_waits(now, rows)
        return VoiceReport(order, phones, len(rows), sketch, self._lights, self._votes)

    def _highlight_rows(self) -> tuple[VoiceLight, ...]:
        """Return the highlights, positions in steps of 5 cm."""
        voices, rows = self._voices, []
        for row in self.highlights.rows:
            number = int(voices.number[row])
            x, z = (round(float(value) * 20) * 5 for value in (voices.x[row], voices.z[row]))
            rows.append((number, x, z, hue_of(number), int(voices.mode[row])))
        return tuple(rows)

    def _record_waits(self, now: float, rows: npt.NDArray[np.intp]) -> None:
        """Record how long messages waited that were received since the last report."""
        said = self._voices.message_time[rows]
        waited = now - said[said > self._reported_at]
        self._reported_at = now
        for begin in range(0, len(waited), MAX_WAIT_TIMES):
            part = waited[begin : begin + MAX_WAIT_TIMES]
            self._waits[(self._wait_count + np.arange(len(part))) % MAX_WAIT_TIMES] = part
            self._wait_count += len(part)

    def wait_times(self) -> list[float]:
        """Return the waiting time of recent messages until the report: median and 99th percentile [ms]."""
        known = self._waits[: min(self._wait_count, MAX_WAIT_TIMES)]
        return (
            [round(1000.0 * float(value), 2) for value in np.percentile(known, (50, 99))] if len(known) else [0.0] * 2
        )
