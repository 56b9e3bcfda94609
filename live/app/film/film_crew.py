"""Workers that draw the parts of a film: processes of this machine, and what any workers have to offer."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Final, Protocol

from live.app.film.film_plan import FilmPart
from live.app.film.film_worker import FilmOrder, FilmWorker
from live.base.errors import PersonError
from live.base.system.process_control import processor_count

MAX_TRIES: Final = 3
"""So often a part is begun whose workers die."""
WAIT_S: Final = 0.5
"""Longest wait for a message [s]."""
HUNG_FACTOR: Final = 10.0
"""A worker hangs if it is silent for so many times the longest silence of any that went on, ..."""
HUNG_LEAST_S: Final = 60.0
"""... and for this long at least [s]."""


@dataclass(frozen=True, slots=True)
class PartResult:
    """A part that was drawn."""

    number: int
    before: str
    """Hash of the picture before its first one, as its worker drew it."""
    last: str
    """Hash of its last picture."""


class Crew(Protocol):
    """Workers that draw the parts of one film."""

    def add(self, part: FilmPart) -> None:
        """Have a part drawn."""

    def poll(self, *, wait: bool) -> Iterator[int | PartResult]:
        """Yield how many more frames are drawn (fewer if a worker was lost), and parts that are; `wait`: for a moment.
        PersonError if a part cannot be drawn."""

    @property
    def busy(self) -> bool:
        """Whether parts are still to be drawn."""

    def file_of(self, part: FilmPart) -> Path:
        """Return where the part's packets are; pictures lie in the film's folder."""

    def close(self) -> None:
        """End all workers."""


class LocalCrew:
    """Processes of this machine. A process that dies or hangs is replaced, and its part is begun again by another one.

    Thread: one.
    """

    def __init__(
        self, order: FilmOrder, folder: Path, workers: int, *, now: Callable[[], float] = time.monotonic
    ) -> None:  # fmt: skip
        """`now`: a clock [s]. PersonError if no process can be started."""
        self._order, self._folder = order, folder
        self._threads = max(processor_count() // workers, 1)
        self._waiting: deque[FilmPart] = deque()
        self._heard: SimpleQueue[tuple[FilmWorker, dict[str, Any]]] = SimpleQueue()
        self._tries: dict[int, int] = {}
        self._drawn: dict[int, int] = {}
        self._failed_starts = 0
        self._now, self._longest = now, 0.0
        self._since: dict[FilmWorker, float] = {}
        self.workers: list[FilmWorker] = []
        """The processes that run."""
        try:
            for _ in range(workers):
                self._start()
        except PersonError:
            self.close()
            raise

    def _start(self) -> None:
        self.workers.append(FilmWorker(self._order, self._heard, threads=self._threads))
        self._since[self.workers[-1]] = self._now()

    def add(self, part: FilmPart) -> None:
        """See `Crew`."""
        if part.snapshot is not None:
            self._snapshot(part).write_bytes(part.snapshot)
        self._waiting.append(part)
        self._give()

    def _snapshot(self, part: FilmPart) -> Path:
        return self._folder / f"{part.number}.snap"

    def file_of(self, part: FilmPart) -> Path:
        """See `Crew`."""
        return self._folder / f"{part.number}.part"

    def _give(self) -> None:
        """Let idle workers begin parts."""
        for worker in self.workers:
            if worker.ready and worker.part is None and self._waiting:
                part = self._waiting.popleft()
                pictures = self._order.film.lower().endswith(".png")
                out = Path(self._order.film).parent if pictures else self.file_of(part)
                worker.ask(part, out, None if part.snapshot is None else self._snapshot(part))
                self._drawn[part.number] = 0
                self._since[worker] = self._now()

    @property
    def busy(self) -> bool:
        """See `Crew`."""
        return bool(self._waiting) or any(worker.part is not None for worker in self.workers)

    def poll(self, *, wait: bool) -> Iterator[int | PartResult]:
        """See `Crew`."""
        while True:
            try:
                worker, message = self._heard.get(timeout=WAIT_S) if wait else self._heard.get_nowait()
            except Empty:
                break
            wait = False
            if worker in self.workers:  # it may have been given up since
                yield from self._act(worker, message)
        yield from self._look_for_hung()

    def _look_for_hung(self) -> Iterator[int]:
        """Give up workers that are silent for much longer than others were that went on. Before any has, none is."""
        limit = max(HUNG_FACTOR * self._longest, HUNG_LEAST_S)
        for worker in list(self.workers):
            silent = self._now() - self._since[worker]
            if self._longest and silent > limit and (worker.part is not None or not worker.ready):
                yield from self._lost(worker, f"nothing was heard of it for {silent:.0f} s")

    def _act(self, worker: FilmWorker, message: dict[str, Any]) -> Iterator[int | PartResult]:
        part, now = worker.part, self._now()
        if "ended" not in message:
            self._longest = max(self._longest, now - self._since[worker])
            self._since[worker] = now
        if "refused" in message:
            raise PersonError(str(message["refused"]))
        if "ready" in message:
            worker.ready = True
            self._give()
        elif "drawn" in message and part is not None:
            self._drawn[part.number] += 1
            yield 1
        elif "done" in message and part is not None:
            worker.part = None
            self._give()
            yield PartResult(part.number, message["before"], message["last"])
        elif "ended" in message:
            yield from self._lost(worker, str(message["ended"]))

    def _lost(self, worker: FilmWorker, words: str) -> Iterator[int]:
        """Replace a worker that has ended; its part is begun again."""
        part = worker.part
        worker.close()
        self.workers.remove(worker)
        del self._since[worker]
        if part is None:
            self._failed_starts += not worker.ready
            tries, what = self._failed_starts, "processes for the film"
        else:
            self._tries[part.number] = tries = self._tries.get(part.number, 0) + 1
            what = f"processes that drew frames {part.first} to {part.end - 1}"
        if tries >= MAX_TRIES:
            raise PersonError(f"{tries} {what} have ended: {words}")
        if part is not None:
            self._waiting.appendleft(part)
            yield -self._drawn.pop(part.number)
        self._start()

    def close(self) -> None:
        """See `Crew`."""
        for worker in self.workers:
            worker.close()
        self.workers.clear()
