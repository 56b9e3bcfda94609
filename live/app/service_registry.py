"""Parts: what runs beside a show (Link, click, MIDI, OSC, its audience): one row that starts, follows and ends.

Telling: what everything in the show is now, for those outside who ask or listen, so many times a second.

Watches: what is edited while a show runs: its patch's files, and the steps of its own folder.
"""

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
"""Seconds after which a part that was refused is tried again at first; each pause is twice the last one."""
LONGEST_PAUSE: Final = 8.0


class Part(Protocol):
    """Something beside the show that has a device or a network of its own."""

    def start(self) -> None:
        """Open what it needs; PersonError if that is refused."""
        ...

    def stop(self) -> None:
        """Let go of it; whether it was started or not."""
        ...

    def frame(self) -> None:
        """After each frame: how the show runs."""
        ...

    def status(self) -> dict[str, Any]:
        """For the status line."""
        ...


class Parts:
    """The parts of one show, in the order in which they start. Thread: the one that runs the show."""

    def __init__(self) -> None:
        self._parts: list[Part] = []
        self._late: deque[Part] = deque()  # started since by the thread that tries again
        self._over = threading.Event()
        self._retry: threading.Thread | None = None
        self.bulkhead = Bulkhead()
        """Keeps errors of each part away from the frame and from the others."""
        self.refused: list[Callable[[], Counter[str]]] = []
        """What was refused by parts that refuse, by reason."""
        self.early: list[Callable[[], None]] = []
        """What is done before each frame: taking up what shall act in it."""
        self.audience: AudiencePart | None = None
        """The one that the audience's phones play through, if they may."""
        self.refusals: list[Callable[[], str]] = []
        """The last refusal of each of them, in words."""

    def add(self, part: Part) -> None:
        """One more; before `start`."""
        self._parts.append(part)

    def start(self, *, forgiving: bool = False) -> None:
        """Start all of them; the first that refuses ends it. `forgiving`: a show that is gone on with is not ended by a
        part that cannot go on; it is left out, told, and where its port or host was refused tried again and again."""
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
        """Thread: its own. Somebody else has the port for a while, or nobody knows the host yet."""
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
        """Before each frame."""
        for take in self.early:
            self.bulkhead.call(f"{name_of(take)}, before a frame", take)

    def frame(self) -> None:
        """After each frame."""
        while self._late:
            self._parts.append(self._late.popleft())
        for part in self._parts:
            self.bulkhead.call(name_of(part.frame), part.frame)

    def stop(self) -> None:
        """Stop all of them, for good: nothing is sent or played from here any more."""
        self._over.set()
        if self._retry is not None:
            self._retry.join()
        for part in (*self._parts, *self._late):
            run_once(f"the end of {name_of(part.stop)}", part.stop)
        self._parts.clear()
        self.early.clear()


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


def make_watches(
    loaded: LoadedShow, show: Show, *, post: Callable[[ControlEvent], None], now: Callable[[], float]
) -> tuple[PatchWatch, LibraryWatch | None]:
    """On the patch, and on its steps if they lie in a folder; the first is to be started, and minds the other.

    Takes that are recorded meanwhile join the dance.
    """
    folder, library = loaded.steps_folder, None
    if folder is not None:
        library = LibraryWatch(folder, show.graph, offer=show.offer, post=post, now=now, read=loaded.clips)
    return PatchWatch(loaded, show, post=post, now=now, library=library), library
