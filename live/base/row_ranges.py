"""Ranges of rows: work on many rows, such as a kernel over all dancers, is cut into ranges that may run side by side.

The core knows no threads. It calls `run_rows`; whoever composes the process may install a runner with threads
(`live/show/stages/row_threads.py`). A range writes its own rows only and reads nothing that another range writes, so
the results have the same bits for any number of threads.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Final, Protocol

Part = Callable[[int, int], object]
"""Does the work for the rows from the first number to the one before the second."""

RANGES_PER_THREAD: Final = 4
"""So many ranges are there for each thread: one that starts late, or has the dearer rows, delays the others less."""


class RowRunner(Protocol):
    """Runs a function for several ranges, in any order or at the same time."""

    @property
    def threads(self) -> int:
        """How many ranges run at a time."""
        ...

    def run(self, part: Part, ranges: Sequence[tuple[int, int]]) -> None:
        """Call `part` once for each range; return when all are done. Raises what `part` raises."""
        ...


class SerialRunner:
    """Runs one range after the other in the calling thread."""

    threads = 1

    def run(self, part: Part, ranges: Sequence[tuple[int, int]]) -> None:
        """Call `part` for each range."""
        for begin, end in ranges:
            part(begin, end)


_runner: RowRunner = SerialRunner()


@contextmanager
def row_runner(runner: RowRunner) -> Iterator[RowRunner]:
    """Let all calls of `run_rows` in this process use `runner` within the block."""
    global _runner
    before, _runner = _runner, runner
    try:
        yield runner
    finally:
        _runner = before


def run_rows(part: Part, count: int, *, least: int, block: int = 1) -> None:
    """Call `part` for ranges that together are the rows 0 to `count` - 1; just once where that is quicker.

    `least`: so many rows at least are worth a range of their own, some 50 µs of work. `block`: ranges begin at
    multiples of it, for work whose bits depend on the rows that are done together.
    """
    runner = _runner
    if runner.threads == 1 or count < 2 * least:
        part(0, count)
    else:
        runner.run(part, cut_rows(count, min(count // least, RANGES_PER_THREAD * runner.threads), block))


def cut_rows(count: int, pieces: int, block: int = 1) -> list[tuple[int, int]]:
    """Return at most `pieces` ranges (begin, end) of about the same size, in order, that begin at multiples of
    `block`."""
    blocks = -(-count // block)
    edges = [min(count, block * (blocks * piece // pieces)) for piece in range(pieces + 1)]
    return [(begin, end) for begin, end in pairwise(edges) if end > begin]
