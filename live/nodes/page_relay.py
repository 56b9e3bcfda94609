"""The operator's page and the studio on any paired machine: a browser's connections, relayed over the bus.

A browser connects to an *entrance*, on the machine beside it. The entrance sends its bytes, signed as everything on the
bus, to the *exit* of the machine that leads, which connects to the page's own server there. Login and checks stay that
server's. The entrance alone checks which machine the browser meant (`Host`), because only it knows its own addresses; a
header that a browser cannot know tells the server that this was done.
"""

import asyncio
import contextlib
import re
import secrets
import socket
import time
from collections.abc import Callable, Iterable
from typing import Any, Final

from live.control.message_codec import PacketError
from live.control.web.http_protection import accepted_hosts
from live.control.web.web_key import RELAY_HEADER, relay_token
from live.nodes import messages
from live.nodes.byte_flow import CHUNK, ByteFlow
from live.nodes.messages import PageFrame, Pulse
from live.nodes.signed_bus import SignedBus

MOST_CONNECTIONS: Final = 64
"""Most connections of an end."""
HEAD_TIMEOUT: Final = 5.0
"""Seconds within which a browser sends the head of its request."""
MUTE_AFTER: Final = 2.0
"""Seconds after which a leader that is not heard is not asked for pages."""
UPDATE_EVERY: Final = 0.1
CONNECTION: Final = 16
"""Bytes of a connection's number."""
_HEADER: Final = re.compile(rb"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([^\r\n]*?)[ \t]*")


def admitted_head(head: bytes, address: str, port: int, names: tuple[str, ...]) -> bytes | None:
    """Return the head of a request as it is relayed; None for one that does not name this machine.

    `address`, `port`: where it has arrived; `names`: see `accepted_hosts`. Each connection carries one request, so that
    no second one escapes this check.
    """
    lines = head.removesuffix(b"\r\n\r\n").split(b"\r\n")
    found = [_HEADER.fullmatch(line) for line in lines[1:]]
    if not all(found):
        return None
    headers = [(match[1].lower(), match[2]) for match in found if match is not None]
    hosts = [value for name, value in headers if name == b"host"]
    if len(hosts) != 1 or hosts[0].decode("latin-1").casefold() not in accepted_hosts(address, port, names):
        return None
    if any(name in (b"content-length", b"transfer-encoding") for name, _ in headers):
        return None  # no request of the page has a body
    upgrades = any(name == b"upgrade" for name, _ in headers)
    dropped = {RELAY_HEADER.lower().encode()} | (set() if upgrades else {b"connection"})
    kept = [line for line, (name, _) in zip(lines[1:], headers, strict=True) if name not in dropped]
    return b"\r\n".join((lines[0], *kept, *(() if upgrades else (b"Connection: close",)), b"", b""))


def announced_head(head: bytes, token: str) -> bytes:
    """Return the head with the word that its host has been checked."""
    first, mark, rest = head.partition(b"\r\n")
    return first + mark + f"{RELAY_HEADER}: {token}\r\n".encode() + rest


def refusal(status: str, words: str) -> bytes:
    """Return an answer to a request that is not relayed."""
    text = words.encode()
    head = (
        f"HTTP/1.1 {status}\r\nContent-Type: text/plain; charset=utf-8\r\nContent-Length: {len(text)}\r\n"
        "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
    )
    return head.encode() + text


