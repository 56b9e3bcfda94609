"""Threads for work on many rows: the ranges of `run_rows` are done by all cores, with the same bits as by one.

The calling thread takes ranges like the others and waits only for a range that another thread is in. A thread that the
system does not run, or that a fork left behind, so costs nothing but its share of the work.
"""

import threading
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from queue import SimpleQueue
from typing import Final

from live.base.fault_isolation import run_once
from live.base.row_ranges import Part, row_runner
from live.base.system.process_control import processor_count

MAX_THREADS: Final = 8
"""More threads wait for memory and for each other's start."""


class _Job:
    """One call of `RowThreads.run`: its ranges, taken by whoever comes."""

    __slots__ = ("_count", "_finished", "_part", "_waiting", "done", "error")

    def __init__(self, part: Part, ranges: Sequence[tuple[int, int]]) -> None:
        self._part, self._waiting = part, deque(ranges)
        self._count, self._finished = len(ranges), count(1)
        self.error: BaseException | None = None
        self.done = threading.Lock()
        self.done.acquire()

    def work(self) -> None:
        """Do ranges until none is left; whoever finishes the last one releases `done`."""
        while True:
            try:
                begin, end = self._waiting.popleft()
            except IndexError:
                return
            try:
                self._part(begin, end)
            except BaseException as error:  # raised again in the calling thread
                self.error = error
            if next(self._finished) == self._count:
                self.done.release()


class RowThreads:
    """A runner for `row_runner` with daemon threads that sleep between two calls.

    Thread: any may call `run`. While one call is running, others (a range's own ones, too) are done in their own
    threads.
    """

    def __init__(self, threads: int) -> None:
        """Start `threads` - 1 threads; the calling thread is one more."""
        self.threads = threads
        self._job: _Job | None = None
        self._calls: SimpleQueue[bool] = SimpleQueue()  # True: there may be work, False: the end
        self._busy = threading.Lock()
        self._workers = [
            threading.Thread(target=run_once, args=("rows", self._work), name=f"rows {number}", daemon=True)
            for number in range(1, threads)
        ]
        for worker in self._workers:
            worker.start()

    def run(self, part: Part, ranges: Sequence[tuple[int, int]]) -> None:
        """Call `part` once for each range; return when all are done. An error of any range is raised at the end."""
        if not self._busy.acquire(blocking=False):
            for begin, end in ranges:
                part(begin, end)
            return
        try:
            self._job = job = _Job(part, ranges)
            for _ in range(self._calls.qsize(), min(len(self._workers), len(ranges) - 1)):
                self._calls.put(True)
            job.work()
            job.done.acquire()
        finally:
            self._job = None
            self._busy.release()
        if job.error is not None:
            raise job.error

    def close(self) -> None:
        """End the threads."""
        for _ in self._workers:
            self._calls.put(False)
        for worker in self._workers:
            worker.join()

    def _work(self) -> None:
        while self._calls.get():
            job = self._job
            if job is not None:
                job.work()
            del job  # it holds arrays


@contextmanager
def row_threads(threads: int | None = None) -> Iterator[RowThreads]:
    """Let `run_rows` use `threads` threads within the block; None: as many as this process may use processors."""
    runner = RowThreads(min(processor_count(), MAX_THREADS) if threads is None else threads)
    try:
        with row_runner(runner):
            yield runner
    finally:
        runner.close()
