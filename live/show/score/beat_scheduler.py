"""Scheduler for events that are due at a danced beat: a heap ordered by beat, read once per tick (T016)."""

import heapq
import math
from typing import Any, Final

from live.control.events.event import ControlEvent

MAX_WAITING: Final = 100_000
"""Maximum number of waiting events."""
MAX_PER_TICK: Final = 256
"""Maximum number of events fired in one tick, so that an event that reschedules itself cannot block the show."""


class BeatScheduler:
    """Events that wait for a danced beat: (measure + phase) times the beats of a measure. Thread: the show's."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, float, ControlEvent]] = []
        self._order = 0
        self._last_beat = -math.inf
        self._tick_beats = 1.0
        self.fired = 0
        """Events fired so far."""
        self.late_ticks_max = 0
        """Largest delay of an event after the tick that contains its beat [ticks]."""
        self.late = 0
        """Events that fired more than one tick late."""
        self.dropped = 0
        """Events dropped because the queue was full."""

    def __len__(self) -> int:
        return len(self._heap)

    def schedule(self, beat: float, event: ControlEvent) -> None:
        """Schedule `event` for the danced `beat`. Events of the same beat fire in the order of their `schedule`
        calls."""
        if len(self._heap) >= MAX_WAITING:
            self.dropped += 1
            return
        self._order += 1
        due = max(beat, self._last_beat)  # an event put in the past counts its lateness from now
        heapq.heappush(self._heap, (beat, self._order, due, event))

    def fire(self, until: float) -> list[ControlEvent]:
        """Return the events due by the danced beat `until`, in order; call it at least once in every tick.

        Events that these events schedule for a beat already due come with the next call.
        """
        before, self._last_beat = self._last_beat, max(until, self._last_beat)
        if until > before > -math.inf:
            self._tick_beats = until - before
        if not self._heap or self._heap[0][0] > until:
            return []
        events: list[ControlEvent] = []
        while self._heap and self._heap[0][0] <= until and len(events) < MAX_PER_TICK:
            _, _, due, event = heapq.heappop(self._heap)
            events.append(event)
            late = math.ceil((before - due) / self._tick_beats) if due < before else 0
            self.late_ticks_max = max(self.late_ticks_max, late)
            self.late += late > 1
        self.fired += len(events)
        return events

    def remove(self, source: str, begin: float) -> int:
        """Remove the events of `source` at danced beat `begin` or later, and return how many were removed."""
        kept = [entry for entry in self._heap if entry[0] < begin or entry[3].source != source]
        gone = len(self._heap) - len(kept)
        if gone:
            heapq.heapify(kept)
            self._heap = kept
        return gone

    def clear(self) -> None:
        """Remove all waiting events."""
        self._heap.clear()

    def counters(self) -> dict[str, Any]:
        """Return counters for the status: events fired and waiting, and the largest delay in ticks."""
        return {
            "fired": self.fired,
            "waiting": len(self._heap),
            "late_ticks_max": self.late_ticks_max,
            "late": self.late,
            "dropped": self.dropped,
        }
