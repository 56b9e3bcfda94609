"""Engine's end of the connection to its supervisor; an engine without a supervisor has none."""

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

from live.base.system.channel import parent_has_gone, stream_of_argument
from live.base.system.features import LINUX
from live.base.system.shared_page import SharedPage
from live.show.journal.line_writer import UnfinishedFile, WriteProgress
from live.supervisor.adoption.rendezvous import EngineRendezvous, send_engine, send_unwritten
from live.supervisor.heartbeat import Heartbeat, Phase
from live.supervisor.line_channel import LineChannel
from live.supervisor.recovery_log import RecoveryLog

MAX_ERROR_LENGTH: Final = 200
"""Most characters of an error's message."""
CRASH_EXIT_CODE: Final = 70
"""Exit code of an engine that ended with a program error (EX_SOFTWARE of sysexits.h)."""


@dataclass(frozen=True, slots=True)
class Brief:
    """First message to a child process."""

    role: str
    """engine: starts the show; spare: prepares itself and waits; heir: resumes the show at once."""
    show: str


class SupervisorLink:
    """Channel and heartbeat of an engine. Thread: the one that runs the show.

    If the supervisor dies, the show goes on. There is no failover until another supervisor adopts this engine
    (`live.supervisor.adoption.rendezvous`).
    """

    def __init__(self, channel: LineChannel, heartbeat: Heartbeat) -> None:
        self.channel = channel
        self.heartbeat = heartbeat
        self.phase = Phase.STARTING
        self.facts: dict[str, Any] = {}
        """The supervisor's last report on itself and the other processes."""
        self.requests: list[dict[str, Any]] = []
        """Requests of the supervisor that have not been handled yet."""
        self.lines: list[str] = []
        """Lines of the show from the supervisor that have not been read yet."""
        self.osc: int | None = None
        """Descriptor of the socket that receives OSC, if the supervisor holds one."""
        self.osc_reader: int | None = None
        """Descriptor of the socket to the OSC reader process, if there is one."""
        self.sound: int | None = None
        """Descriptor of the socket to the audio process."""
        self.sound_peer: int | None = None
        """Descriptor of the audio process' own end, for another supervisor."""
        self.log = RecoveryLog()
        """The show so far, for another supervisor. An engine that resumes a show adds the lines it has received."""
        self.written: WriteProgress | None = None
        """The last line of this channel that the supervisor has confirmed as written."""
        self.snapshots_kept = 0
        """Bytes of the snapshot file that stay."""
        self.on_adopted: Callable[[], UnfinishedFile] = lambda: UnfinishedFile(self.log.header, WriteProgress(), ())
        """Returns the lines that a new supervisor has to write."""
        self._rendezvous: EngineRendezvous | None = None
        self._screen: dict[str, Any] = {}
        self._show = ""
        self._sent_tick = -1
        self._sent_following: dict[str, int] = {}

    @classmethod
    def of_arguments(cls, channel: str, heartbeat: str) -> "SupervisorLink":
        """Make one from the words that the supervisor put at the end of the command line."""
        return cls(LineChannel(stream_of_argument(channel)), Heartbeat(SharedPage.of_argument(heartbeat)))

    @classmethod
    def of_descriptors(cls, channel: int, page: int) -> "SupervisorLink":
        """Make one from the descriptors of both, received from the supervisor (Linux)."""
        return cls(LineChannel(socket.socket(fileno=channel)), Heartbeat(SharedPage.of_descriptor(page)))

    @property
    def orphaned(self) -> bool:
        """Whether the supervisor has gone."""
        return self.channel.ended

    def receive_brief(self) -> Brief:
        """Return the role of this process; waits for the first line."""
        self.channel.socket.setblocking(True)
        line = b""
        while not line.endswith(b"\n"):
            piece = self.channel.socket.recv(1)
            if not piece:
                raise SystemExit(1)  # the supervisor has gone before its first line
            line += piece
        self.channel.socket.setblocking(False)
        told = json.loads(line)
        self.osc, self.sound, self.sound_peer = told.get("osc"), told.get("sound"), told.get("sound_peer")
        self.osc_reader = told.get("osc_reader")
        self._show = told["show"]
        if told.get("rendezvous") is not None:
            self._rendezvous = EngineRendezvous(told["rendezvous"])
        return Brief(told["alive"], told["show"])

    def receive(self) -> None:
        """Read all pending lines: store the report, queue requests and show lines."""
        for line in self.channel.read_lines():
            if not line.startswith('{"alive"'):
                self.lines.append(line)
                continue
            told = json.loads(line)
            if told["alive"] == "written":
                self.written = WriteProgress(told["line"], told["end"], told["missing"])
                self.snapshots_kept = told["snapshots"]
                continue
            self.facts = told.get("facts", self.facts)
            if told["alive"] == "anew":
                self.lines.clear()  # of another show
            if told["alive"] != "facts":
                self.requests.append(told)

    def wait(self, seconds: float) -> None:
        """Wait until a line arrives, at most `seconds`."""
        import select

        select.select([self.channel.socket], [], [], seconds)

    def pop_request(self, name: str) -> dict[str, Any] | None:
        """Remove and return the first request with that name, if there is one."""
        found = next((order for order in self.requests if order["alive"] == name), None)
        if found is not None:
            self.requests.remove(found)
        return found

    def beat(self, tick: int, phase: Phase | None = None) -> None:
        """Send a heartbeat."""
        self.phase = self.phase if phase is None else phase
        self.heartbeat.beat(tick, self.phase)

    def end_frame(self, tick: int) -> None:
        """Report the tick to the supervisor and read its messages. Called after each frame."""
        self.log.tick = tick
        if self.orphaned:
            self.beat(tick, Phase.RUNNING)
            self._hand_over_if_asked()
            return
        if tick != self._sent_tick:
            self._sent_tick = tick
            self.channel.send_line(f'{{"tick":{tick}}}')
        self.channel.flush()
        self.beat(tick, Phase.RUNNING)
        self.receive()

    def _hand_over_if_asked(self) -> None:
        """Hand over to the first supervisor that asks."""
        sock = None if self._rendezvous is None else self._rendezvous.poll()
        if sock is None or self._rendezvous is None:
            return
        names = {"osc": self.osc, "sound": self.sound, "sound_peer": self.sound_peer}
        descriptors = {name: number for name, number in names.items() if number is not None}
        descriptors |= {"heart": self.heartbeat.page.descriptor, "rendezvous": self._rendezvous.fileno()}
        told = {"facts": self.facts, "screen": self._screen, "show": self._show}
        if not send_engine(sock, told, descriptors):
            return
        self.channel.reconnect(sock)
        send_unwritten(self.channel, self.on_adopted(), self.snapshots_kept, self.log)

    def send_line(self, line: str) -> None:
        """Send a line of the show that its journal writer does not send."""
        self.log.add_line(line)
        self.channel.send_line(line)

    def send_screen(self, fullscreen: bool, monitor: str, *others: str) -> None:
        """Report whether the picture is full screen, and on which monitor."""
        self._screen = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor, "others": list(others)}
        self.channel.send_json(**self._screen)

    def send_following(self, facts: dict[str, int]) -> None:
        """Report how well this machine follows another, if that has changed."""
        if facts != self._sent_following:
            self._sent_following = facts
            self.channel.send_json(alive="following", **facts)

    def send_end(self, code: int) -> None:
        """Report that the show ends on request with this exit code. Without this message the end counts as a crash."""
        self.channel.send_json(alive="end", code=code)
        self.channel.flush()

    def crash(self, error: BaseException) -> NoReturn:
        """End this process at once because of a program error: another engine takes over."""
        self.channel.send_json(alive="crash", why=describe_error(error))
        traceback.print_exception(error)
        with contextlib.suppress(OSError, ValueError):
            self.channel.flush()
            sys.stderr.flush()
        os._exit(CRASH_EXIT_CODE)

    def send_note(self, words: str) -> None:
        """Send a note for the person."""
        self.channel.send_json(alive="note", words=words)

    def leave_if_asked(self) -> None:
        """Raise SystemExit if the supervisor asks for the end of the show, where no signal says so."""
        asked = None if LINUX else next((order for order in self.requests if order["alive"] == "leave"), None)
        if asked is not None:
            raise SystemExit(128 + int(asked["signal"]))

    @property
    def may_leave(self) -> bool:
        """Whether a termination signal concerns the show and not only this process: the supervisor has confirmed it, or
        there is no supervisor."""
        self.receive()
        return self.orphaned or self.pop_request("leave") is not None

    @property
    def fenced(self) -> bool:
        """Whether this machine must stay dark because another one leads: the supervisor reports it, or the supervisor
        has gone while a ready standby machine existed, which then takes over."""
        return bool(self.facts.get("fenced")) or (self.orphaned and bool(self.facts.get("deputy")))

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        there = {"supervised": not self.orphaned, "dropped": self.channel.dropped, **self.facts}
        return there | {"spare": False, "guard": False} if self.orphaned else there


def describe_error(error: BaseException) -> str:
    """Return a program error as one short line, with its place in the code."""
    place = traceback.extract_tb(error.__traceback__)[-1:]
    where = "".join(f" in {'/'.join(Path(frame.filename).parts[-2:])}, line {frame.lineno}" for frame in place)
    words = " ".join(str(error).split())
    return "".join(
        mark if mark.isprintable() else " " for mark in f"{type(error).__name__}: {words[:MAX_ERROR_LENGTH]}{where}"
    )


def is_abandoned(link: SupervisorLink) -> bool:
    """Return whether supervisor and parent have gone, so that a waiting process has to end."""
    return link.orphaned or parent_has_gone()
