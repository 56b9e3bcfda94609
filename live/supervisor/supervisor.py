"""Supervisor: starts the processes of a show, watches their heartbeats and replaces a failed engine.

It opens no device and no window and computes nothing, which leaves little that can fail. It runs in the process that
the person started, so it has the terminal, its signals and the exit code. It is one loop without threads, except for
the journal's writer and the one that connects to other machines.
"""

import selectors
import signal
import socket
import time
from collections.abc import Callable
from typing import Any, Final

from live.show.journal.journal_writer import Written
from live.supervisor.adoption.adoption import Adoption
from live.supervisor.adoption.audio_adoption import adopt_sound
from live.supervisor.adoption.journal_resume import CutOff
from live.supervisor.adoption.rendezvous import Meeting
from live.supervisor.engine_failover import Engines
from live.supervisor.line_channel import Wire
from live.supervisor.network.remote_standby import Remote
from live.supervisor.process import Child, Side, Starter
from live.supervisor.process_stats import Reaper
from live.supervisor.recovery_log import Disk
from live.supervisor.supervisor_config import Orders, Report

TELL_EVERY: Final = 1.0
CONFIRM_EVERY: Final = 0.2
WIRES: Final = 40
"""Bits of a line's number for its count on its channel; the bits above count the channels."""
SETTLED: Final = 30.0
"""Seconds that an engine has run before its memory is judged."""


