"""Protections that all HTTP servers of a show share: accepted host names, time-outs and connection limits.

A browser sends the requested name (`Host`) and the requesting page (`Origin`); these reveal foreign names that
resolve to this machine (DNS rebinding) and pages of other sites (cross-site requests).
"""

import asyncio
import base64
import functools
import hashlib
import ipaddress
import logging
import re
import socket
import ssl
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass
from typing import Any, Final

from aiohttp import web
from aiohttp.http import HttpProcessingError
from aiohttp.web_protocol import RequestHandler

REQUEST_TIMEOUT: Final = 5.0
"""Time limit [s] for a whole request and its answer, from the connection or the previous answer; then it is closed."""
MAX_WAITING: Final = 384
"""Maximum connections other than open WebSockets; one more closes another."""
MAX_PER_ADDRESS: Final = 128
"""The same for one address (for one /64 of IPv6)."""
ACCEPT_BATCH: Final = 16
"""Connections accepted in one turn of the loop. It is small so that a prompt request is read before MAX_PER_ADDRESS
others arrive.
"""
BACKLOG: Final = 1024
"""Connections that the system queues until they are accepted."""
HEARTBEAT: Final = 4.0
"""Seconds between pings to an open WebSocket; a client that does not answer within half of it is dropped."""
FREE_FAILURES: Final = 10
FAILURES_PER_SECOND: Final = 0.5
"""Wrong keys of one address answered at once: an initial number, then this rate per second."""
WRONG_KEY_DELAY: Final = 1.0
"""Further answers are delayed by this time [s],"""
MAX_DELAYED: Final = 8
"""at most this many at a time; further connections are dropped."""
MOST_GROUPS: Final = 4096
"""Maximum addresses whose failures are stored."""

SECURITY_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
"""Headers of every answer; pages need `page_headers`."""

Answer = Callable[[web.BaseRequest], Awaitable[web.StreamResponse]]


def _is_own_fault(record: logging.LogRecord) -> bool:
    """Whether an error is a fault of this program; network errors are answered, not logged."""
    return record.exc_info is None or not isinstance(record.exc_info[1], HttpProcessingError | ConnectionError)


_LOGGER: Final = logging.getLogger("live.http")
_LOGGER.addFilter(_is_own_fault)


