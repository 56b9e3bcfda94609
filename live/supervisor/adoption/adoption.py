"""Adoption: a supervisor that begins anew finds the engine of its show that lost its own, and takes it over.

The engine dances on meanwhile. What comes is of this user's own process (`rendezvous.py`), and is checked all the same.
"""

import contextlib
import os
import select
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final

from live import __version__
from live.show.journal.journal_writer import Unwritten, Written
from live.supervisor.adoption.hung_engine import end_if_hung, holders
from live.supervisor.adoption.rendezvous import ENDING, in_folder, own_folder, same_user, told_by
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import Wire, WireBroken

ANSWERS_WITHIN: Final = 6.0
"""Seconds in which an engine that is alone answers: it looks after each frame, and may have a slow one."""
REST_WITHIN: Final = 20.0
"""Seconds in which the show so far is told."""
MOST: Final = 16
"""Descriptors that come along."""
KNOWN: Final = ("heart", "process", "rendezvous", "osc", "sound", "sound_peer")
NEEDED: Final = ("heart", "process", "rendezvous")
PAUSE: Final = 0.05
UNKNOWN: Final = 1
"""The exit code of a process that is not this one's child; its own word of how it ended goes before."""


class CannotAdopt(Exception):
    """An engine of this show dances without a supervisor, and cannot be taken over; says why."""


class EngineHung(Exception):
    """An engine of this show danced without a supervisor, hung and was ended: the show goes on from its journal."""


