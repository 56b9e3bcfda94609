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

from live.rehearse.chaos.call_sites import CallSite
from live.rehearse.chaos.fault_page import FaultPage, PageWord
from live.rehearse.chaos.fault_plan import ChaosFault
from live.rehearse.chaos.injection import THREADS_FILE
from live.rehearse.chaos.process_tree import ProcessTree, limited_descriptors
from live.rehearse.chaos.small_disk import SmallDisk

UNLIMITED: Final = 1 << 30
TWO_KILLS_SECONDS: Final = 3.0
"""Time allowed for two kills in sequence [s]."""
NO_DESCRIPTORS_SECONDS: Final = 2.0
"""Time in which a process cannot open files [s]; if no spare engine is ready, none can be started in this time."""


@dataclass(slots=True)
class FaultActions:
    """Actions on one show. Thread: one."""

    page: FaultPage
    tree: ProcessTree
    disk: SmallDisk
    folder: Path
    seed: int
    sites: list[CallSite]
    ports: dict[str, int]
    """Its ports on this machine, by purpose."""
    has_ended: Callable[[], bool]
    """Returns whether the show has ended."""
    restart: Callable[[], None]
    """Starts the same command again, as a person or a service manager would."""

    def execute(self, blow: ChaosFault) -> str:
        """Execute a fault; return a description of its target (empty: there was none)."""
        return ACTIONS[blow.kind](self, blow)

    def wait_for(self, until: Callable[[], bool], seconds: float) -> bool:
        """Wait for a condition; False after a time-out or when the show has ended."""
        deadline = time.monotonic() + seconds
        while not until():
            if time.monotonic() > deadline or self.has_ended():
                return False
            time.sleep(0.01)
        return True

    def _raise(self, blow: ChaosFault, times: int) -> str:
        page, site = self.page, self.sites[blow.selector % len(self.sites)]
        if site.is_breaker and times == UNLIMITED:
            times = 3
        page[PageWord.RAISED], page[PageWord.LEFT] = 0, times
        page[PageWord.SINCE] = page[PageWord.TICK] + 8
        page[PageWord.SITE] = 1 + blow.selector % len(self.sites)
        deadline = time.monotonic() + 6.0  # some sites are reached only at a measure line, or never again
        while not page[PageWord.RAISED] and time.monotonic() < deadline and not self.has_ended():
            time.sleep(0.01)
        return str(site) if page[PageWord.RAISED] else ""

    def _raise_in_thread(self, blow: ChaosFault) -> str:
        page = self.page
        page[PageWord.THREAD_WHICH] = blow.selector
        page[PageWord.THREAD] = page[PageWord.THREAD] + 1
        self.wait_for(lambda: page[PageWord.THREAD] == page[PageWord.THREAD_DONE], 2.0)
        with contextlib.suppress(OSError, IndexError):
            return (self.folder / THREADS_FILE).read_text(encoding="utf-8").splitlines()[-1]
        return ""

    def _raise_in_calls(self, blow: ChaosFault) -> str:
        page = self.page
        page[PageWord.CALLS_RAISED], page[PageWord.CALLS_WHICH] = 0, blow.selector
        page[PageWord.CALLS] = 1 + int(20 * blow.severity)
        self.wait_for(lambda: page[PageWord.CALLS] <= 0, 3.0)
        return f"{page[PageWord.CALLS_RAISED]} callbacks"

    def _engine(self) -> int:
        return self.page[PageWord.PID]

    def _of_role(self, *roles: str) -> list[int]:
        engine = self._engine()
        return [pid for pid, role in self.tree.roles().items() if role in roles and pid != engine]

    def _kill(self, pids: list[int]) -> str:
        return ", ".join(str(pid) for pid in pids if self.tree.signal(pid, signal.SIGKILL))

    def _kill_twice(self, blow: ChaosFault) -> str:
        first = self._engine()
        told = self._kill([first])
        self.wait_for(lambda: self._engine() != first, 8.0)
        second = self._engine()
        return f"{told}, {self._kill([second])}" if second != first else told

    def _kill_supervisor(self, blow: ChaosFault) -> str:
        pid = self.tree.supervisor
        self.tree.kill_supervisor()
        time.sleep(0.2 + 3.0 * blow.severity)
        self.restart()
        return f"{pid}; the next one is {self.tree.supervisor}"

    def _stop(self, pid: int, seconds: float) -> str:
        self.tree.signal(pid, signal.SIGSTOP)
        try:
            time.sleep(seconds)
        finally:
            self.tree.signal(pid, signal.SIGCONT)
        return f"{pid} for {seconds:.1f} s"

    def _stop_in_bursts(self, blow: ChaosFault) -> str:
        end, pids = time.monotonic() + 2.0, [one.pid for one in self.tree.descendants()]
        while time.monotonic() < end:
            for number, wait in ((signal.SIGSTOP, 0.08), (signal.SIGCONT, 0.04)):
                for pid in pids:
                    self.tree.signal(pid, number)
                time.sleep(wait)
        return f"{len(pids)} processes for 80 of 120 ms"

    def _starve(self, blow: ChaosFault) -> str:
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

    def _fill_disk(self, blow: ChaosFault) -> str:
        page = self.page
        really = self.disk.fill()
        page[PageWord.DISK] = 0 if really else errno.ENOSPC
        time.sleep(1.0 + 2.0 * blow.severity)
        page[PageWord.DISK] = 0
        self.disk.free()
        return "a small file system, really full" if really else "every write is refused"

    def _make_disk_read_only(self, blow: ChaosFault) -> str:
        page = self.page
        page[PageWord.DISK] = errno.EROFS
        time.sleep(1.0 + 2.0 * blow.severity)
        page[PageWord.DISK] = 0
        return "every write is refused"

    def _exhaust_descriptors(self, pid: int, seconds: float, *, and_kill: bool = False) -> str:
        with limited_descriptors(pid):
            if and_kill:
                self._kill([self._engine()])
            time.sleep(seconds)
        return f"{pid} for {seconds:.1f} s"

    def _step_clock(self, blow: ChaosFault) -> str:
        page = self.page
        milliseconds = int((-1) ** blow.selector * 10 ** (3.0 + 5.0 * blow.severity))
        page[PageWord.CLOCK] = milliseconds
        time.sleep(2.0)
        page[PageWord.CLOCK] = 0
        return f"by {milliseconds / 1e3:.0f} s and back"

    def _cut_connections(self, port: int, blow: ChaosFault) -> str:
        """Open connections that send part of a request, then reset them or leave them half open."""
        chance, done = np.random.default_rng([self.seed, blow.selector]), 0
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

    def _cut_osc(self, blow: ChaosFault) -> str:
        """Send valid and invalid packets from ports that are closed at once, so that replies are refused."""
        chance = np.random.default_rng([self.seed, blow.selector])
        for _ in range(60):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one, contextlib.suppress(OSError):
                data = b"/dance/ping\0,\0\0\0" if chance.random() < 0.5 else chance.bytes(int(chance.integers(1, 900)))
                one.sendto(data, ("127.0.0.1", self.ports["osc"]))
        return "60 packets"

    def _cut_link(self, blow: ChaosFault) -> str:
        page = self.page
        engine = self._engine()
        page[PageWord.CUT] = engine
        self.wait_for(lambda: page[PageWord.CUT] == 0, 3.0)
        return str(engine)


