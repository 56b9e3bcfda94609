"""Adoption: a restarted supervisor finds its show's engine, which has lost its supervisor, and takes charge of it.

The engine keeps running meanwhile. The data comes from a process of the same user (`rendezvous.py`), but is checked all
the same.
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
from live.base.system.features import LINUX
from live.base.system.shared_page import SharedPage
from live.show.journal.line_writer import UnfinishedFile, WriteProgress
from live.supervisor.adoption.hung_engine import kill_if_hung, socket_holders
from live.supervisor.adoption.rendezvous import ENDING, parse_first_line, path_in_folder, private_folder, same_user
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.line_channel import ChannelError, LineChannel

ANSWERS_WITHIN: Final = 6.0
"""Seconds for an engine without a supervisor to answer: it checks once per frame, and a frame may be slow."""
TRANSFER_TIMEOUT: Final = 20.0
"""Seconds for the transfer of the show so far."""
MAX_DESCRIPTORS: Final = 16
"""Most descriptors that are received."""
KNOWN_DESCRIPTORS: Final = ("heart", "process", "rendezvous", "osc", "sound", "sound_peer")
REQUIRED_DESCRIPTORS: Final = ("heart", "process", "rendezvous")
PAUSE: Final = 0.05
UNKNOWN_EXIT_CODE: Final = 1
"""Exit code used for a process that is no child; an exit code it has announced itself takes precedence."""


class CannotAdopt(Exception):
    """An engine of this show runs without a supervisor and cannot be adopted; the message says why."""


class EngineHung(Exception):
    """An engine of this show hung without a supervisor and was killed: the show resumes from its journal."""


class AdoptedProcess:
    """Process that is no child of this one, with the interface of `subprocess.Popen`.

    The system reports an exit code only to the parent, so the code is `UNKNOWN_EXIT_CODE`.
    """

    def __init__(self, pid: int, descriptor: int) -> None:
        """`descriptor`: of pidfd_open(2), so that a process that reuses the number is never addressed."""
        self.pid = pid
        self._descriptor = descriptor
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return `UNKNOWN_EXIT_CODE` once it has ended; None while it runs."""
        if self._code is None and select.select([self._descriptor], [], [], 0)[0]:
            self._code = UNKNOWN_EXIT_CODE
            os.close(self._descriptor)
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        """Wait until it has ended; raises `subprocess.TimeoutExpired` after `timeout` seconds."""
        if self.poll() is None:
            select.select([self._descriptor], [], [], timeout)
        if (code := self.poll()) is None:
            raise subprocess.TimeoutExpired("", timeout or 0.0)
        return code

    def send_signal(self, number: int) -> None:
        """Send it a signal if it still runs."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._descriptor, number)

    def kill(self) -> None:
        """Kill it if it still runs."""
        self.send_signal(signal.SIGKILL)


@dataclass(slots=True)
class Adoption:
    """State of an adopted engine."""

    name: str
    """Name of the socket at which it was found."""
    channel: LineChannel
    heartbeat: Heartbeat
    process: AdoptedProcess
    descriptors: dict[str, int]
    """Received descriptors: rendezvous, and osc, sound, sound_peer if they exist."""
    show: str
    facts: dict[str, Any]
    screen: dict[str, Any]
    unwritten: UnfinishedFile
    """Journal lines to write once the engine has stopped writing."""
    snapshots_kept: int
    lines: list[str] = field(default_factory=list)
    """The show so far, as returned by `RecoveryLog.since`."""
    early_lines: list[str] = field(default_factory=list)
    """Lines that the engine has sent since."""


def find_engine(label: str) -> Adoption | None:
    """Adopt the engine that runs without a supervisor; None if there is none. `label`: of the show.

    CannotAdopt if there is one that cannot be adopted, EngineHung if there was one that had to be killed.
    """
    with _sockets(f"{label}.") as paths:
        for name, path in paths.items():
            if (found := _adopt_at(name, path)) is not None:
                return found
    return None


def end_engines(label: str) -> list[int]:
    """Ask engines without a supervisor to end, as a signal would; return their process numbers. `label`: prefix of the
    names."""
    ended = []
    with _sockets(label) as paths:
        for path in paths.values():
            sock = None
            with contextlib.suppress(TimeoutError):
                sock = _connect(path)
            if sock is None:
                continue
            with sock, contextlib.suppress(OSError, ValueError):
                sock.sendall(b'{"alive":"end"}\n')
                told = parse_first_line(sock.recv(1 << 12))
                if told.get("alive") == "ends":
                    ended.append(int(told["pid"]))
    return ended


@contextlib.contextmanager
def _sockets(begin: str) -> Iterator[dict[str, str]]:
    """Yield the sockets whose names begin with `begin`, with paths that are valid within the context."""
    try:
        folder = private_folder() if LINUX else None
    except OSError:
        folder = None
    if folder is None:
        yield {}
        return
    try:
        names = sorted(name for name in os.listdir(folder) if name.startswith(begin) and name.endswith(ENDING))
        yield {name: path_in_folder(folder, name) for name in names}
    finally:
        os.close(folder)


def _connect(path: str) -> socket.socket | None:
    """Return a connection; None if no process listens any more, in which case the name is removed.

    TimeoutError if the queue is full: a process listens but does not accept.
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


