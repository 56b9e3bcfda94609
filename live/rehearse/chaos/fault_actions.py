"""Actions of a chaos run: executes each kind of fault from outside, on processes, disks and sockets."""

import contextlib
import errno
import os
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from live.rehearse.chaos.call_sites import Site
from live.rehearse.chaos.fault_page import FaultPage, Word
from live.rehearse.chaos.fault_plan import Blow
from live.rehearse.chaos.injection import THREADS
from live.rehearse.chaos.process_tree import Tree, few_descriptors
from live.rehearse.chaos.small_disk import SmallDisk

ALWAYS: Final = 1 << 30
TWICE_WITHIN: Final = 3.0
"""Time allowed for two kills in sequence [s]."""
NO_DESCRIPTORS: Final = 2.0
"""Time in which a process cannot open files [s]; if no spare engine is ready, none can be started in this time."""


@dataclass(slots=True)
class Acts:
    """Actions on one show. Thread: one."""

    page: FaultPage
    tree: Tree
    disk: SmallDisk
    folder: Path
    seed: int
    sites: list[Site]
    ports: dict[str, int]
    """Its ports on this machine, by purpose."""
    gone: Callable[[], bool]
    """Returns whether the show has ended."""
    start_again: Callable[[], None]
    """Starts the same command again, as a person or a service manager would."""

    def do(self, blow: Blow) -> str:
        """Execute a fault; return a description of its target (empty: there was none)."""
        return ACTS[blow.kind](self, blow)

    def wait(self, until: Callable[[], bool], seconds: float) -> bool:
        """Wait for a condition; False after a time-out or when the show has ended."""
        deadline = time.monotonic() + seconds
        while not until():
            if time.monotonic() > deadline or self.gone():
                return False
            time.sleep(0.01)
        return True

    def _raise(self, blow: Blow, times: int) -> str:
        page, site = self.page, self.sites[blow.which % len(self.sites)]
        if site.of_the_mechanism and times == ALWAYS:
            times = 3
        page[Word.RAISED], page[Word.LEFT] = 0, times
        page[Word.SINCE] = page[Word.TICK] + 8
        page[Word.SITE] = 1 + blow.which % len(self.sites)
        deadline = time.monotonic() + 6.0  # some sites are reached only at a measure line, or never again
        while not page[Word.RAISED] and time.monotonic() < deadline and not self.gone():
            time.sleep(0.01)
        return str(site) if page[Word.RAISED] else ""

    def _raise_in_thread(self, blow: Blow) -> str:
        page = self.page
        page[Word.THREAD_WHICH] = blow.which
        page[Word.THREAD] = page[Word.THREAD] + 1
        self.wait(lambda: page[Word.THREAD] == page[Word.THREAD_DONE], 2.0)
        with contextlib.suppress(OSError, IndexError):
            return (self.folder / THREADS).read_text(encoding="utf-8").splitlines()[-1]
        return ""

    def _raise_in_calls(self, blow: Blow) -> str:
        page = self.page
        page[Word.CALLS_RAISED], page[Word.CALLS_WHICH] = 0, blow.which
        page[Word.CALLS] = 1 + int(20 * blow.size)
        self.wait(lambda: page[Word.CALLS] <= 0, 3.0)
        return f"{page[Word.CALLS_RAISED]} callbacks"

    def _engine(self) -> int:
        return self.page[Word.PID]

    def _of_role(self, *roles: str) -> list[int]:
        engine = self._engine()
        return [pid for pid, role in self.tree.roles().items() if role in roles and pid != engine]

    def _kill(self, pids: list[int]) -> str:
        return ", ".join(str(pid) for pid in pids if self.tree.signal(pid, signal.SIGKILL))

    def _kill_twice(self, blow: Blow) -> str:
        first = self._engine()
        told = self._kill([first])
        self.wait(lambda: self._engine() != first, 8.0)
        second = self._engine()
        return f"{told}, {self._kill([second])}" if second != first else told

    def _kill_supervisor(self, blow: Blow) -> str:
        pid = self.tree.supervisor
        self.tree.lose()
        time.sleep(0.2 + 3.0 * blow.size)
        self.start_again()
        return f"{pid}; the next one is {self.tree.supervisor}"

    def _stop(self, pid: int, seconds: float) -> str:
        self.tree.signal(pid, signal.SIGSTOP)
        try:
            time.sleep(seconds)
        finally:
            self.tree.signal(pid, signal.SIGCONT)
        return f"{pid} for {seconds:.1f} s"

    def _stop_in_bursts(self, blow: Blow) -> str:
        end, pids = time.monotonic() + 2.0, [one.pid for one in self.tree.below()]
        while time.monotonic() < end:
            for number, wait in ((signal.SIGSTOP, 0.08), (signal.SIGCONT, 0.04)):
                for pid in pids:
                    self.tree.signal(pid, number)
                time.sleep(wait)
        return f"{len(pids)} processes for 80 of 120 ms"

    def _starve(self, blow: Blow) -> str:
        count = 3 * (os.cpu_count() or 1)
        loop = "import time; end = time.monotonic() + 4.0\nwhile time.monotonic() < end: pass"
        loops = [subprocess.Popen([sys.executable, "-S", "-c", loop]) for _ in range(count)]
        try:
            for one in loops:
                one.wait(30.0)
        finally:
            for one in loops:
                one.kill()
                one.wait()
        return f"{count} busy loops for 4 s"

    def _fill_disk(self, blow: Blow) -> str:
        page = self.page
        really = self.disk.fill()
        page[Word.DISK] = 0 if really else errno.ENOSPC
        time.sleep(1.0 + 2.0 * blow.size)
        page[Word.DISK] = 0
        self.disk.free()
        return "a small file system, really full" if really else "every write is refused"

    def _lock_disk(self, blow: Blow) -> str:
        page = self.page
        page[Word.DISK] = errno.EROFS
        time.sleep(1.0 + 2.0 * blow.size)
        page[Word.DISK] = 0
        return "every write is refused"

    def _take_descriptors(self, pid: int, seconds: float, *, and_kill: bool = False) -> str:
        with few_descriptors(pid):
            if and_kill:
                self._kill([self._engine()])
            time.sleep(seconds)
        return f"{pid} for {seconds:.1f} s"

    def _step_clock(self, blow: Blow) -> str:
        page = self.page
        milliseconds = int((-1) ** blow.which * 10 ** (3.0 + 5.0 * blow.size))
        page[Word.CLOCK] = milliseconds
        time.sleep(2.0)
        page[Word.CLOCK] = 0
        return f"by {milliseconds / 1e3:.0f} s and back"

    def _cut(self, port: int, blow: Blow) -> str:
        """Open connections that send part of a request, then reset them or leave them half open."""
        chance, done = np.random.default_rng([self.seed, blow.which]), 0
        left = []
        for number in range(40):
            with contextlib.suppress(OSError):
                one = socket.create_connection(("127.0.0.1", port), timeout=0.5)
                one.sendall(
                    (b"GET /ws HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\n" + chance.bytes(64))[: 10 + 3 * number]
                )
                if number % 4:
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                    one.close()
                else:
                    left.append(one)
                done += 1
        time.sleep(0.5)
        for one in left:
            one.close()
        return f"{done} connections"

    def _cut_osc(self, blow: Blow) -> str:
        """Send valid and invalid packets from ports that are closed at once, so that replies are refused."""
        chance = np.random.default_rng([self.seed, blow.which])
        for _ in range(60):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one, contextlib.suppress(OSError):
                data = b"/dance/ping\0,\0\0\0" if chance.random() < 0.5 else chance.bytes(int(chance.integers(1, 900)))
                one.sendto(data, ("127.0.0.1", self.ports["osc"]))
        return "60 packets"

    def _cut_wire(self, blow: Blow) -> str:
        page = self.page
        engine = self._engine()
        page[Word.CUT] = engine
        self.wait(lambda: page[Word.CUT] == 0, 3.0)
        return str(engine)


