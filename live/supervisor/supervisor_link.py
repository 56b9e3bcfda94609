"""Lifeline: an engine's end of what joins it to its supervisor; without a supervisor there is none."""

import contextlib
import json
import os
import socket
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NoReturn

from live.show.journal.journal_writer import Unwritten, Written
from live.supervisor.adoption.rendezvous import Rendezvous, hand_over, tell_the_rest
from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import Wire
from live.supervisor.recovery_log import Log

LONGEST: Final = 200
"""Characters of an error's own words."""
CRASHED: Final = 70
"""The exit code of an engine that ended in an error of the program (EX_SOFTWARE of sysexits.h)."""


@dataclass(frozen=True, slots=True)
class Brief:
    """What a child is told first."""

    role: str
    """engine: begins the show; spare: prepares itself and waits; heir: goes on at once."""
    show: str


class Lifeline:
    """The wire and the heart of an engine. Thread: the one that runs the show.

    If the supervisor dies the show goes on; nobody takes over from it until another supervisor adopts this engine
    (`live.supervisor.adoption.rendezvous`).
    """

    def __init__(self, wire: Wire, heart: Heartbeat) -> None:
        self.wire = wire
        self.heart = heart
        self.phase = Phase.STARTING
        self.facts: dict[str, Any] = {}
        """What the supervisor said last of itself and the others."""
        self.orders: list[dict[str, Any]] = []
        """What it asked for and nobody has taken up yet."""
        self.lines: list[str] = []
        """Lines of the show that it passed on, and nobody has taken up yet."""
        self.osc: int | None = None
        """The descriptor of the socket where OSC is received, if the supervisor holds one."""
        self.osc_reader: int | None = None
        """The same of the socket to the process that reads that one, if there is such a process."""
        self.sound: int | None = None
        """The same of the socket to the process that listens or plays."""
        self.sound_peer: int | None = None
        """The same of that process' own end, for another supervisor."""
        self.log = Log()
        """What another supervisor needs of the show so far; whoever goes on with a show puts in what it was told."""
        self.written: Written | None = None
        """How far the lines of this wire have come to the disk, as the supervisor says."""
        self.snapshots_kept = 0
        """Bytes of the file of snapshots that stay."""
        self.on_adopted: Callable[[], Unwritten] = lambda: Unwritten(self.log.header, Written(), ())
        """Asked for the lines that another supervisor is to write."""
        self._rendezvous: Rendezvous | None = None
        self._screen: dict[str, Any] = {}
        self._show = ""
        self._told_tick = -1
        self._told_following: dict[str, int] = {}

    @classmethod
    def inherited(cls, wire: int, heart: int) -> "Lifeline":
        """From the descriptors that the supervisor left to this process."""
        return cls(Wire(socket.socket(fileno=wire)), Heartbeat(heart))

    @property
    def alone(self) -> bool:
        """Whether the supervisor has gone."""
        return self.wire.ended

    def brief(self) -> Brief:
        """What this process is for; waits for the first line."""
        self.wire.socket.setblocking(True)
        line = b""
        while not line.endswith(b"\n"):
            piece = self.wire.socket.recv(1)
            if not piece:
                raise SystemExit(1)  # the supervisor has gone before it said a word
            line += piece
        self.wire.socket.setblocking(False)
        told = json.loads(line)
        self.osc, self.sound, self.sound_peer = told.get("osc"), told.get("sound"), told.get("sound_peer")
        self.osc_reader = told.get("osc_reader")
        self._show = told["show"]
        if told.get("rendezvous") is not None:
            self._rendezvous = Rendezvous(told["rendezvous"])
        return Brief(told["alive"], told["show"])

    def listen(self) -> None:
        """Read what has come: facts are kept, orders and lines of the show put where they are taken up."""
        for line in self.wire.lines():
            if not line.startswith('{"alive"'):
                self.lines.append(line)
                continue
            told = json.loads(line)
            if told["alive"] == "written":
                self.written = Written(told["line"], told["end"], told["missing"])
                self.snapshots_kept = told["snapshots"]
                continue
            self.facts = told.get("facts", self.facts)
            if told["alive"] == "anew":
                self.lines.clear()  # of another show
            if told["alive"] != "facts":
                self.orders.append(told)

    def wait(self, seconds: float) -> None:
        """Wait until something comes, or so long."""
        import select

        select.select([self.wire.socket], [], [], seconds)

    def order(self, name: str) -> dict[str, Any] | None:
        """Take up an order of that name, if there is one."""
        found = next((order for order in self.orders if order["alive"] == name), None)
        if found is not None:
            self.orders.remove(found)
        return found

    def beat(self, tick: int, phase: Phase | None = None) -> None:
        """I live."""
        self.phase = self.phase if phase is None else phase
        self.heart.beat(tick, self.phase)

    def frame(self, tick: int) -> None:
        """After each frame of the show: the ticks have come so far."""
        self.log.tick = tick
        if self.alone:
            self.beat(tick, Phase.RUNNING)
            self._look_for_a_supervisor()
            return
        if tick != self._told_tick:
            self._told_tick = tick
            self.wire.put(f'{{"tick":{tick}}}')
        self.wire.flush()
        self.beat(tick, Phase.RUNNING)
        self.listen()

    def _look_for_a_supervisor(self) -> None:
        """Give all that another one needs to the first that comes."""
        sock = None if self._rendezvous is None else self._rendezvous.look()
        if sock is None or self._rendezvous is None:
            return
        names = {"osc": self.osc, "sound": self.sound, "sound_peer": self.sound_peer}
        descriptors = {name: number for name, number in names.items() if number is not None}
        descriptors |= {"heart": self.heart.descriptor, "rendezvous": self._rendezvous.fileno()}
        told = {"facts": self.facts, "screen": self._screen, "show": self._show}
        if not hand_over(sock, told, descriptors):
            return
        self.wire.renew(sock)
        tell_the_rest(self.wire, self.on_adopted(), self.snapshots_kept, self.log)

    def say(self, line: str) -> None:
        """A line of the show that its journal's writer does not put."""
        self.log.take(line)
        self.wire.put(line)

    def tell_screen(self, fullscreen: bool, monitor: str, *others: str) -> None:
        """The picture is full screen on that monitor now, or in a window."""
        self._screen = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor, "others": list(others)}
        self.wire.tell(**self._screen)

    def tell_following(self, facts: dict[str, int]) -> None:
        """How well this machine follows another, if that has changed."""
        if facts != self._told_following:
            self._told_following = facts
            self.wire.tell(alive="following", **facts)

    def tell_end(self, code: int) -> None:
        """Somebody wanted this show to end, with this exit code: without this word the end of a process is a crash."""
        self.wire.tell(alive="end", code=code)
        self.wire.flush()

    def crash(self, error: BaseException) -> NoReturn:
        """End this process at once, for an error that nobody asked for: another engine goes on."""
        self.wire.tell(alive="crash", why=in_words(error))
        traceback.print_exception(error)
        with contextlib.suppress(OSError, ValueError):
            self.wire.flush()
            sys.stderr.flush()
        os._exit(CRASHED)

    def tell_note(self, words: str) -> None:
        """Something the person has to know."""
        self.wire.tell(alive="note", words=words)

    @property
    def may_leave(self) -> bool:
        """Whether a signal to end is meant for the show, and not only for this process: the supervisor has said so, or
        there is none."""
        self.listen()
        return self.alone or self.order("leave") is not None

    @property
    def fenced(self) -> bool:
        """Whether another machine leads, and this one is to be dark: the supervisor says so, or it has gone while a
        machine stood by that was ready, which takes over then."""
        return bool(self.facts.get("fenced")) or (self.alone and bool(self.facts.get("deputy")))

    def status(self) -> dict[str, Any]:
        """For the status line."""
        there = {"supervised": not self.alone, "dropped": self.wire.dropped, **self.facts}
        return there | {"spare": False, "guard": False} if self.alone else there


def in_words(error: BaseException) -> str:
    """An error of the program in one short line, with the place it came from."""
    place = traceback.extract_tb(error.__traceback__)[-1:]
    where = "".join(f" in {'/'.join(Path(frame.filename).parts[-2:])}, line {frame.lineno}" for frame in place)
    words = " ".join(str(error).split())
    return "".join(mark if mark.isprintable() else " " for mark in f"{type(error).__name__}: {words[:LONGEST]}{where}")


def nobody_left(lifeline: Lifeline) -> bool:
    """Whether supervisor and parent have gone, so that a process that only waits should end."""
    return lifeline.alone or os.getppid() == 1
