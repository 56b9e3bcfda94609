"""Where seconds come from: SystemClock live, ManualClock offline and in tests. Both start at 0 and never go back.

ProcessorClock counts other seconds: those that a thread had the processor.
"""

import time as _time
from typing import Protocol


class Clock(Protocol):
    """A monotonic clock that shows 0 s when the show starts."""

    def now(self) -> float:
        """Seconds since the start."""
        ...


class SystemClock:
    """The machine's monotonic clock, from the moment this object is made (or from `origin`, a `perf_counter` value).

    Thread: `now` from any. A change of the system's date moves nothing.
    """

    def __init__(self, origin: float | None = None) -> None:
        self.origin = _time.perf_counter() if origin is None else origin

    def now(self) -> float:
        """Seconds since the start."""
        return _time.perf_counter() - self.origin


class ProcessorClock:
    """Seconds of the processor that the thread which asks has used; waiting takes none."""

    def now(self) -> float:
        """Seconds since some time before this object was made."""
        return _time.thread_time()


class ManualClock:
    """A clock that moves only when it is told to: for offline rendering and for tests."""

    def __init__(self, time: float = 0.0) -> None:
        self._time = time

    def now(self) -> float:
        """Seconds it was last set to."""
        return self._time

    def set(self, time: float) -> None:
        """Move to `time` [s]; raises ValueError if that lies in the past."""
        if not time >= self._time:  # NaN too
            raise ValueError(f"a clock cannot go back from {self._time} s to {time} s")
        self._time = time

    def advance(self, seconds: float) -> None:
        """Move on by `seconds`."""
        self.set(self._time + seconds)
