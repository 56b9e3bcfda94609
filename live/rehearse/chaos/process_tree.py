"""Process tree of a show, read from /proc: roles, states, zombies, open descriptors and CPU pressure."""

import contextlib
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from live.rehearse.chaos.injection import ROLES_FOLDER

PROC = Path("/proc")


@dataclass(frozen=True, slots=True)
class Process:
    """One process."""

    pid: int
    parent: int
    state: str
    """As in proc(5): R, S, T (stopped), Z (zombie) ..."""
    command: str


def read_process(pid: int) -> Process | None:
    """Read a process from /proc; None if it does not exist."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        words = (PROC / str(pid) / "stat").read_text(errors="replace").rpartition(")")[2].split()
        command = (PROC / str(pid) / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
        return Process(pid, int(words[1]), words[0], command)
    return None


class ProcessTree:
    """A supervisor and its descendants. Thread: one."""

    def __init__(self, supervisor: int, folder: Path) -> None:
        """`folder`: of the run, where engines write their roles."""
        self.supervisor, self._folder = supervisor, folder
        self._orphans: set[int] = set()

    def kill_supervisor(self) -> None:
        """Kill the supervisor; its children remain part of the tree."""
        self._orphans |= {one.pid for one in self.descendants()}
        os.kill(self.supervisor, signal.SIGKILL)

    def descendants(self) -> list[Process]:
        """Return all descendants of the supervisor and the orphans of earlier supervisors."""
        all_of = [
            found for name in os.listdir(PROC) if name.isdecimal() and (found := read_process(int(name))) is not None
        ]
        below = [one for one in all_of if one.pid in self._orphans]
        parents = {self.supervisor, *self._orphans}
        while more := [one for one in all_of if one.parent in parents and one not in below]:
            below += more
            parents = {one.pid for one in more}
        return below

    def roles(self) -> dict[int, str]:
        """Return the start role of each live engine, by process id."""
        roles = {}
        for one in self.descendants():
            with contextlib.suppress(OSError):
                if one.state != "Z":
                    roles[one.pid] = (self._folder / ROLES_FOLDER / str(one.pid)).read_text(encoding="utf-8")
        return roles

    def audio_processes(self) -> list[int]:
        """Return the ids of the audio processes."""
        return [
            one.pid for one in self.descendants() if "live.app.processes.audio_main" in one.command and one.state != "Z"
        ]

    def zombies(self) -> set[int]:
        """Return the ids of zombies; without orphans of earlier supervisors, which the system has to reap."""
        return {one.pid for one in self.descendants() if one.state == "Z" and one.pid not in self._orphans}

    def signal(self, pid: int, number: int) -> bool:
        """Send a signal; return whether the process exists."""
        with contextlib.suppress(OSError):
            os.kill(pid, number)
            return True
        return False

    def resume_all(self) -> None:
        """Continue all stopped processes."""
        for one in [*self.descendants(), read_process(self.supervisor)]:
            if one is not None and one.state in "Tt":
                self.signal(one.pid, signal.SIGCONT)


def descriptors(pid: int) -> int:
    """Return the number of open descriptors of a process; 0 if unknown."""
    with contextlib.suppress(OSError):
        return len(os.listdir(PROC / str(pid) / "fd"))
    return 0


@contextlib.contextmanager
def limited_descriptors(pid: int) -> Iterator[None]:
    """Prevent a process from opening more descriptors, within the context."""
    import resource

    was = None
    with contextlib.suppress(OSError, ValueError):
        was = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (min(descriptors(pid), was[1]), was[1]))
    try:
        yield
    finally:
        if was is not None:
            with contextlib.suppress(OSError, ValueError):
                resource.prlimit(pid, resource.RLIMIT_NOFILE, was)


def cpu_pressure() -> float:
    """Return the share of the last ten seconds in which a process waited for a CPU, 0 to 1; estimated from the load if
    the kernel has no pressure-stall information."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        some = (PROC / "pressure" / "cpu").read_text().split("\n")[0]
        return float(some.split("avg10=")[1].split()[0]) / 100.0
    return min(max(os.getloadavg()[0] / (os.cpu_count() or 1) - 1.0, 0.0), 1.0)
