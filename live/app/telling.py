"""Telling: what everything in the show is now, for those outside who ask or listen, so many times a second."""

from collections.abc import Callable
from functools import partial
from typing import Final

from live.base.fault_isolation import Bulkhead, name_of
from live.control.registry.control import Plain
from live.control.registry.values import Changes
from live.show.core import Show
from live.show.readable import Readable
from live.show.status import Status
from live.show.venue.venue_latency import Latencies

EVERY: Final = 0.05
"""Seconds from look to look."""


class Telling:
    """Between the show and its ports. Thread: the one that runs the show."""

    def __init__(self, show: Show, status: Status, latencies: Latencies) -> None:
        self._readable = Readable(show, status)
        self._next = 0.0
        self._calls = Bulkhead()
        self.to: list[Callable[[Changes], None]] = []
        """Told what has another value."""
        for what in ("input", "output", "display", "projector"):
            self._readable.more[f"/dance/latency/{what}"] = partial(_milliseconds, latencies, what)

    def know(self, address: str, tell: Callable[[], Plain | None]) -> None:
        """Another part knows what there is at an address."""
        self._readable.more[address] = tell

    def frame(self, time: float) -> None:
        """After each frame, at `time` [s]."""
        if time < self._next:
            return
        self._next = time + EVERY
        changes = self._readable.changes()
        if changes:
            for tell in self.to:
                self._calls.call(f"{name_of(tell)}, which tells values", tell, changes)


def _milliseconds(latencies: Latencies, what: str) -> float | None:
    value = getattr(latencies, what)
    return None if value is None else round(1000.0 * float(value), 2)