class RelayEnd:
    """One end of relayed connections: those of an entrance or an exit. Thread: the loop's."""

    def __init__(self, bus: SignedBus, name: str, now: Callable[[], float] = time.monotonic) -> None:
        """`name`: by which the other ends reach this one."""
        self._bus, self.name, self._now = bus, name, now
        self._flows: dict[bytes, tuple[str, ByteFlow, asyncio.Event]] = {}
        self.refused = 0
        """Messages that were invalid."""
        loop = asyncio.get_running_loop()

        def arrive(data: bytes) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(self._hear, data)

        bus.receive(messages.page_key(name), arrive)

    async def run(self) -> None:
        """Keep connections going, until it is cancelled."""
        while True:
            await asyncio.sleep(UPDATE_EVERY)
            self._bus.refresh()
            now = self._now()
            for _, flow, changed in list(self._flows.values()):
                flow.update(now)
                if flow.failed:
                    changed.set()

    def _hear(self, data: bytes) -> None:
        try:
            frame = messages.decode(data, PageFrame)
        except PacketError:
            self.refused += 1
            return
        held = self._flows.get(frame.connection)
        if held is None:
            self._handle_unknown(frame)
            return
        if frame.sender != held[0]:
            self.refused += 1
            return
        self._feed(frame)

    def _feed(self, frame: PageFrame) -> None:
        _, flow, changed = self._flows[frame.connection]
        try:
            flow.receive(frame.kind, frame.offset, frame.read, frame.data, self._now())
        except ValueError:
            self.refused += 1
            flow.failed = True
        changed.set()

    def _handle_unknown(self, frame: PageFrame) -> None:
        """Handle a message of a connection that is not known here."""
        if frame.kind in ("data", "end", "ask"):
            self._send(frame.sender, frame.connection, "reset", 0, 0, b"")

    def _send(self, to: str, connection: bytes, kind: str, offset: int, read: int, data: bytes) -> None:
        frame = PageFrame(connection, self.name, kind, offset, read, data)
        self._bus.publish(messages.page_key(to), messages.encode(frame), bulk=True)

    def _open(self, to: str, connection: bytes) -> tuple[ByteFlow, asyncio.Event]:
        flow = ByteFlow(lambda *what: self._send(to, connection, *what))
        changed = asyncio.Event()
        self._flows[connection] = to, flow, changed
        return flow, changed

    async def _carry(self, connection: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Carry bytes between a socket and the bus until both directions have ended or one has failed."""
        to, flow, changed = self._flows[connection]
        reading = asyncio.ensure_future(self._read(flow, reader, changed))
        try:
            while not (flow.failed or flow.done):
                changed.clear()
                while data := flow.take():
                    writer.write(data)
                    await writer.drain()
                    flow.handed_on(len(data))
                if flow.end_received:
                    self._handle_end(flow, writer)
                if reading.done() and reading.exception() is not None:
                    break
                if not (flow.failed or flow.done):
                    await changed.wait()
        except OSError:
            pass
        finally:
            reading.cancel()
            if not flow.done:
                self._send(to, connection, "reset", 0, 0, b"")
            self._flows.pop(connection, None)
            writer.close()

    def _handle_end(self, flow: ByteFlow, writer: asyncio.StreamWriter) -> None:
        """Handle that the other end sends no more, and all that it sent has been written."""
        raise NotImplementedError

    async def _read(self, flow: ByteFlow, reader: asyncio.StreamReader, changed: asyncio.Event) -> None:
        """Send what comes from a socket, as far as there is room."""
        try:
            while not flow.failed:
                if not flow.room:
                    await asyncio.sleep(0.005)
                    continue
                data = await reader.read(min(flow.room, CHUNK))
                if not data:
                    flow.end(self._now())
                    return
                flow.write(data, self._now())
        finally:
            changed.set()

    def close(self) -> None:
        """Break all connections."""
        for _, flow, changed in self._flows.values():
            flow.failed = True
            changed.set()


class Entrance(RelayEnd):
    """Takes browsers' connections and relays them to the machine that leads."""

    def __init__(self, bus: SignedBus, names: Iterable[str], now: Callable[[], float] = time.monotonic) -> None:
        """`names`: host names of this machine, see `accepted_hosts`."""
        super().__init__(bus, secrets.token_hex(8), now)
        self._names = tuple(names)
        self._leaders: dict[str, tuple[float, int]] = {}
        self._used = ""
        loop = asyncio.get_running_loop()

        def arrive(data: bytes) -> None:
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._hear_pulse, data)

        bus.receive(messages.PULSE, arrive)

    def _hear_pulse(self, data: bytes) -> None:
        try:
            pulse = messages.decode(data, Pulse)
        except PacketError:
            self.refused += 1
            return
        self._leaders[pulse.leader] = self._now(), pulse.epoch
        leader = self.leader
        if leader != self._used:  # what goes to the former one would wait in vain
            self._used = leader
            self.close()

    @property
    def leader(self) -> str:
        """The leader that is asked for pages: that of the highest epoch; empty: none is heard."""
        now = self._now()
        self._leaders = {name: held for name, held in self._leaders.items() if now - held[0] < MUTE_AFTER}
        return max(self._leaders, key=lambda name: (self._leaders[name][1], name), default="")

    async def accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Relay one connection of a browser."""
        try:
            async with asyncio.timeout(HEAD_TIMEOUT):
                head = await reader.readuntil(b"\r\n\r\n")
        except (TimeoutError, asyncio.IncompleteReadError, asyncio.LimitOverrunError, OSError):
            writer.close()
            return
        address, port = writer.get_extra_info("sockname")[:2]
        admitted, leader = admitted_head(head, str(address), int(port), self._names), self.leader
        answer = b""
        if admitted is None or len(admitted) > CHUNK:
            answer = refusal("403 Forbidden", "this is not the address of this machine")
            self.refused += 1
        elif not leader:
            answer = refusal("503 Service Unavailable", "no show with --nodes is heard by this machine; try again")
        elif len(self._flows) >= MOST_CONNECTIONS:
            answer = refusal("503 Service Unavailable", "too many connections")
        if admitted is None or answer:
            writer.write(answer)
            with contextlib.suppress(OSError):
                await writer.drain()
            writer.close()
            return
        connection = secrets.token_bytes(CONNECTION)
        flow, _ = self._open(leader, connection)
        flow.write(admitted, self._now())
        await self._carry(connection, reader, writer)

    def _handle_end(self, flow: ByteFlow, writer: asyncio.StreamWriter) -> None:
        flow.end(self._now())  # the answer is complete

    async def serve(self, listening: socket.socket) -> None:
        """Take connections until it is cancelled."""
        server = await asyncio.start_server(self.accept, sock=listening, limit=CHUNK // 2)
        async with server:
            await self.run()


class Exit(RelayEnd):
    """Connects relayed connections to the page's server on this machine."""

    def __init__(
        self, bus: SignedBus, leader: str, server: tuple[str, int], key: str, now: Callable[[], float] = time.monotonic
    ) -> None:
        """`leader`: name of this machine's side of the bus; `key`: of the page."""
        super().__init__(bus, leader, now)
        self._server, self._token = server, relay_token(key.encode())
        self._tasks: set[asyncio.Task[Any]] = set()

    def _handle_unknown(self, frame: PageFrame) -> None:
        begins = frame.kind == "data" and not frame.offset and len(frame.connection) == CONNECTION
        if not begins or len(self._flows) >= MOST_CONNECTIONS or b"\r\n\r\n" not in frame.data:
            super()._handle_unknown(frame)
            return
        self._open(frame.sender, frame.connection)
        self._feed(frame)
        task = asyncio.ensure_future(self._connect(frame.connection))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _handle_end(self, flow: ByteFlow, writer: asyncio.StreamWriter) -> None:
        if writer.can_write_eof():
            writer.write_eof()

    async def _connect(self, connection: bytes) -> None:
        to, flow, _ = self._flows[connection]
        try:
            reader, writer = await asyncio.open_connection(*self._server)
        except OSError:
            self._flows.pop(connection, None)
            self._send(to, connection, "reset", 0, 0, b"")
            return
        head = flow.take()
        writer.write(announced_head(head, self._token))
        flow.handed_on(len(head))
        await self._carry(connection, reader, writer)
