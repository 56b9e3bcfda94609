"""Rendezvous: the socket at which a restarted supervisor finds an engine that has lost its own, and the hand-over.

The supervisor listens at a socket in a private folder of this user. Every engine inherits the socket. While the
supervisor lives, it refuses all connections. Once it is dead, the engine checks for connections after each frame,
without waiting. Only the same user is accepted (SO_PEERCRED). The engine sends its descriptors (SCM_RIGHTS), then the
show so far.
"""

import contextlib
import json
import os
import signal
import socket
import stat
import struct
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from live import __version__
from live.show.journal.line_writer import UnfinishedFile
from live.supervisor.line_channel import LineChannel
from live.supervisor.recovery_log import RecoveryLog

FOLDER: Final = "choreographics-live"
ENDING: Final = ".sock"
BACKLOG: Final = 4
"""Most connections that wait or are checked at once; further ones are refused."""
PATIENCE: Final = 5.0
"""Seconds for a client to send its request."""
LONGEST_WORD: Final = 4096
"""Most bytes of a request."""


def private_folder() -> int:
    """Return a descriptor of the folder for such sockets; OSError if it cannot be created or is not private."""
    base = os.environ.get("XDG_RUNTIME_DIR", "")
    known = os.path.isabs(base) and os.path.isdir(base)
    path = Path(base) / FOLDER if known else Path(tempfile.gettempdir()) / f"{FOLDER}-{os.getuid()}"
    with contextlib.suppress(FileExistsError):
        path.mkdir(mode=0o700)
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    found = os.fstat(descriptor)
    if found.st_uid != os.getuid() or stat.S_IMODE(found.st_mode) & 0o077:
        os.close(descriptor)
        raise PermissionError(1, f"{path} is not this user's alone")
    return descriptor


def path_in_folder(folder: int, name: str) -> str:
    """Return the path of a file in the folder: short, as socket addresses require, and independent of later renames."""
    return f"/proc/self/fd/{folder}/{name}"


class RendezvousListener:
    """The supervisor's side: listens and refuses all clients while it lives. Thread: the supervisor's."""

    def __init__(self, label: str) -> None:
        """`label`: of the show; OSError if it cannot listen."""
        self.name = f"{label}.{os.getpid()}{ENDING}"
        folder = private_folder()
        try:
            path = path_in_folder(folder, self.name)
            with contextlib.suppress(FileNotFoundError):
                os.unlink(path)
            self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
            try:
                self.socket.bind(path)
                os.chmod(path, 0o600)
                self.socket.listen(BACKLOG)
                self.socket.setblocking(False)
            except OSError:
                self.socket.close()
                raise
        finally:
            os.close(folder)

    @classmethod
    def inherited(cls, descriptor: int, name: str) -> "RendezvousListener":
        """Make one from the socket of the previous supervisor, received from its engine."""
        meeting = cls.__new__(cls)
        meeting.name, meeting.socket = name, socket.socket(fileno=descriptor)
        meeting.socket.setblocking(False)
        return meeting

    def refuse(self) -> None:
        """Refuse a client: this show has a supervisor."""
        with contextlib.suppress(OSError):
            sock, _ = self.socket.accept()
            with sock:
                _answer(sock, alive="refused", why="it has a supervisor", supervised=True)

    def close(self) -> None:
        """Stop listening and remove the socket: the show is over."""
        self.socket.close()
        with contextlib.suppress(OSError):
            folder = private_folder()
            try:
                os.unlink(path_in_folder(folder, self.name))
            finally:
                os.close(folder)


