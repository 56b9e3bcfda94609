"""Connections between a process and the children that it starts.

On Linux a child inherits its end of a socket pair, as any other socket. Elsewhere it connects over loopback
(`loopback.py`), packets are framed (`packet_socket.py`), and a child listens itself where its parent did.
"""

import contextlib
import os
import socket
import subprocess
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from live.base.system.features import LINUX
from live.base.system.packet_socket import PacketSocket
from live.base.system.process_control import own_session

if TYPE_CHECKING:
    from live.base.system.loopback import ChildConnection

Packets = socket.socket | PacketSocket
"""An end of a connection of packets, which has `send`, `recv`, `fileno`, `setblocking` and `close`."""
MAX_PACKET_BYTES: Final = 1 << 16
"""Longest packet between the processes of a show."""
CONNECT_POLL: Final = 0.02
"""Seconds between two looks whether a child has connected."""


def start_child(
    command: Sequence[str], *words: str, inherit: Sequence[int] = ()
) -> "tuple[socket.socket | ChildConnection, subprocess.Popen[bytes]]":
    """Start a process with a stream to it; return this end, or one that the process will make, and the process. OSError
    if it cannot be started.

    The command gets a word for its end (`stream_of_argument`) and `words` as its last arguments. `inherit`: descriptors
    that it inherits under the same numbers, on Linux.
    """
    if LINUX:
        return _start_with_pair(socket.socketpair(), command, words, inherit, {})
    from live.base.system.loopback import ChildConnection

    there = ChildConnection(command, words, {})
    return there, there.process


def start_packet_child(
    command: Sequence[str], *, inherit: Sequence[int] = (), **options: Any
) -> "tuple[Packets, subprocess.Popen[bytes]]":
    """Start a process with a connection of packets; return this end, which does not block, and the process.

    Packets that are sent before it is ready wait. The rest is as for `start_child` (`packets_of_argument`); `options`:
    of `subprocess.Popen`.
    """
    if LINUX:
        mine, process = _start_with_pair(packet_pair(), command, (), inherit, options)
        mine.setblocking(False)
        return mine, process
    from live.base.system.loopback import ChildConnection

    there = ChildConnection(command, (), options)
    return PacketSocket(there), there.process


def _start_with_pair(
    pair: tuple[socket.socket, socket.socket], command: Sequence[str], words: Sequence[str], inherit: Sequence[int],
    options: dict[str, Any],
) -> "tuple[socket.socket, subprocess.Popen[bytes]]":  # fmt: skip
    mine, theirs = pair
    try:
        with theirs:
            return mine, subprocess.Popen(
                [*command, str(theirs.fileno()), *words],
                stdin=subprocess.DEVNULL, pass_fds=(theirs.fileno(), *inherit), **own_session(), **options,
            )  # fmt: skip
    except BaseException:
        mine.close()
        raise


def packet_pair() -> tuple[socket.socket, socket.socket]:
    """Return both ends of a connection of packets, for several processes to inherit (Linux)."""
    return socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)


async def receive_packet(channel: Packets) -> bytes:
    """Return the next packet of a channel that does not block, empty if the peer has gone."""
    import asyncio

    loop = asyncio.get_running_loop()
    while True:
        with contextlib.suppress(BlockingIOError):
            return channel.recv(MAX_PACKET_BYTES)
        if isinstance(channel, PacketSocket) and not channel.connected:
            await asyncio.sleep(CONNECT_POLL)
            continue
        ready = asyncio.Event()
        loop.add_reader(channel, ready.set)
        if isinstance(channel, PacketSocket) and channel.unsent:  # the peer may wait for the rest of a question
            loop.add_writer(channel, ready.set)
        try:
            await ready.wait()
        finally:
            loop.remove_reader(channel)
            loop.remove_writer(channel)


def stream_of_argument(word: str) -> socket.socket:
    """Return a child's end of its connection; OSError if the parent has gone."""
    if word.isdecimal():
        return socket.socket(fileno=int(word))
    from live.base.system.loopback import connect_to_parent

    return connect_to_parent(word)


def packets_of_argument(word: str) -> Packets:
    """Return a child's end of its connection of packets; OSError if the parent has gone."""
    sock = stream_of_argument(word)
    return sock if word.isdecimal() else PacketSocket(sock)


def hand_over(sock: socket.socket) -> tuple[int | list[Any], tuple[int, ...]]:
    """Return how a child finds a listening socket (`listening_socket_of`), and the descriptors that it has to inherit.

    Where there are none the socket is closed, because the child listens at its address itself.
    """
    if LINUX:
        return sock.fileno(), (sock.fileno(),)
    where = sock.getsockname()[:2]
    sock.close()
    return list(where), ()


def listening_socket_of(found: int | Sequence[Any]) -> socket.socket:
    """Return in a child the listening socket that its parent handed over; OSError if the port is in use by now."""
    if isinstance(found, int):
        return socket.socket(fileno=found)
    family = socket.AF_INET6 if ":" in found[0] else socket.AF_INET
    return create_server((str(found[0]), int(found[1])), family=family, backlog=1024)


def create_server(where: tuple[str, int], *, family: int, backlog: int) -> socket.socket:
    """Return a listening socket whose port other processes of this user may share, where the system allows that."""
    return socket.create_server(
        where, family=family, backlog=backlog, reuse_port=LINUX and hasattr(socket, "SO_REUSEPORT")
    )


def share_port(sock: socket.socket) -> None:
    """Let other sockets bind the same port, for groups that several programs listen to (multicast)."""
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if hasattr(socket, "SO_REUSEPORT"):
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)


def parent_has_gone() -> bool:
    """Whether this process has lost its parent (Linux gives it to process 1; elsewhere its connection ends)."""
    return LINUX and os.getppid() == 1