def expected_stall(blow: ChaosFault) -> float:
    """Return the expected pause of ticks caused by the fault itself [s]."""
    return STALLS[blow.kind](blow.severity) if blow.kind in STALLS else 0.0


STALLS: Final[dict[str, Callable[[float], float]]] = {
    "stop engine briefly": lambda size: 0.3 + 0.9 * size, "stop engine": lambda size: 3.0 + 2.0 * size,
    "stop all in bursts": lambda size: 2.0, "starve": lambda size: 4.0,
    "kill engine twice": lambda size: TWO_KILLS_SECONDS,
    "no descriptors in the supervisor": lambda size: NO_DESCRIPTORS_SECONDS,
}  # fmt: skip
"""Expected pause of ticks caused by the fault itself [s], as a function of the fault's size."""

ACTIONS: Final[dict[str, Callable[[FaultActions, ChaosFault], str]]] = {
    "exception once": lambda acts, blow: acts._raise(blow, 1),
    "exception three times": lambda acts, blow: acts._raise(blow, 3),
    "exception always": lambda acts, blow: acts._raise(blow, UNLIMITED),
    "exception in a thread": FaultActions._raise_in_thread,
    "exception in callbacks": FaultActions._raise_in_calls,
    "kill engine": lambda acts, blow: acts._kill([acts._engine()]),
    "kill engine twice": FaultActions._kill_twice,
    "kill spare": lambda acts, blow: acts._kill(acts._of_role("spare", "heir")[:1]),
    "kill nursery": lambda acts, blow: acts._kill(acts._of_role("nursery")[:1]),
    "kill sound": lambda acts, blow: acts._kill(acts.tree.audio_processes()[:1]),
    "kill supervisor": FaultActions._kill_supervisor,
    "stop engine briefly": lambda acts, blow: acts._stop(acts._engine(), 0.3 + 0.9 * blow.severity),
    "stop engine": lambda acts, blow: acts._stop(acts._engine(), 3.0 + 2.0 * blow.severity),
    "stop supervisor": lambda acts, blow: acts._stop(acts.tree.supervisor, 1.0 + 2.0 * blow.severity),
    "stop all in bursts": FaultActions._stop_in_bursts,
    "starve": FaultActions._starve,
    "disk full": FaultActions._fill_disk,
    "disk read-only": FaultActions._make_disk_read_only,
    "no descriptors in the engine": lambda acts, blow: acts._exhaust_descriptors(
        acts._engine(), NO_DESCRIPTORS_SECONDS
    ),
    "no descriptors in the supervisor": lambda acts, blow: acts._exhaust_descriptors(
        acts.tree.supervisor, NO_DESCRIPTORS_SECONDS, and_kill=True
    ),
    "clock steps": FaultActions._step_clock,
    "cut web": lambda acts, blow: acts._cut_connections(acts.ports["web"], blow),
    "cut audience": lambda acts, blow: acts._cut_connections(acts.ports["audience"], blow),
    "cut OSC": FaultActions._cut_osc,
    "cut the engine's wire": FaultActions._cut_link,
}
"""Handlers by kind of fault; each returns a description of its target (empty: there was none)."""
