"""Registry of a show's services, publisher of the show's values, and watches on edited files."""

import threading
from collections import Counter, deque
from collections.abc import Callable
from functools import partial
from typing import Any, Final, Protocol

from live.app.services.audience_service import AudiencePart
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, Bulkhead, name_of, run_once
from live.control.events.events import ControlEvent
from live.control.registry.control import Plain
from live.control.registry.registry import Changes
from live.show.loader import LoadedShow
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.graph_update import LibraryWatch
from live.show.show import Show
from live.show.status import Status
from live.show.telemetry import Readable
from live.show.venue.venue import Latencies

FIRST_PAUSE: Final = 0.5
"""First pause [s] before a service that failed to start is tried again; each pause is twice the one before."""
LONGEST_PAUSE: Final = 8.0


class Part(Protocol):
    """Service of a show with its own device or network port."""

    def start(self) -> None:
        """Open device or port; raise PersonError if that fails."""
        ...

    def stop(self) -> None:
        """Close device or port; may be called without `start`."""
        ...

    def frame(self) -> None:
        """Update the service after each frame."""
        ...

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        ...


class Parts:
    """The services of one show, in the order in which they start. Thread: the show's."""

    def __init__(self) -> None:
        self._parts: list[Part] = []
        self._late: deque[Part] = deque()  # started later by the retry thread
        self._over = threading.Event()
        self._retry: threading.Thread | None = None
        self.bulkhead = Bulkhead()
        """Isolates errors of each service from the frame and from the other services."""
        self.refused: list[Callable[[], Counter[str]]] = []
        """Functions that return the number of refused inputs by reason, one per service."""
        self.early: list[Callable[[], None]] = []
        """Functions called before each frame, to receive input for it."""
        self.audience: AudiencePart | None = None
        """The service for phones, if there is one."""
        self.refusals: list[Callable[[], str]] = []
        """Functions that return the last refusal in words, one per service."""

    def add(self, part: Part) -> None:
        """Add a service; call before `start`."""
        self._parts.append(part)

    def start(self, *, forgiving: bool = False) -> None:
        """Start all services; the first failure is raised.

        `forgiving`, for a resumed show: a service that fails is reported and left out. After a PersonError (a port or
        host that is not available) it is tried again in a thread.
        """
        refused = []
        for part in list(self._parts):
            name = f"the start of {name_of(part.start)}"
            try:
                part.start()
            except Exception as error:
                if not forgiving:
                    raise
                FAULTS.note(name, error)
                self._parts.remove(part)
                run_once(f"the end of {name_of(part.stop)}", part.stop)
                if isinstance(error, PersonError):
                    FAULTS.wait(name)
                    refused.append((name, part))
        if refused:
            self._retry = threading.Thread(target=self._start_late, args=(refused,), name="parts", daemon=True)
            self._retry.start()

    def _start_late(self, refused: list[tuple[str, Part]]) -> None:
        """Retry services whose port is still in use or whose host is not known yet. Thread: its own."""
        pause = FIRST_PAUSE
        while refused and not self._over.wait(pause):
            pause = min(2.0 * pause, LONGEST_PAUSE)
            for name, part in list(refused):
                try:
                    part.start()
                except PersonError:
                    continue
                except Exception as error:
                    FAULTS.note(name, error)
                else:
                    self._late.append(part)
                FAULTS.works(name)
                refused.remove((name, part))

    def before_frame(self) -> None:
        """Receive input, before each frame."""
        for take in self.early:
            self.bulkhead.call(f"{name_of(take)}, before a frame", take)

    def frame(self) -> None:
        """Update all services, after each frame."""
        while self._late:
            self._parts.append(self._late.popleft())
        for part in self._parts:
            self.bulkhead.call(name_of(part.frame), part.frame)

    def stop(self) -> None:
        """Stop all services for good."""
        self._over.set()
        if self._retry is not None:
            self._retry.join()
        for part in (*self._parts, *self._late):
            run_once(f"the end of {name_of(part.stop)}", part.stop)
        self._parts.clear()
        self.early.clear()


EVERY: Final = 0.05
"""Interval [s] between two readings of the values."""


class Telling:
    """Publishes changed values of the show to services, at a limited rate. Thread: the show's."""

    def __init__(self, show: Show, status: Status, latencies: Latencies) -> None:
        self._readable = Readable(show, status)
        self._next = 0.0
        self._calls = Bulkhead()
        self.to: list[Callable[[Changes], None]] = []
        """Functions called with changed values."""
        for what in ("input", "output", "display", "projector"):
            self._readable.more[f"/dance/latency/{what}"] = partial(_milliseconds, latencies, what)

    def know(self, address: str, tell: Callable[[], Plain | None]) -> None:
        """Register a function that returns the value at an address."""
        self._readable.more[address] = tell

    def frame(self, time: float) -> None:
        """Publish changed values, after each frame, at `time` [s]."""
        if time < self._next:
            return
        self._next = time + EVERY
        changes = self._readable.changes()
        if changes:
            for tell in self.to:
                self._calls.call(f"{name_of(tell)}, publishing values", tell, changes)


def _milliseconds(latencies: Latencies, what: str) -> float | None:
    value = getattr(latencies, what)
    return None if value is None else round(1000.0 * float(value), 2)


def make_watches(
    loaded: LoadedShow, show: Show, *, post: Callable[[ControlEvent], None], now: Callable[[], float]
) -> tuple[PatchWatch, LibraryWatch | None]:
    """Return watches on the patch and, if its steps are in a folder, on the steps; start only the first.

    The patch watch runs the other one. Steps recorded during the show are added to it.
    """
    folder, library = loaded.steps_folder, None
    if folder is not None:
        library = LibraryWatch(folder, show.graph, offer=show.offer, post=post, now=now, read=loaded.clips)
    return PatchWatch(loaded, show, post=post, now=now, library=library), library
