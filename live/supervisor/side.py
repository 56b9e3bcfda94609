"""Side: a process beside the engine that is started again when it dies, less and less often if it dies at once."""

from collections.abc import Callable
from dataclasses import dataclass, field

from live.supervisor.child import Child
from live.supervisor.restart_policy import Backoff


@dataclass(slots=True)
class Side:
    """The process that listens, or the one with the black window. Thread: the supervisor's."""

    start: Callable[[], Child]
    """Starts one and tells it what it has to know."""
    say: Callable[[str], None]
    child: Child | None = None
    restarts: int = 0
    _backoff: Backoff = field(default_factory=lambda: Backoff(free=3, first=5.0, settled=30.0))
    _start_at: float | None = None

    def look(self, now: float, slowdown: float) -> None:
        """Start it again if it has died or hangs. One that ended by itself, with code 0, can do nothing here.

        `slowdown`: how many times slower the machine is.
        """
        child = self.child
        if child is None:
            if self._start_at is not None and now >= self._start_at:
                self._begin(now)
            return
        if not child.killed and child.hangs(now, slowdown):
            child.kill()
        if child.process.poll() is None:
            child.wire.flush()
            return
        role, code, self.child = child.role, child.end(), None
        if code == 0:
            return
        wait = self._backoff.after(now)
        self._start_at = now + wait
        when = f" again; it is started once more in {wait:.0f} s" if wait else "; it is started again"
        self.say(f"the {role} process ended{when}")

    def _begin(self, now: float) -> None:
        self._start_at = None
        try:
            self.child = self.start()
        except OSError:  # the system has no room for one now
            self._start_at = now + max(self._backoff.after(now), 1.0)
            return
        self.restarts += 1

    def close(self) -> None:
        """End it."""
        self._start_at = None
        if self.child is not None:
            self.child.terminate()
            self.child.end()
            self.child = None