def _adopt_at(name: str, path: str) -> Adoption | None:
    try:
        sock = _connect(path)
    except TimeoutError:
        _end_if_hung(name, path, lambda: False)
        return None
    if sock is None:
        return None
    descriptors: list[int] = []
    try:
        sock.sendall(f'{{"alive":"adopt","version":"{__version__}"}}\n'.encode())
        words, descriptors = _receive_hello(sock)
        return _read_adoption(name, sock, words, descriptors)
    except (OSError, ValueError, KeyError, TypeError, ChannelError) as error:
        for descriptor in descriptors:
            with contextlib.suppress(OSError):
                os.close(descriptor)
        if isinstance(error, TimeoutError):
            with sock:
                _end_if_hung(name, path, lambda: bool(select.select([sock], [], [], 0)[0]))
            return None
        sock.close()
        if isinstance(error, OSError):  # the engine has ended
            return None
        raise CannotAdopt(f"the engine's answer is not valid: {error!r:.80}") from None
    except BaseException:
        sock.close()
        raise


def _end_if_hung(name: str, path: str, answers: Callable[[], bool]) -> None:
    """Watch the engine: EngineHung if it hung and was killed, CannotAdopt if it is slow; returns if it has ended."""
    killed = kill_if_hung(name, answers)
    if killed:
        with contextlib.suppress(OSError):
            os.unlink(path)
        numbers = ", ".join(map(str, killed))
        raise EngineHung(f"an engine (process {numbers}) without a supervisor hung and was killed")
    if socket_holders(name):
        raise CannotAdopt("an engine without a supervisor does not answer yet: try again")


def _receive_hello(sock: socket.socket) -> tuple[bytes, list[int]]:
    """Return the first line with any data after it, and the descriptors; ConnectionError if the engine has gone."""
    words, descriptors = b"", []
    deadline = time.monotonic() + ANSWERS_WITHIN
    while b"\n" not in words:
        sock.settimeout(max(0.01, deadline - time.monotonic()))
        data, found, _, _ = socket.recv_fds(sock, 1 << 16, MAX_DESCRIPTORS)
        descriptors += found
        words += data
        if not data or len(words) > 1 << 20:
            raise ConnectionError("the engine has gone")
    return words, descriptors


def _read_adoption(name: str, sock: socket.socket, words: bytes, found: list[int]) -> Adoption | None:
    told = parse_first_line(words)
    if told.get("alive") == "refused":
        sock.close()
        if told.get("supervised"):
            return None
        raise CannotAdopt(f"{told.get('why')!s:.200}; to end it: kill {told.get('pid')!s:.12}")
    names = told["descriptors"]
    known = len(names) == len(found) and set(REQUIRED_DESCRIPTORS) <= set(names) <= set(KNOWN_DESCRIPTORS)
    if told["alive"] != "engine" or not known or not words.endswith(b"\n"):
        raise ValueError(names)
    descriptors = dict(zip(names, found, strict=True))
    if not isinstance(told["facts"], dict) or not isinstance(told["screen"], dict) or not isinstance(told["show"], str):
        raise TypeError(told["alive"])
    heart = Heartbeat(SharedPage.of_descriptor(descriptors.pop("heart")))
    process = AdoptedProcess(int(told["pid"]), descriptors.pop("process"))
    lines: list[str] = []
    wire = LineChannel(sock)
    deadline = time.monotonic() + TRANSFER_TIMEOUT
    while '{"alive":"adopted"}' not in lines:
        if wire.ended:
            raise ConnectionError("the engine has gone")
        if time.monotonic() > deadline:
            raise TimeoutError
        select.select([sock], [], [], PAUSE)
        lines += wire.read_lines()
    rest = parse_first_line(lines[0].encode())
    count, end = int(rest["lines"]), lines.index('{"alive":"adopted"}')
    owed, since = lines[1 : 1 + count], lines[1 + count : end]
    written = WriteProgress(0, int(rest["end"]), int(rest["missing"]))
    return Adoption(
        name, wire, heart, process, descriptors, told["show"], told["facts"],
        told["screen"], UnfinishedFile(since[0] if since else "", written, [(0, line) for line in owed]),
        int(rest["snapshots"]), since, lines[end + 1 :],
    )  # fmt: skip