@functools.lru_cache(maxsize=16)
def page_headers(html: str, host: str) -> dict[str, str]:
    """Return the headers of a one-file page: it runs only its own scripts and styles and connects only to this server.

    `host`: an accepted Host; in some browsers 'self' does not include the same server's WebSocket.
    """

    def hashes(tag: str) -> str:
        found = re.findall(rf"<{tag}>(.*?)</{tag}>", html, flags=re.DOTALL)
        made = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in found)
        return " ".join(f"'sha256-{each}'" for each in made) or "'none'"

    policy = (
        f"default-src 'none'; script-src {hashes('script')}; style-src {hashes('style')}; "
        f"connect-src 'self' ws://{host} wss://{host}; img-src data:; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
    return {**SECURITY_HEADERS, "Content-Security-Policy": policy}


# -- host names ------------------------------------------------------------------------------------------------------


@functools.cache
def mdns_name() -> str:
    """Return the name of this machine in its local network."""
    return socket.gethostname().partition(".")[0].casefold() + ".local"


@functools.lru_cache(maxsize=64)
def accepted_hosts(address: str, port: int, names: tuple[str, ...] = ()) -> frozenset[str]:
    """Return the Host headers accepted on a connection to the server's `address` and `port`.

    These are the address itself, localhost if it is loopback or else this machine's local name, and `names`, each a
    host or host:port.
    """
    ip = ipaddress.ip_address(address.partition("%")[0])
    ip = getattr(ip, "ipv4_mapped", None) or ip
    hosts = {f"[{ip}]" if ip.version == 6 else str(ip)}
    hosts |= {"127.0.0.1", "[::1]", "localhost"} if ip.is_loopback else {mdns_name()}
    plain = re.compile(r"(\[[^]]*\]|[^:]*)")
    hosts |= {name.casefold() for name in names if plain.fullmatch(name)}
    whole = {name.casefold() for name in names if not plain.fullmatch(name)} | {f"{host}:{port}" for host in hosts}
    for usual in (80, 443):  # where browsers omit the port
        whole |= {name.removesuffix(f":{usual}") for name in whole if name.endswith(f":{usual}")}
    return frozenset(whole)


def is_same_origin(request: web.BaseRequest, names: Iterable[str] = (), *, host_checked: bool = False) -> bool:
    """Whether a request comes from a program or this server's own page, under an accepted name; not from
    another site. `host_checked`: another machine has checked the name, and relays the request."""
    hosts, origins = request.headers.getall("Host", []), request.headers.getall("Origin", [])
    at = None if request.transport is None else request.transport.get_extra_info("sockname")
    if at is None or len(hosts) != 1 or len(origins) > 1:
        return False
    host = hosts[0].casefold()
    if not host_checked and host not in accepted_hosts(str(at[0]), int(at[1]), tuple(names)):
        return False
    return not origins or origins[0].casefold() in (f"http://{host}", f"https://{host}")


def is_local_host(host: str, link_host: str = "") -> bool:
    """Whether a Host header names this machine: by number, as localhost or .local, or as in its own link.

    For the phones' gateway, which has a key of its own; other servers use `is_same_origin`.
    """
    if len(host) > 255:
        return False
    name = re.sub(r":\d{1,5}$", "", host).casefold()
    if host.casefold() == link_host.casefold() != "" or name == "localhost":
        return True
    if re.fullmatch(r"[a-z0-9-]+\.local", name):
        return True
    try:
        ipaddress.ip_address(name.removeprefix("[").removesuffix("]"))
    except ValueError:
        return False
    return True


def address_group(address: str) -> str:
    """Return a sender's address; for IPv6 its /64, because a device can use any number of addresses in it."""
    try:
        ip = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    ip = getattr(ip, "ipv4_mapped", None) or ip
    return str(ip) if ip.version == 4 else str(ipaddress.ip_network((int(ip), 64), strict=False))


# -- wrong keys ------------------------------------------------------------------------------------------------------


class FailedKeys:
    """Rate limit on answers to wrong keys; a right key is always answered at once. Thread: a loop's.

    The key's length protects against guessing; this limit keeps guessing slow and cheap to answer.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        """`now`: monotonic seconds."""
        self._now = now
        self._left: dict[str, tuple[float, float]] = {}
        self._held: dict[str, int] = {}
        self.count = 0

    def may_answer(self, group: str) -> bool:
        """Count a wrong key; return whether it may be answered at once."""
        now = self._now()
        left, at = self._left.pop(group, (float(FREE_FAILURES), now))
        left = min(left + (now - at) * FAILURES_PER_SECOND, float(FREE_FAILURES))
        self._left[group] = (max(left - 1.0, 0.0), now)
        if len(self._left) > MOST_GROUPS:
            del self._left[next(iter(self._left))]  # the oldest failure
        self.count += 1
        return left >= 1.0

    async def answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request with a wrong key or none."""
        group = address_group(request.remote or "")
        if self.may_answer(group):
            return web.Response(status=401, headers=SECURITY_HEADERS)
        if self._held.get(group, 0) >= MAX_DELAYED:
            if request.transport is not None:
                request.transport.abort()
            return web.Response(status=429)
        self._held[group] = self._held.get(group, 0) + 1
        try:
            await asyncio.sleep(WRONG_KEY_DELAY)
        finally:
            self._held[group] -= 1
            if not self._held[group]:
                del self._held[group]
        response = web.Response(status=429, headers={**SECURITY_HEADERS, "Retry-After": "5"})
        response.force_close()
        return response


# -- time and connection limits --------------------------------------------------------------------------------------


@dataclass(eq=False, slots=True)
class _Connection:
    """A connection other than an open WebSocket."""

    group: str
    transport: asyncio.Transport
    timer: asyncio.TimerHandle
    within: float
    """Time limit of the present answer [s]."""
    has_request: bool = False
    """Whether a whole request has arrived and is not answered yet."""


class BoundedServer(web.Server):
    """aiohttp server with a time limit of REQUEST_TIMEOUT that never refuses a new connection.

    Half-open connections, slow headers, slow bodies and unread answers are closed. At the connection limit, the address
    with the most connections loses one: the oldest without a request. Opening thousands of connections therefore closes
    only one's own, and a prompt request is answered even from the same address. Thread: a loop's.
    """

    def __init__(
        self, answer: Answer, *, most: int = MAX_WAITING, most_of_one: int = MAX_PER_ADDRESS,
        within: float = REQUEST_TIMEOUT,
    ) -> None:  # fmt: skip
        """`answer`: handler of requests without a body; requests with a body are refused."""
        super().__init__(
            self._handle_request, keepalive_timeout=within, lingering_time=0.0, access_log=None, logger=_LOGGER,
            auto_decompress=False,
        )  # fmt: skip
        self._most, self._most_of_one, self._within = most, most_of_one, within
        self._handle = answer
        self._waiting: dict[RequestHandler, _Connection] = {}
        self._of_group: dict[str, dict[RequestHandler, None]] = {}
        self.dropped = 0
        """Connections closed for being late or too many."""

    def connection_made(self, handler: RequestHandler, transport: asyncio.Transport) -> None:
        """Add a connection; close another one if there are too many."""
        super().connection_made(handler, transport)
        peer: Any = transport.get_extra_info("peername") or ("",)
        group = address_group(str(peer[0]))
        timer = asyncio.get_running_loop().call_later(self._within, self._time_out, handler)
        self._waiting[handler] = _Connection(group, transport, timer, self._within)
        self._of_group.setdefault(group, {})[handler] = None
        if len(self._of_group[group]) > self._most_of_one:
            self._drop_one_of(group)
        elif len(self._waiting) > self._most:
            self._drop_one_of(max(self._of_group, key=lambda each: len(self._of_group[each])))

    def connection_lost(self, handler: RequestHandler, exc: BaseException | None = None) -> None:
        """Remove a connection."""
        super().connection_lost(handler, exc)
        self._forget(handler)

    def release(self, request: web.BaseRequest) -> None:
        """Stop limiting a connection that became a WebSocket: its pings now show whether the client is there."""
        self._forget(request.protocol)

    def allow(self, request: web.BaseRequest, within: float) -> None:
        """Give the answer to a request another time limit [s]: a large file over a slow network."""
        connection = self._waiting.get(request.protocol)
        if connection is not None:
            connection.within = within

    @property
    def waiting(self) -> int:
        """Number of connections other than open WebSockets."""
        return len(self._waiting)

    def _forget(self, handler: RequestHandler) -> None:
        connection = self._waiting.pop(handler, None)
        if connection is None:
            return
        connection.timer.cancel()
        group = self._of_group[connection.group]
        del group[handler]
        if not group:
            del self._of_group[connection.group]

    def _drop_one_of(self, group: str) -> None:
        of_group = self._of_group[group]
        self._drop(next((each for each in of_group if not self._waiting[each].has_request), next(iter(of_group))))

    def _time_out(self, handler: RequestHandler) -> None:
        if handler in self._waiting:
            self._drop(handler)

    def _drop(self, handler: RequestHandler) -> None:
        connection = self._waiting[handler]
        self._forget(handler)
        self.dropped += 1
        connection.transport.abort()

    async def _handle_request(self, request: web.BaseRequest) -> web.StreamResponse:
        connection = self._waiting.get(request.protocol)
        if connection is not None:
            connection.has_request, connection.within = True, self._within
        try:
            if request.body_exists:  # no handler reads a body
                refused = web.Response(status=413, headers=SECURITY_HEADERS)
                refused.force_close()
                return refused
            return await self._handle(request)
        finally:
            connection = self._waiting.get(request.protocol)
            if connection is not None:
                connection.has_request = False
                connection.timer.cancel()
                loop = asyncio.get_running_loop()
                connection.timer = loop.call_later(connection.within, self._time_out, request.protocol)


async def serve_tls(server: BoundedServer, listening: socket.socket, tls: ssl.SSLContext) -> asyncio.Server:
    """Start accepting connections over TLS; the caller must close the returned server."""
    made: Any = server
    return await asyncio.get_running_loop().create_server(
        made, sock=listening, ssl=tls, backlog=ACCEPT_BATCH, ssl_handshake_timeout=REQUEST_TIMEOUT,
        ssl_shutdown_timeout=1.0,
    )  # fmt: skip


async def serve(server: BoundedServer, listening: socket.socket) -> web.ServerRunner:
    """Start accepting connections; the caller must clean up the returned runner."""
    runner = web.ServerRunner(server, handle_signals=False)
    await runner.setup()
    await web.SockSite(runner, listening, backlog=ACCEPT_BATCH).start()
    listening.listen(BACKLOG)  # asyncio uses its backlog for both purposes
    return runner