class Supervisor:
    """Runs a show until it ends. Thread: the one that made it."""

    def __init__(
        self, orders: Orders, say: Callable[[str], None], adoption: Adoption | None = None, left: CutOff | None = None
    ) -> None:
        """`say`: prints a line for the person; `adoption`: a running engine whose supervisor has died; `left`: an
        interrupted show of which no process is left."""
        self._orders, self._say = orders, say
        self.report = Report()
        self._starter = Starter()
        self._reaper = Reaper()
        self._disk = Disk(orders.journal, say)
        there = {} if adoption is None else adoption.descriptors
        self._sound = self._sound_pair(there) if orders.audio else None
        self._meeting = self._meet(adoption)
        self._heard = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) if orders.osc_reader else None
        inherit = {} if orders.osc is None else {"osc": orders.osc.fileno()}
        if self._heard is not None:
            inherit["osc_reader"] = self._heard[0].fileno()
        if self._sound is not None:
            inherit |= {"sound": self._sound[0].fileno(), "sound_peer": self._sound[1].fileno()}
        if self._meeting is not None:
            inherit["rendezvous"] = self._meeting.socket.fileno()
        self.engines = Engines(orders, self._starter, self.report, say, inherit)
        self.engines.on_line, self.engines.on_asked = self._pass_on, self._obey
        fullscreen, monitor = orders.screen
        self.engines.screen = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor}
        self.audio, self.guard = Side(self._start_audio, say), Side(self._start_guard, say)
        self.osc_reader = Side(self._start_osc_reader, say)
        self._remote = Remote(orders, self._starter, self.engines, self.report, say)
        self._tell_at = self._confirm_at = 0.0
        self._wire: Wire | None = None
        self._wires = 0  # number of channels that have carried lines of the show
        self._confirmed: tuple[Wire, Written, int] | None = None
        self._writes: Child | None = None
        self._reads: Child | None = None  # an adopted engine that still has its own OSC reader process
        if adoption is not None:
            self._adopt(adoption)
        elif left is not None:
            self.engines.resume(left)
            self._disk.go_on(left.unwritten, left.snapshots_kept)
            self._disk.resume()
        self._starter.meanwhile = self._remote.look

    def run(self) -> int:
        """Start everything, keep it running, and return the exit code of the last engine."""
        try:
            now = time.monotonic()
            if self._orders.audio and self.audio.child is None:
                self.audio.begin(now)
            if self._orders.guard:
                self.guard.begin(now)
            if self._orders.osc_reader and self._reads is None:
                self.osc_reader.begin(now)
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
        self.osc_reader.look(now, slowdown)
        self._reaper.look(now)
        self._remote.look(now)
        if self._writes is not None and self._writes is not self.engines.engine:
            self._write_on()
        if self._reads is not None and self._reads is not self.engines.engine:
            self._reads = None
            self.osc_reader.begin(now)
        if now >= self._confirm_at:
            self._confirm_at = now + CONFIRM_EVERY
            self._confirm()
        if now >= self._tell_at:
            self._tell_at = now + TELL_EVERY
            self._tell(now)

    def _pass_on(self, line: str, kept: bool) -> None:
        self._remote.pass_on(line)
        if kept:
            wire, count = self.engines.mark
            if wire is not self._wire:
                self._wire, self._wires = wire, self._wires + 1
            self._disk.put(line, self._wires << WIRES | count)

    def _confirm(self) -> None:
        """Report to the engine which of its lines are on disk: it keeps them until then."""
        engine, done = self.engines.engine, self._disk.written
        if engine is None or done is None or self._confirmed == (engine.wire, *done):
            return
        self._confirmed = (engine.wire, *done)
        written, kept = done
        own = engine.wire is self._wire and written.number >> WIRES == self._wires
        number = written.number & ((1 << WIRES) - 1) if own else 0
        engine.wire.tell(alive="written", line=number, end=written.end, missing=written.missing, snapshots=kept)

    def _obey(self, asked: dict[str, Any]) -> None:
        """Handle a request of an engine to other parts."""
        if asked["alive"] == "screen":
            self.engines.screen = asked
            if self.guard.child is not None:
                self.guard.child.wire.tell(**asked)
        elif asked["alive"] == "takeover":
            self._remote.take_over("on command")
        elif asked["alive"] == "cannot":
            self._remote.cannot(asked["why"])
        elif asked["alive"] == "journal":
            self._write_on()
        elif asked["alive"] == "following":
            self.report.compared, self.report.different = asked["compared"], asked["different"]
            self.report.repaired = asked["repaired"]
            self._remote.told_following(bool(asked["ready"]))

    # -- adoption of a running engine -----------------------------------------------------------------------------

    def _sound_pair(self, there: dict[str, int]) -> tuple[socket.socket, socket.socket]:
        if "sound" in there and "sound_peer" in there:
            return socket.socket(fileno=there["sound"]), socket.socket(fileno=there["sound_peer"])
        return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)

    def _meet(self, adoption: Adoption | None) -> Meeting | None:
        """Return the socket where another supervisor finds the engine; None if there is none, which matters only if
        this process dies."""
        meeting = None
        if adoption is not None:
            meeting = Meeting.inherited(adoption.descriptors["rendezvous"], adoption.name)
        elif self._orders.label:
            try:
                meeting = Meeting(self._orders.label)
            except OSError as error:
                self._say(f"if this process dies, no other one can adopt the engine: {error.strerror}")
        if meeting is not None:
            self._starter.selector.register(meeting.socket, selectors.EVENT_READ, meeting.refuse)
        return meeting

    def _adopt(self, adoption: Adoption) -> None:
        self.report.restore(adoption.facts)
        self.report.adopted += 1
        self._disk.go_on(adoption.unwritten, adoption.snapshots_kept)
        self.engines.adopt(adoption)
        self._writes = self.engines.engine
        self._reads = self.engines.engine if self._orders.osc_reader else None
        if self._sound is not None:
            self.audio.child = adopt_sound(self._starter, self._sound[0])

    def _write_on(self) -> None:
        """Resume the journal: the adopted engine has stopped writing it."""
        self._writes = None
        self._disk.resume()

    def _start_audio(self) -> Child:
        assert self._sound is not None
        theirs = self._sound[1].fileno()
        return self._starter.start("audio", [*self._orders.audio, str(theirs)], lambda line: None, theirs)

    def _start_guard(self) -> Child:
        child = self._starter.start("guard", self._orders.guard, lambda line: None)
        child.wire.tell(**self.engines.screen)
        return child

    def _start_osc_reader(self) -> Child:
        assert self._heard is not None
        assert self._orders.osc is not None
        theirs = (self._heard[1].fileno(), self._orders.osc.fileno())
        return self._starter.start("OSC", [*self._orders.osc_reader, *map(str, theirs)], lambda line: None, *theirs)

    def _tell(self, now: float) -> None:
        """Send the report to the engine, and check its memory."""
        engine, since = self.engines.engine, self.engines.since
        children = (engine, self.engines.spare, self.engines.nursery.child, self.audio.child, self.guard.child,
                    self.osc_reader.child)  # fmt: skip
        self.report.memory_mb = {one.role: round(one.memory() / 1e6, 1) for one in children if one is not None}
        self.report.disk = self._disk.facts()
        self.report.slowdown, self.report.reaped = round(self._starter.load.slowdown, 2), self._reaper.count
        self.report.audio_restarts, self.report.guard = self.audio.restarts, self.guard.child is not None
        self.report.osc_restarts = self.osc_reader.restarts
        if engine is None or since is None:
            return
        engine.wire.tell(alive="facts", facts=self.engines.facts())
        if 0 < self._orders.budget < engine.memory() and self.report.spare and now - since > SETTLED:
            self._say("the engine uses more memory than allowed: the spare engine replaces it")
            engine.kill()

    def _close(self) -> None:
        self._remote.close()
        self.engines.close()
        self.audio.close()
        self.guard.close()
        self.osc_reader.close()
        for one in (*(self._sound or ()), *(self._heard or ())):
            one.close()
        if self._meeting is not None:
            self._meeting.close()
        if self._orders.osc is not None:
            self._orders.osc.close()
        self._starter.close()
        for note in self._disk.close():
            self._say(note)
