"""Registry of a show's services, publisher of the show's values, and watches on edited files."""

import threading
from collections import Counter, deque
from collections.abc import Callable
from functools import partial
from typing import Final

from live.app.services.audience_service import AudienceService
from live.app.services.service import Service
from live.app.services.web_service import WebService
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS, Bulkhead, callback_name, run_once
from live.control.events.events import ControlEvent
from live.control.registry.control import ArgumentValue
from live.control.registry.registry import Changes
from live.show.loader import LoadedShow
from live.show.partner.example_updates import ExamplesWatch
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.library_watch import LibraryWatch
from live.show.show import Show
from live.show.venue.venue import Latencies
from live.show.view.status import Status
from live.show.view.telemetry import CurrentValues

FIRST_RETRY_DELAY: Final = 0.5
"""First pause [s] before a service that failed to start is tried again; each pause is twice the one before."""
MAX_RETRY_DELAY: Final = 8.0


class ServiceRegistry:
    """The services of one show, in the order in which they start. Thread: the show's."""

    def __init__(self) -> None:
        self._services: list[Service] = []
        self._late_services: deque[Service] = deque()  # started later by the retry thread
        self._stopped = threading.Event()
        self._retry_thread: threading.Thread | None = None
        self.bulkhead = Bulkhead()
        """Isolates errors of each service from the frame and from the other services."""
        self.refused_counts: list[Callable[[], Counter[str]]] = []
        """Functions that return the number of refused inputs by reason, one per service."""
        self.before_frame_calls: list[Callable[[], None]] = []
        """Functions called before each frame, to receive input for it."""
        self.audience: AudienceService | None = None
        self.web: WebService | None = None
        """The service for phones, if there is one."""
        self.refusals: list[Callable[[], str]] = []
        """Functions that return the last refusal in words, one per service."""

    def add(self, service: Service) -> None:
        """Add a service; call before `start`."""
        self._services.append(service)

    def start(self, *, tolerant: bool = False) -> None:
        """Start all services; the first failure is raised.

        `tolerant`, for a resumed show: a service that fails is reported and left out. After a PersonError (a port or
        host that is not available) it is tried again in a thread.
        """
        refused = []
        for part in list(self._services):
            name = f"the start of {callback_name(part.start)}"
            try:
                part.start()
            except Exception as error:
                if not tolerant:
                    raise
                FAULTS.record(name, error)
                self._services.remove(part)
                run_once(f"the end of {callback_name(part.stop)}", part.stop)
                if isinstance(error, PersonError):
                    FAULTS.record_retry(name)
                    refused.append((name, part))
        if refused:
            self._retry_thread = threading.Thread(target=self._retry_start, args=(refused,), name="parts", daemon=True)
            self._retry_thread.start()

    def _retry_start(self, refused: list[tuple[str, Service]]) -> None:
        """Retry services whose port is still in use or whose host is not known yet. Thread: its own."""
        pause = FIRST_RETRY_DELAY
        while refused and not self._stopped.wait(pause):
            pause = min(2.0 * pause, MAX_RETRY_DELAY)
            for name, part in list(refused):
                try:
                    part.start()
                except PersonError:
                    continue
                except Exception as error:
                    FAULTS.record(name, error)
                else:
                    self._late_services.append(part)
                FAULTS.record_recovery(name)
                refused.remove((name, part))

    def before_frame(self) -> None:
        """Receive input, before each frame."""
        for take in self.before_frame_calls:
            self.bulkhead.call(f"{callback_name(take)}, before a frame", take)

    def frame(self) -> None:
        """Update all services, after each frame."""
        while self._late_services:
            self._services.append(self._late_services.popleft())
        for part in self._services:
            self.bulkhead.call(callback_name(part.frame), part.frame)

    def stop(self) -> None:
        """Stop all services for good."""
        self._stopped.set()
        if self._retry_thread is not None:
            self._retry_thread.join()
        for part in (*self._services, *self._late_services):
            run_once(f"the end of {callback_name(part.stop)}", part.stop)
        self._services.clear()
        self.before_frame_calls.clear()


PUBLISH_INTERVAL: Final = 0.05
"""Interval [s] between two readings of the values."""


class ValuePublisher:
    """Publishes changed values of the show to services, at a limited rate. Thread: the show's."""

    def __init__(self, show: Show, status: Status, latencies: Latencies) -> None:
        self._readable = CurrentValues(show, status)
        self._next = 0.0
        self._calls = Bulkhead()
        self.subscribers: list[Callable[[Changes], None]] = []
        """Functions called with changed values."""
        for what in ("input", "output", "display", "projector"):
            self._readable.extra_values[f"/dance/latency/{what}"] = partial(_milliseconds, latencies, what)

    def add_value(self, address: str, read: Callable[[], ArgumentValue | None]) -> None:
        """Register a function that returns the value at an address."""
        self._readable.extra_values[address] = read

    def frame(self, time: float) -> None:
        """Publish changed values, after each frame, at `time` [s]."""
        if time < self._next:
            return
        self._next = time + PUBLISH_INTERVAL
        changes = self._readable.changes()
        if changes:
            for tell in self.subscribers:
                self._calls.call(f"{callback_name(tell)}, publishing values", tell, changes)


def _milliseconds(latencies: Latencies, what: str) -> float | None:
    value = getattr(latencies, what)
    return None if value is None else round(1000.0 * float(value), 2)


def make_file_watches(
    loaded: LoadedShow, show: Show, *, post: Callable[[ControlEvent], None], now: Callable[[], float]
) -> tuple[PatchWatch, LibraryWatch | None, ExamplesWatch | None]:
    """Return watches on the patch and, if its steps are in a folder, on the steps, and on files of pairs if it has any.

    The patch watch runs the others. Steps recorded during the show are added to it.
    """
    folder, library = loaded.steps_folder, None
    if folder is not None:
        library = LibraryWatch(
            folder, show.graph, offer=show.hot_swap.offer_graph, post=post, now=now, read=loaded.read_steps
        )
    examples, bank = None, show.hot_swap.answers
    if bank.texts:
        offer = show.hot_swap.offer_examples
        examples = ExamplesWatch(loaded.path, loaded.graph.library, bank, offer=offer, post=post, now=now)
    return PatchWatch(loaded, show, post=post, now=now, library=library, examples=examples), library, examples
