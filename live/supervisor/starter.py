"""Starter: starts processes and hears what they say; the one place that selects."""

import selectors
import time
from collections.abc import Callable, Sequence
from typing import Final

from live.supervisor.child import Child, Process
from live.supervisor.procfs import machine
from live.supervisor.watchdog import MachineLoad
from live.supervisor.wire import Wire, WireBroken

ROUND: Final = 0.02
"""Seconds between two looks at the hearts."""
SLEPT: Final = 0.5
"""A round that took so long [s] was one in which this process itself did not run."""

READ_EVERY: Final = 0.25
"""Seconds between two readings of how loaded the machine is."""

Hear = Callable[[str], None]


class Starter:
    """The selector, and all wires in it. Thread: the supervisor's."""

    def __init__(self) -> None:
        self.selector = selectors.DefaultSelector()
        self.awake = time.monotonic()
        """When this process itself was last found to have slept: nobody's silence before that means death."""
        self.load = MachineLoad(ROUND)
        """How loaded the machine is."""
        self._read_at = 0.0
        self.meanwhile: Callable[[float], None] = lambda now: None
        """Called while somebody's rest is heard: other machines shall not take that for silence."""

    def turn(self) -> float:
        """Hear what comes within a round; the time [s, monotonic]."""
        before = time.monotonic()
        ready = self.selector.select(ROUND)
        woken = time.monotonic()
        self.load.woke(max(woken - before - ROUND, 0.0), woken - before)
        for key, _ in ready:
            key.data()
        now = time.monotonic()
        if now - before > SLEPT:
            self.awake = now
        if now >= self._read_at:
            self._read_at = now + READ_EVERY
            self.load.read(now, machine())
        return now

    def start(
        self,
        role: str,
        command: Sequence[str],
        hear: Hear,
        *inherit: int,
        born: Callable[[int, int], Process] | None = None,
    ) -> Child:
        """Start a process (see `Child`); `hear` gets every line it says."""
        child = Child(role, command, inherit=inherit, born=born)
        self.listen(child.wire, hear, child.kill)
        return child

    def listen(self, wire: Wire, hear: Hear, broken: Callable[[], None] = lambda: None) -> None:
        """Hear what comes over a wire, until it ends; `broken`: what it said made no sense."""

        def read() -> None:
            try:
                lines = wire.lines()
            except WireBroken:
                lines, wire.ended = [], True
                broken()
            if wire.ended:
                self.forget(wire)
            for line in lines:
                wire.heard += 1
                hear(line)

        self.selector.register(wire.socket, selectors.EVENT_READ, read)

    def forget(self, wire: Wire) -> None:
        """Hear it no more; harmless if it was not heard."""
        if wire.fileno() >= 0 and wire.socket in self.selector.get_map():
            self.selector.unregister(wire.socket)

    def hear_rest(self, wire: Wire, within: float, *, dead: bool = False) -> None:
        """Hear a wire to its end: what was said last counts, however its process ended. `dead`: it says nothing more,
        so that all there will be is there."""
        if dead:
            self.turn()
            return
        deadline = time.monotonic() + within
        while not wire.ended and time.monotonic() < deadline:
            self.meanwhile(self.turn())

    def close(self) -> None:
        """Select no more."""
        self.selector.close()
