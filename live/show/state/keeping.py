"""Keeping: when a running show's snapshots are taken (T148)."""

from collections.abc import Callable
from typing import Final

from live.show.core import Show
from live.show.state.snapshot import SnapshotError, Snapshots, Taken

AFTER_LINE: Final = 6
"""Ticks after a measure line at which a snapshot is taken: the frame of the line has enough to do."""
PATIENCE: Final = 8
"""After so many failures in a row no snapshot is tried any more: that costs time in the frame."""


class Keeping:
    """Takes one snapshot a measure, at the first tick at which nothing is half planned. Thread: the show's."""

    def __init__(self, put: Callable[[Taken], None]) -> None:
        self._put = put
        self._source: Snapshots | None = None
        self._due: int | None = None
        self._in_a_row = 0
        self.failed = 0
        """Snapshots that could not be taken."""
        self.problem = ""
        """Why not, of the last one."""

    def prepare(self, show: Show) -> None:
        """Do what takes some milliseconds, before the show begins; left out, it is done with the first snapshot."""
        self._source = Snapshots(show)

    def after(self, show: Show, tick: int, *, begins: bool) -> None:
        """The tick `tick` was run; `begins`: a measure began with it."""
        if begins:
            self._due = tick + AFTER_LINE
        if self._due is None or tick < self._due or self._in_a_row >= PATIENCE:
            return
        if self._source is None or self._source.show is not show:
            self.prepare(show)
        assert self._source is not None
        try:
            taken = self._source.take(tick)
        except SnapshotError as error:
            self.failed += 1
            self._in_a_row += 1
            self.problem, self._due = str(error), None
            return
        if taken is not None:
            self._in_a_row, self._due = 0, None
            self._put(taken)
