"""Reaper: waits for children that nobody else waits for, so that none stays a zombie.

The supervisor adopts whoever below it loses its parent: the helpers of an engine that was killed, who was between the
two forks of a nursery that was killed. Nobody holds a handle on these.
"""

import contextlib
import os
from typing import Final

from live.supervisor.procfs import zombies

EVERY: Final = 0.25
"""Seconds between two looks."""
GRACE: Final = 1.0
"""Seconds that whoever started a process has for waiting for it: exit codes are theirs."""


class Reaper:
    """Thread: the one that starts processes, for the system knows children by process."""

    def __init__(self) -> None:
        self._look_at = 0.0
        self._seen: dict[int, float] = {}
        self.count = 0
        """Processes that were cleared away here."""

    def look(self, now: float) -> None:
        """Clear away who has been dead for longer than a moment; `now` [s]."""
        if now < self._look_at:
            return
        self._look_at = now + EVERY
        try:
            dead = os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
        except ChildProcessError:
            dead = False
        self._seen = {process: self._seen.get(process, now) for process in zombies()} if dead else {}
        for process, since in self._seen.items():
            if now - since > GRACE:
                with contextlib.suppress(ChildProcessError):
                    self.count += os.waitpid(process, os.WNOHANG)[0] == process
