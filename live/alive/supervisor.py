"""Supervisor: starts the processes of a show, watches their hearts, and lets another engine go on where one ended.

It holds no device, no window and no array: what does so little does not fail. It runs in the process that the person
started, so the terminal, its signals and the exit code are its own. One loop, no threads but the journal's writer.
"""

import signal
import socket
from collections.abc import Callable
from typing import Any, Final

from live.alive.child import Child
from live.alive.disk import Disk
from live.alive.engines import Engines
from live.alive.orders import Orders, Report
from live.alive.reaper import Reaper
from live.alive.remote import Remote
from live.alive.side import Side
from live.alive.starter import Starter

TELL_EVERY: Final = 1.0
SETTLED: Final = 30.0
"""Seconds that an engine has run before its memory is judged."""


class Supervisor:
    """Runs a show until it ends. Thread: the one that made it."""

    def __init__(self, orders: Orders, say: Callable[[str], None]) -> None:
        """`say`: tells the person a line."""
        self._orders, self._say = orders, say
        self.report = Report()
        self._starter = Starter()
        self._reaper = Reaper()
        self._disk = Disk(orders.journal, say)
        self._sound = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) if orders.audio else None
        inherit = {} if orders.osc is None else {"osc": orders.osc.fileno()}
        if self._sound is not None:
            inherit["sound"] = self._sound[0].fileno()
        self.engines = Engines(orders, self._starter, self.report, say, inherit)
        self.engines.on_line, self.engines.on_asked = self._pass_on, self._obey
        fullscreen, monitor = orders.screen
        self.engines.screen = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor}
        self.audio, self.guard = Side(self._start_audio, say), Side(self._start_guard, say)
        self._remote = Remote(orders, self._starter, self.engines, self.report, say)
        self._tell_at = 0.0

    def run(self) -> int:
        """Start everything, keep it going, and return the exit code of the engine that ended well (or could not)."""
        try:
            if self._orders.audio:
                self.audio.child = self._start_audio()
            if self._orders.guard:
                self.guard.child = self._start_guard()
            while self.engines.code is None:
                self._turn()
            return self.engines.code
        except (KeyboardInterrupt, SystemExit) as ended:
            number = signal.SIGINT if isinstance(ended, KeyboardInterrupt) else int(str(ended.code)) - 128
            return self.engines.leave(number)
        finally:
            self._close()

    def _turn(self) -> None:
        now = self._starter.turn()
        self.engines.look(now)
        slowdown = self._starter.load.slowdown
        self.audio.look(now, slowdown)
        self.guard.look(now, slowdown)
        self._reaper.look(now)
        self._remote.look(now)
        if now >= self._tell_at:
            self._tell_at = now + TELL_EVERY
            self._tell(now)

    def _pass_on(self, line: str, kept: bool) -> None:
        self._remote.pass_on(line)
        if kept:
            self._disk.put(line)

    def _obey(self, asked: dict[str, Any]) -> None:
        """What an engine asks of the others."""
        if asked["alive"] == "screen":
            self.engines.screen = asked
            if self.guard.child is not None:
                self.guard.child.wire.tell(**asked)
        elif asked["alive"] == "takeover":
            self._remote.take_over("on command")
        elif asked["alive"] == "cannot":
            self._remote.cannot(asked["why"])
        elif asked["alive"] == "following":
            self.report.compared, self.report.different = asked["compared"], asked["different"]
            self.report.repaired = asked["repaired"]

    def _start_audio(self) -> Child:
        assert self._sound is not None
        theirs = self._sound[1].fileno()
        return self._starter.start("audio", [*self._orders.audio, str(theirs)], lambda line: None, theirs)

    def _start_guard(self) -> Child:
        child = self._starter.start("guard", self._orders.guard, lambda line: None)
        child.wire.tell(**self.engines.screen)
        return child

    def _tell(self, now: float) -> None:
        """Tell the engine how all are, and judge its memory."""
        engine, since = self.engines.engine, self.engines.since
        children = (engine, self.engines.spare, self.engines.nursery.child, self.audio.child, self.guard.child)
        self.report.memory_mb = {one.role: round(one.memory() / 1e6, 1) for one in children if one is not None}
        self.report.disk = self._disk.facts()
        self.report.slowdown, self.report.reaped = round(self._starter.load.slowdown, 2), self._reaper.count
        self.report.audio_restarts, self.report.guard = self.audio.restarts, self.guard.child is not None
        if engine is None or since is None:
            return
        engine.wire.tell(alive="facts", facts=self.engines.facts())
        if 0 < self._orders.budget < engine.memory() and self.report.spare and now - since > SETTLED:
            self._say("the engine needs more memory than it may")
            engine.kill()

    def _close(self) -> None:
        self._remote.close()
        self.engines.close()
        self.audio.close()
        self.guard.close()
        for one in self._sound or ():
            one.close()
        if self._orders.osc is not None:
            self._orders.osc.close()
        self._starter.close()
        for note in self._disk.close():
            self._say(note)