def stall_of(blow: Blow) -> float:
    """Return the expected pause of ticks caused by the fault itself [s]."""
    return STALLS[blow.kind](blow.size) if blow.kind in STALLS else 0.0


STALLS: Final[dict[str, Callable[[float], float]]] = {
    "stop engine briefly": lambda size: 0.3 + 0.9 * size, "stop engine": lambda size: 3.0 + 2.0 * size,
    "stop all in bursts": lambda size: 2.0, "starve": lambda size: 4.0, "kill engine twice": lambda size: TWICE_WITHIN,
    "no descriptors in the supervisor": lambda size: NO_DESCRIPTORS,
}  # fmt: skip
"""Expected pause of ticks caused by the fault itself [s], as a function of the fault's size."""

ACTS: Final[dict[str, Callable[[Acts, Blow], str]]] = {
    "exception once": lambda acts, blow: acts._raise(blow, 1),
    "exception three times": lambda acts, blow: acts._raise(blow, 3),
    "exception always": lambda acts, blow: acts._raise(blow, ALWAYS),
    "exception in a thread": Acts._raise_in_thread,
    "exception in callbacks": Acts._raise_in_calls,
    "kill engine": lambda acts, blow: acts._kill([acts._engine()]),
    "kill engine twice": Acts._kill_twice,
    "kill spare": lambda acts, blow: acts._kill(acts._of_role("spare", "heir")[:1]),
    "kill nursery": lambda acts, blow: acts._kill(acts._of_role("nursery")[:1]),
    "kill sound": lambda acts, blow: acts._kill(acts.tree.sound()[:1]),
    "kill supervisor": Acts._kill_supervisor,
    "stop engine briefly": lambda acts, blow: acts._stop(acts._engine(), 0.3 + 0.9 * blow.size),
    "stop engine": lambda acts, blow: acts._stop(acts._engine(), 3.0 + 2.0 * blow.size),
    "stop supervisor": lambda acts, blow: acts._stop(acts.tree.supervisor, 1.0 + 2.0 * blow.size),
    "stop all in bursts": Acts._stop_in_bursts,
    "starve": Acts._starve,
    "disk full": Acts._fill_disk,
    "disk read-only": Acts._lock_disk,
    "no descriptors in the engine": lambda acts, blow: acts._take_descriptors(acts._engine(), NO_DESCRIPTORS),
    "no descriptors in the supervisor": lambda acts, blow: acts._take_descriptors(
        acts.tree.supervisor, NO_DESCRIPTORS, and_kill=True
    ),
    "clock steps": Acts._step_clock,
    "cut web": lambda acts, blow: acts._cut(acts.ports["web"], blow),
    "cut audience": lambda acts, blow: acts._cut(acts.ports["audience"], blow),
    "cut OSC": Acts._cut_osc,
    "cut the engine's wire": Acts._cut_wire,
}
"""Handlers by kind of fault; each returns a description of its target (empty: there was none)."""
