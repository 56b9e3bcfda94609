"""Remote: other machines. Who stands by follows the leader's lines over TCP, and takes over when it falls silent.

Every machine has an epoch. Who takes over counts one on and says so to the old leader, over the wire it followed or a
new one, until that has heard it; who hears of a higher epoch than its own is fenced: it goes dark and stops sending.
"""

import contextlib
import json
import signal
import socket
from collections.abc import Callable
from typing import Any, Final

from live import __version__
from live.alive.engines import Engines
from live.alive.orders import Orders, Report
from live.alive.starter import Starter
from live.alive.wire import Wire

SILENCE: Final = 0.3
"""Seconds without a line of a running show after which its leader counts as gone."""
AGAIN: Final = 0.5
"""Seconds between two attempts to reach a machine."""
FOLLOWERS: Final = 8
LONGEST_WHY: Final = 400
"""Characters of a reason that another machine gives."""
PARTING: Final = 2.0
"""Seconds in which a machine that cannot stand by waits at its end until the other one has read why."""
BACKLOG: Final = 64 * 1024 * 1024
"""Bytes that may wait for a follower; one that reads so slowly follows no more."""


class Remote:
    """Both sides of it; a machine without either does nothing here. Thread: the supervisor's."""

    def __init__(
        self, orders: Orders, starter: Starter, engines: Engines, report: Report, say: Callable[[str], None]
    ) -> None:
        self._starter, self._engines, self._report, self._say = starter, engines, report, say
        self._lead = orders.lead
        self._followers: list[Wire] = []
        self._follow = orders.follow
        self._leader: Wire | None = None
        self._try_at = 0.0
        self._heard: float | None = None
        self._now = 0.0
        self._commanded = False
        self._parting = False
        if self._lead is not None:
            self._lead.setblocking(False)
            starter.selector.register(self._lead, 1, self._accept)
        if self._follow is not None:
            report.follows = "{}:{}".format(*self._follow)
            engines.role = "standby"
            signal.signal(signal.SIGUSR1, self._command)

    @property
    def _stands_by(self) -> bool:
        return bool(self._report.follows)

    def look(self, now: float) -> None:
        """Send what waits, reach who is to be reached, and judge the silence."""
        self._now = now
        for wire in [wire for wire in self._followers if wire.ended or wire.dropped]:
            self._drop(wire)
        for wire in self._followers:
            wire.flush()
        self._report.followers = len(self._followers)
        if self._follow is None:
            return
        if self._leader is not None and self._leader.ended:
            self._starter.forget(self._leader)
            self._leader.close()
            self._leader = None
            if self._heard is not None and self._engines.code is None:
                self.take_over("for its leader has gone")
        if self._leader is None and now >= self._try_at:
            self._try_at = now + AGAIN
            self._reach(*self._follow)
        if self._leader is not None:
            self._leader.flush()
        if not self._stands_by:
            return
        if self._commanded:
            self.take_over("on command")
        elif self._heard is not None and now - self._heard > SILENCE and now - self._starter.awake > SILENCE:
            self.take_over(f"after {now - self._heard:.2f} s of silence")

    def take_over(self, why: str) -> None:
        """Lead from now on, if this machine stands by and knows the show."""
        self._commanded = False
        if not self._stands_by:
            return
        if not self._engines.log.header:
            self._say("this machine cannot take over: it has not heard of a show yet")
            return
        self._report.silent_s = None if self._heard is None else round(self._now - self._heard, 3)
        self._report.follows = ""
        self._report.epoch += 1
        self._engines.role = "heir"
        self._say(f"this machine takes over {why} (epoch {self._report.epoch})")
        self._engines.go()
        self._claim()

    def pass_on(self, line: str) -> None:
        """A line of the show, to all who follow."""
        if self._report.fenced:
            return
        for wire in self._followers:
            wire.put(line)

    def cannot(self, why: str) -> None:
        """This machine cannot stand by: let the one that leads hear it as well."""
        if self._stands_by and self._leader is not None:
            self._leader.tell(alive="cannot", why=why)
            self._parting = True

    def close(self) -> None:
        """Close all that is open."""
        for wire in self._followers:
            wire.flush()
            wire.close()
        if self._leader is not None:
            self._leader.part(PARTING if self._parting else 0.0)
        if self._lead is not None:
            self._lead.close()

    def _command(self, _number: int, _frame: object) -> None:
        self._commanded = True

    # -- the side that leads -------------------------------------------------------------------------------------

    def _accept(self) -> None:
        assert self._lead is not None
        with contextlib.suppress(OSError):
            sock, _ = self._lead.accept()
            if len(self._followers) >= FOLLOWERS:
                sock.close()
                return
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            wire = Wire(sock, backlog=BACKLOG)
            self._followers.append(wire)
            self._starter.listen(wire, lambda line: self._hear_follower(wire, line))
            wire.tell(alive="leader", epoch=self._report.epoch, version=__version__)
            if not self._report.fenced:
                for line in self._engines.log.since():
                    wire.put(line)

    def _hear_follower(self, wire: Wire, line: str) -> None:
        told = _told(line)
        epoch = told.get("epoch")
        if told.get("alive") == "cannot":
            self._say(f"a machine that wanted to stand by cannot: {one_line(told.get('why'))}")
            self._drop(wire)
            return
        if told.get("alive") != "lead" or not isinstance(epoch, int):
            self._drop(wire)
        elif epoch > self._report.epoch and not self._report.fenced:
            self._report.fenced = True
            self._say(f"another machine leads now (epoch {epoch}, this is {self._report.epoch}): this one is dark")
            if self._engines.engine is not None:
                self._engines.engine.wire.tell(alive="facts", facts=self._engines.facts())

    def _drop(self, wire: Wire) -> None:
        self._starter.forget(wire)
        wire.close()
        if wire in self._followers:
            self._followers.remove(wire)

    # -- the side that follows -----------------------------------------------------------------------------------

    def _reach(self, host: str, port: int) -> None:
        try:
            sock = socket.create_connection((host, port), timeout=0.1)
        except OSError:
            return
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        wire = self._leader = Wire(sock)
        self._starter.listen(wire, self._hear_leader)
        if not self._stands_by:
            self._claim()

    def _claim(self) -> None:
        """Tell the old leader that it leads no more."""
        if self._leader is not None:
            self._leader.tell(alive="lead", epoch=self._report.epoch)

    def _hear_leader(self, line: str) -> None:
        if not self._stands_by:
            return  # what the old leader still says is the past
        told = _told(line)
        if "alive" in told:
            self._greet(told)
            return
        if not told:
            return
        if told.get("end"):
            self._say("the leader has ended the show")
            self._engines.code = 0
            return
        if "tick" in told:
            self._heard = self._now
        self._engines.take(line)
        if self._engines.engine is not None:
            self._engines.engine.wire.put(line)

    def _greet(self, told: dict[str, Any]) -> None:
        version, epoch = told.get("version"), told.get("epoch")
        if version != __version__:
            why = f"the leader is of version {version}, this machine of {__version__}"
            self.cannot(why)
            self._say(f"{why}: it cannot be followed; install the same version on both")
            self._engines.code = 2
        if isinstance(epoch, int):
            self._report.epoch = max(self._report.epoch, epoch)


def one_line(words: object) -> str:
    """What another machine says, as one short line that does nothing to a terminal."""
    return "".join(mark if mark.isprintable() else " " for mark in str(words)[:LONGEST_WHY])


def _told(line: str) -> dict[str, Any]:
    """What a line says; nothing if it makes no sense."""
    try:
        told = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}
