"""Agenda: events that shall happen at a beat, in the order of their beats, with the tick that holds it (T016)."""

import heapq
import math
from typing import Any, Final

from live.control.events.event import ControlEvent

MOST: Final = 100_000
"""Events that may wait."""
AT_ONCE: Final = 256
"""Events that happen in one tick at most: whatever calls itself again and again stops no show."""


class Agenda:
    """Waiting events by danced beat: (measure + how far it is) times the beats of a measure. Thread: the show's."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, int, float, ControlEvent]] = []
        self._order = 0
        self._before = -math.inf
        self._tick = 1.0
        self.fired = 0
        """Events that have happened."""
        self.late_ticks_max = 0
        """The most ticks by which one came after the tick that holds its beat ..."""
        self.late = 0
        """... how many came later than one tick ..."""
        self.dropped = 0
        """... and how many found no room."""

    def __len__(self) -> int:
        return len(self._heap)

    def put(self, beat: float, event: ControlEvent) -> None:
        """Let `event` happen at the danced `beat`; of one beat, in the order in which they were put."""
        if len(self._heap) >= MOST:
            self.dropped += 1
            return
        self._order += 1
        due = max(beat, self._before)  # whoever asks for what is over already is late herself
        heapq.heappush(self._heap, (beat, self._order, due, event))

    def fire(self, until: float) -> list[ControlEvent]:
        """What is due by the danced beat `until`, in order; to be called at least once in every tick.

        What these events put for a beat that is due already comes with the next call.
        """
        before, self._before = self._before, max(until, self._before)
        if until > before > -math.inf:
            self._tick = until - before
        if not self._heap or self._heap[0][0] > until:
            return []
        events: list[ControlEvent] = []
        while self._heap and self._heap[0][0] <= until and len(events) < AT_ONCE:
            _, _, due, event = heapq.heappop(self._heap)
            events.append(event)
            late = math.ceil((before - due) / self._tick) if due < before else 0
            self.late_ticks_max = max(self.late_ticks_max, late)
            self.late += late > 1
        self.fired += len(events)
        return events

    def withdraw(self, source: str, begin: float) -> int:
        """Forget what `source` has put for `begin` or later; how many that were."""
        kept = [entry for entry in self._heap if entry[0] < begin or entry[3].source != source]
        gone = len(self._heap) - len(kept)
        if gone:
            heapq.heapify(kept)
            self._heap = kept
        return gone

    def clear(self) -> None:
        """Forget all that waits."""
        self._heap.clear()

    def figures(self) -> dict[str, Any]:
        """For the status: events that happened, that wait, and how late they were at most, in ticks."""
        return {
            "fired": self.fired,
            "waiting": len(self._heap),
            "late_ticks_max": self.late_ticks_max,
            "late": self.late,
            "dropped": self.dropped,
        }