class EngineRendezvous:
    """The engine's side, without a supervisor. Thread: the show's; nothing waits."""

    def __init__(self, descriptor: int) -> None:
        self._socket = socket.socket(fileno=descriptor)
        self._clients: list[tuple[float, socket.socket, bytearray]] = []
        self.refused = 0
        """Refused clients: other users or invalid requests."""

    def fileno(self) -> int:
        """Return the descriptor, to be handed on."""
        return self._socket.fileno()

    def poll(self) -> socket.socket | None:
        """Return the connection of a supervisor that asks for this engine, or None. Accepts at most one client per
        call."""
        now = time.monotonic()
        with contextlib.suppress(OSError):
            sock, _ = self._socket.accept()
            if same_user(sock) and len(self._clients) < BACKLOG:
                sock.setblocking(False)
                self._clients.append((now, sock, bytearray()))
            else:
                self._reject(sock)
        for guest in list(self._clients):
            if (found := self._read_request(guest, now)) is not None:
                return found
        return None

    def _read_request(self, guest: tuple[float, socket.socket, bytearray], now: float) -> socket.socket | None:
        since, sock, words = guest
        try:
            data = sock.recv(LONGEST_WORD)
        except (BlockingIOError, InterruptedError):
            data = None
        except OSError:
            data = b""
        words += data or b""
        if (data is None and now - since < PATIENCE) or (data and b"\n" not in words and len(words) < LONGEST_WORD):
            return None
        self._clients.remove(guest)
        told = parse_first_line(bytes(words))
        if told.get("alive") == "end":
            _answer(sock, alive="ends", pid=os.getpid())
            sock.close()
            os.kill(os.getpid(), signal.SIGTERM)  # as if the person had sent it: everything is closed in order
        elif told.get("alive") != "adopt":
            self._reject(sock)
        elif told.get("version") != __version__:
            why = f"the engine is of version {__version__}, the supervisor of {told.get('version')!s:.40}"
            _answer(sock, alive="refused", why=why, pid=os.getpid())
            self._reject(sock)
        else:
            return sock
        return None

    def _reject(self, sock: socket.socket) -> None:
        self.refused += 1
        sock.close()


def same_user(sock: socket.socket) -> bool:
    """Return whether the other end is a process of this user (SO_PEERCRED of unix(7): pid, uid, gid)."""
    size = struct.calcsize("iII")
    with contextlib.suppress(OSError, struct.error):
        _, uid, _ = struct.unpack("iII", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size))
        return bool(uid == os.getuid())
    return False


def parse_first_line(words: bytes) -> dict[str, Any]:
    """Return the JSON object of the first line; empty if it is not valid."""
    with contextlib.suppress(ValueError, RecursionError):
        told = json.loads(words.partition(b"\n")[0])
        return told if isinstance(told, dict) else {}
    return {}


def send_engine(sock: socket.socket, values: Mapping[str, Any], descriptors: Mapping[str, int]) -> bool:
    """Send the engine's identity and descriptors; return False if the supervisor has gone."""
    process = -1
    try:
        process = os.pidfd_open(os.getpid())
        there = {**descriptors, "process": process}
        hello = {"alive": "engine", "pid": os.getpid(), "descriptors": list(there), **values}
        word = json.dumps(hello, separators=(",", ":")).encode() + b"\n"
        if socket.send_fds(sock, [word], list(there.values())) == len(word):
            return True
    except OSError:
        pass
    finally:
        if process >= 0:
            os.close(process)
    sock.close()
    return False


def send_unwritten(channel: LineChannel, unwritten: UnfinishedFile, kept: int, log: RecoveryLog) -> None:
    """Send the lines to write and those that a spare needs; from then on both ends count lines from zero."""
    written = unwritten.written
    channel.send_json(
        alive="unwritten", number=written.number, end=written.end, missing=written.missing, snapshots=kept,
        lines=len(unwritten.lines),
    )  # fmt: skip
    since = list(log.replay_lines())
    channel.send_line("\n".join([*(line for _, line in unwritten.lines), *since, '{"alive":"adopted"}']))
    channel.sent = 0


def _answer(sock: socket.socket, **told: Any) -> None:
    with contextlib.suppress(OSError):
        sock.send(json.dumps(told, separators=(",", ":")).encode() + b"\n", socket.MSG_NOSIGNAL)
