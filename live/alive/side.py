"""Side: a process beside the engine that is started again when it dies, as often as is allowed."""

from collections.abc import Callable
from dataclasses import dataclass, field

from live.alive.child import Child
from live.alive.limits import RestartLimit


@dataclass(slots=True)
class Side:
    """The process that listens, or the one with the black window. Thread: the supervisor's."""

    start: Callable[[], Child]
    """Starts one and tells it what it has to know."""
    say: Callable[[str], None]
    child: Child | None = None
    restarts: int = 0
    _limit: RestartLimit = field(default_factory=RestartLimit)

    def look(self, now: float, awake: float) -> None:
        """Start it again if it has died or hangs. One that ended by itself, with code 0, can do nothing here."""
        child = self.child
        if child is None:
            return
        if child.hangs(now, awake):
            child.kill()
        if child.process.poll() is None:
            child.wire.flush()
            return
        role, code, self.child = child.role, child.end(), None
        if code == 0:
            return
        if self._limit.note(now):
            self.say(f"the {role} process ended again; the show goes on without it")
            return
        self.restarts += 1
        self.say(f"the {role} process ended; it is started again")
        self.child = self.start()

    def close(self) -> None:
        """End it."""
        if self.child is not None:
            self.child.terminate()
            self.child.end()
            self.child = None
