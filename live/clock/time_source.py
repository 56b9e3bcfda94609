"""Clocks: the system's monotonic clock for live shows, a manual clock for offline rendering and tests, and a thread's
processor time.

`SystemClock` and `ManualClock` start at 0 and never go back.
"""

import time as _time
from typing import Protocol


class Clock(Protocol):
    """A monotonic clock that shows 0 s when the show starts."""

    def now(self) -> float:
        """Seconds since the start."""
        ...


class SystemClock:
    """The machine's monotonic clock, from the creation of this object (or from `origin`, a `perf_counter` value).

    Thread: `now` from any. A change of the system's date has no effect.
    """

    def __init__(self, origin: float | None = None) -> None:
        self.origin = _time.perf_counter() if origin is None else origin

    def now(self) -> float:
        """Seconds since the start."""
        return _time.perf_counter() - self.origin


class ProcessorClock:
    """Processor time of the calling thread; waiting takes none."""

    def now(self) -> float:
        """Seconds since some moment before this object was made."""
        return _time.thread_time()


class ManualClock:
    """A clock that is set by its owner: for offline rendering and for tests."""

    def __init__(self, time: float = 0.0) -> None:
        self._time = time

    def now(self) -> float:
        """The time it was last set to [s]."""
        return self._time

    def set(self, time: float) -> None:
        """Set to `time` [s]; raises ValueError if that lies in the past."""
        if not time >= self._time:  # NaN too
            raise ValueError(f"a clock cannot go back from {self._time} s to {time} s")
        self._time = time

    def advance(self, seconds: float) -> None:
        """Advance by `seconds`."""
        self.set(self._time + seconds)