class Adopted:
    """A process that is not this one's child, as `subprocess.Popen` shows its own.

    How it ended the system tells its parent only: the code is `UNKNOWN`.
    """

    def __init__(self, pid: int, descriptor: int) -> None:
        """`descriptor`: of pidfd_open(2), so that no other process of that number is ever meant."""
        self.pid = pid
        self._descriptor = descriptor
        self._code: int | None = None

    def poll(self) -> int | None:
        """`UNKNOWN` once it has ended; None while it lives."""
        if self._code is None and select.select([self._descriptor], [], [], 0)[0]:
            self._code = UNKNOWN
            os.close(self._descriptor)
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; `subprocess.TimeoutExpired` after so many seconds."""
        if self.poll() is None:
            select.select([self._descriptor], [], [], timeout)
        if (code := self.poll()) is None:
            raise subprocess.TimeoutExpired("", timeout or 0.0)
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it still lives."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._descriptor, number)


@dataclass(slots=True)
class Adoption:
    """All that is known of an engine that has been taken over."""

    name: str
    """Of the socket at which it was found."""
    wire: Wire
    heart: Heartbeat
    process: Adopted
    descriptors: dict[str, int]
    """Those of its others that this process has now: rendezvous; osc, sound, sound_peer if there are such."""
    show: str
    facts: dict[str, Any]
    screen: dict[str, Any]
    unwritten: Unwritten
    """What is to be written of the journal, once the engine says that it writes no more."""
    snapshots_kept: int
    lines: list[str] = field(default_factory=list)
    """The show so far, as `Log.since` tells it."""
    early: list[str] = field(default_factory=list)
    """What the engine has said since."""


def find_engine(label: str) -> Adoption | None:
    """Take over the engine that dances alone; None if there is none. `label`: which show it is.

    CannotAdopt if there is one that cannot be had, EngineHung if there was one that had to be ended.
    """
    with _sockets(f"{label}.") as paths:
        for name, path in paths.items():
            if (found := _ask(name, path)) is not None:
                return found
    return None


def end_engines(label: str) -> list[int]:
    """Tell engines that dance alone to end, as a signal would; their numbers. `label`: how the names begin."""
    ended = []
    with _sockets(label) as paths:
        for path in paths.values():
            sock = None
            with contextlib.suppress(TimeoutError):
                sock = _reached(path)
            if sock is None:
                continue
            with sock, contextlib.suppress(OSError, ValueError):
                sock.sendall(b'{"alive":"end"}\n')
                told = told_by(sock.recv(1 << 12))
                if told.get("alive") == "ends":
                    ended.append(int(told["pid"]))
    return ended


@contextlib.contextmanager
def _sockets(begin: str) -> Iterator[dict[str, str]]:
    """The sockets whose names begin so, with their paths; they hold within the context."""
    try:
        folder = own_folder()
    except OSError:
        yield {}
        return
    try:
        names = sorted(name for name in os.listdir(folder) if name.startswith(begin) and name.endswith(ENDING))
        yield {name: in_folder(folder, name) for name in names}
    finally:
        os.close(folder)


def _reached(path: str) -> socket.socket | None:
    """A connection; None where nobody listens any more, and then the name is forgotten.

    TimeoutError where so many wait already that somebody listens, and never looks.
    """
    sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    sock.settimeout(ANSWERS_WITHIN)
    try:
        sock.connect(path)
        if same_user(sock):
            return sock
    except ConnectionRefusedError:
        with contextlib.suppress(OSError):
            os.unlink(path)
    except BlockingIOError:
        sock.close()
        raise TimeoutError from None
    except OSError:
        pass
    sock.close()
    return None


def _ask(name: str, path: str) -> Adoption | None:
    try:
        sock = _reached(path)
    except TimeoutError:
        _end_if_hung(name, path, lambda: False)
        return None
    if sock is None:
        return None
    descriptors: list[int] = []
    try:
        sock.sendall(f'{{"alive":"adopt","version":"{__version__}"}}\n'.encode())
        words, descriptors = _hello(sock)
        return _taken_over(name, sock, words, descriptors)
    except (OSError, ValueError, KeyError, TypeError, WireBroken) as error:
        for descriptor in descriptors:
            with contextlib.suppress(OSError):
                os.close(descriptor)
        if isinstance(error, TimeoutError):
            with sock:
                _end_if_hung(name, path, lambda: bool(select.select([sock], [], [], 0)[0]))
            return None
        sock.close()
        if isinstance(error, OSError):  # who had the socket has ended
            return None
        raise CannotAdopt(f"what the engine says makes no sense: {error!r:.80}") from None
    except BaseException:
        sock.close()
        raise


def _end_if_hung(name: str, path: str, answers: Callable[[], bool]) -> None:
    """EngineHung if it hung and has been ended; CannotAdopt if it is only slow; neither if it has ended by itself."""
    killed = end_if_hung(name, answers)
    if killed:
        with contextlib.suppress(OSError):
            os.unlink(path)
        numbers = ", ".join(map(str, killed))
        raise EngineHung(f"an engine (process {numbers}) danced without a supervisor and hung: it was ended")
    if holders(name):
        raise CannotAdopt("an engine that dances alone does not answer yet: try again")


def _hello(sock: socket.socket) -> tuple[bytes, list[int]]:
    """The first line with what came after it, and the descriptors; ConnectionError if nobody says anything."""
    words, descriptors = b"", []
    deadline = time.monotonic() + ANSWERS_WITHIN
    while b"\n" not in words:
        sock.settimeout(max(0.01, deadline - time.monotonic()))
        data, found, _, _ = socket.recv_fds(sock, 1 << 16, MOST)
        descriptors += found
        words += data
        if not data or len(words) > 1 << 20:
            raise ConnectionError("the engine has gone")
    return words, descriptors


def _taken_over(name: str, sock: socket.socket, words: bytes, found: list[int]) -> Adoption | None:
    told = told_by(words)
    if told.get("alive") == "refused":
        sock.close()
        if told.get("supervised"):
            return None
        raise CannotAdopt(f"{told.get('why')!s:.200}; to end it: kill {told.get('pid')!s:.12}")
    names = told["descriptors"]
    known = len(names) == len(found) and set(NEEDED) <= set(names) <= set(KNOWN)
    if told["alive"] != "engine" or not known or not words.endswith(b"\n"):
        raise ValueError(names)
    descriptors = dict(zip(names, found, strict=True))
    if not isinstance(told["facts"], dict) or not isinstance(told["screen"], dict) or not isinstance(told["show"], str):
        raise TypeError(told["alive"])
    heart = Heartbeat(descriptors.pop("heart"))
    process = Adopted(int(told["pid"]), descriptors.pop("process"))
    lines: list[str] = []
    wire = Wire(sock)
    deadline = time.monotonic() + REST_WITHIN
    while '{"alive":"adopted"}' not in lines:
        if wire.ended:
            raise ConnectionError("the engine has gone")
        if time.monotonic() > deadline:
            raise TimeoutError
        select.select([sock], [], [], PAUSE)
        lines += wire.lines()
    rest = told_by(lines[0].encode())
    count, end = int(rest["lines"]), lines.index('{"alive":"adopted"}')
    owed, since = lines[1 : 1 + count], lines[1 + count : end]
    written = Written(0, int(rest["end"]), int(rest["missing"]))
    return Adoption(
        name, wire, heart, process, descriptors, told["show"], told["facts"],
        told["screen"], Unwritten(since[0] if since else "", written, [(0, line) for line in owed]),
        int(rest["snapshots"]), since, lines[end + 1 :],
    )  # fmt: skip
