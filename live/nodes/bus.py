"""The bus between a leader and its nodes: Eclipse Zenoh, peer to peer, authenticated and encrypted as `live pair` says.

Zenoh is an optional package (the extra `nodes`). A leader listens; a node connects to each address that it is given, or
to whatever leader answers in the network (multicast scouting). There is no broker. Both sides prove by TLS that they
hold the key of a pinned certificate: the certificates that `live pair` has exchanged, and this machine's own for
processes of one user on one machine.
"""

import atexit
import base64
import contextlib
import json
import ssl
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any, Final, Protocol

from live.base.errors import PersonError
from live.supervisor.network.identity import Identity, Pairings

PORT: Final = 9022
"""Default port of a leader's bus."""
SCOUT: Final = "224.0.0.224:9022"
"""Multicast group and port in which leaders are searched for."""
RETRY: Final = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 1.5}
"""How soon a lost connection is tried again."""
LEASE_MS: Final = 2000
"""Milliseconds of silence after which a connection counts as lost, or in which none of an answer could be sent."""
LONGEST_AT_ONCE: Final = 1 << 14
"""Longer answers [bytes] are sent by other threads: they wait for the network, ..."""
ANSWERS_AT_A_TIME: Final = 8
"""... so many at a time."""

Receive = Callable[[bytes], None]
End = Callable[[], None]


def nothing() -> None:
    """Do nothing."""


class Question(Protocol):
    """A question that has arrived; it may be answered later, by any thread."""

    data: bytes
    arrived: float
    """When it arrived [s of perf_counter]."""

    def answer(self, data: bytes) -> None:
        """Send the one answer; never waits."""
        ...


class Bus(Protocol):
    """What leader and nodes need of a bus. Receivers are called by threads of the bus and must not block."""

    def publish(self, key: str, data: bytes, *, bulk: bool = False) -> None:
        """Send to all who receive this key; never waits. What a slow receiver cannot take is lost. `bulk`: all else
        goes before it."""
        ...

    def receive(self, key: str, act: Receive) -> None:
        """Call `act` with all that is published under this key."""
        ...

    def serve(self, key: str, act: Callable[[Question], None]) -> None:
        """Call `act` with each question that is asked under this key."""
        ...

    def ask(
        self, key: str, data: bytes, act: Receive, *, timeout: float, bulk: bool = False, end: End = nothing
    ) -> None:  # fmt: skip
        """Ask; `act` gets each answer that comes within `timeout` [s]. Never waits. `bulk`: all else goes before it;
        `end`: called once no answer can come any more."""
        ...

    def close(self) -> None:
        """Close it."""
        ...


class ZenohQuestion:
    """A query of Zenoh's."""

    def __init__(self, query: Any, key: str, senders: Executor) -> None:
        """`senders`: threads that send long answers."""
        self.arrived = time.perf_counter()
        self._query, self._key, self._senders = query, key, senders
        self.data = b"" if query.payload is None else bytes(query.payload)

    def answer(self, data: bytes) -> None:
        """Send the one answer; one who has gone is no error."""
        if len(data) <= LONGEST_AT_ONCE:
            self._reply(data)
        else:
            with contextlib.suppress(RuntimeError):  # the bus has been closed
                self._senders.submit(self._reply, data)

    def _reply(self, data: bytes) -> None:
        import zenoh

        with contextlib.suppress(zenoh.ZError):
            self._query.reply(self._key, data)
        self._query.drop()


class ZenohBus:
    """A session of Zenoh. Thread: any."""

    def __init__(
        self, identity: Identity, pairings: Pairings, *, listen: tuple[str, int] | None = None,
        connect: Sequence[tuple[str, int]] = (), scout: bool = False, client: bool = False,
    ) -> None:  # fmt: skip
        """`listen`: where a leader listens; `connect`: leaders' addresses; `scout`: find and be found by multicast;
        `client`: a process beside a leader, which passes its messages on.

        PersonError without the package, or if that address cannot be used.
        """
        zenoh = load_zenoh()
        self._zenoh: Any = zenoh
        settings = configuration(identity, pairings, listen=listen, connect=connect, scout=scout, client=client)
        try:
            self._session: Any = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
        except zenoh.ZError as error:
            where = "" if listen is None else " at {}:{}".format(*listen)
            words = " ".join(str(error).split())[:200]
            raise PersonError(f"the bus of the nodes cannot be opened{where}: {words}", "choose another port") from None
        atexit.register(self.close)  # an open session would keep the process from ending
        self._senders = ThreadPoolExecutor(ANSWERS_AT_A_TIME, "bus answers")
        self._publishers: dict[str, Any] = {}
        self._kept: list[Any] = []

    def publish(self, key: str, data: bytes, *, bulk: bool = False) -> None:
        """Send to all who receive this key."""
        found = self._publishers.get(key)
        if found is None:
            priority = self._zenoh.Priority.DATA_LOW if bulk else self._zenoh.Priority.REAL_TIME
            found = self._publishers[key] = self._session.declare_publisher(
                key, congestion_control=self._zenoh.CongestionControl.DROP, priority=priority, express=not bulk
            )
        with contextlib.suppress(self._zenoh.ZError):
            found.put(data)

    def receive(self, key: str, act: Receive) -> None:
        """Call `act` with all that is published under this key."""
        self._kept.append(self._session.declare_subscriber(key, lambda sample: act(bytes(sample.payload))))

    def serve(self, key: str, act: Callable[[Question], None]) -> None:
        """Call `act` with each question that is asked under this key."""
        self._kept.append(
            self._session.declare_queryable(key, lambda query: act(ZenohQuestion(query, key, self._senders)))
        )

    def ask(
        self, key: str, data: bytes, act: Receive, *, timeout: float, bulk: bool = False, end: End = nothing
    ) -> None:  # fmt: skip
        """Ask; `act` gets the answers."""
        zenoh = self._zenoh  # an answer goes as its question did
        priority = zenoh.Priority.DATA_LOW if bulk else zenoh.Priority.REAL_TIME
        congestion = zenoh.CongestionControl.BLOCK if bulk else zenoh.CongestionControl.DROP

        def hear(reply: Any) -> None:
            if reply.ok is not None:
                act(bytes(reply.ok.payload))

        try:
            self._session.get(
                key, zenoh.handlers.Callback(hear, end), payload=data, timeout=timeout, express=True,
                target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE, priority=priority,
                congestion_control=congestion,
            )  # fmt: skip
        except zenoh.ZError:
            end()

    def close(self) -> None:
        """Close the session; harmless if it is closed."""
        atexit.unregister(self.close)
        self._senders.shutdown(wait=False, cancel_futures=True)
        with contextlib.suppress(self._zenoh.ZError):
            self._session.close()


def load_zenoh() -> Any:
    """Return the package; PersonError if it is not installed."""
    try:
        import zenoh
    except ImportError:
        raise PersonError(
            "render nodes need Eclipse Zenoh, which is not installed", "pip install 'choreographics-live[nodes]'"
        ) from None
    zenoh.init_log_from_env_or("off")  # it would write into the terminal
    return zenoh


def endpoint(host: str, port: int) -> str:
    """Return an address as Zenoh writes it."""
    return f"tls/[{host}]:{port}" if ":" in host else f"tls/{host}:{port}"


def configuration(
    identity: Identity, pairings: Pairings, *, listen: tuple[str, int] | None, connect: Sequence[tuple[str, int]],
    scout: bool, client: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return Zenoh's configuration; the arguments are those of `ZenohBus`. PersonError for pairings that cannot be
    read.

    The pinned certificates are the only trusted ones. They carry no host names: a machine is known by its certificate
    and not by its address, which changes from hall to hall.
    """
    peers = [identity.as_peer(), *pairings.read()]
    trusted = "".join(ssl.DER_cert_to_PEM_cert(peer.certificate) for peer in peers).encode()
    key, own = identity.path.read_bytes(), ssl.DER_cert_to_PEM_cert(identity.certificate).encode()
    tls = {f"{name}_base64": base64.b64encode(text).decode() for name, text in (
        ("root_ca_certificate", trusted), ("listen_private_key", key), ("listen_certificate", own),
        ("connect_private_key", key), ("connect_certificate", own),
    )}  # fmt: skip
    multicast = {
        "enabled": scout, "address": SCOUT, "autoconnect": {"router": [], "peer": ["peer"]},
        "listen": listen is not None,
    }  # fmt: skip
    return {
        "mode": "client" if client else "peer",
        "scouting": {"multicast": multicast, "gossip": {"enabled": False}},
        "listen": {"endpoints": [] if listen is None else [endpoint(*listen)]},
        "connect": {
            "endpoints": [endpoint(*each) for each in connect], "timeout_ms": -1, "exit_on_failure": False,
            "retry": RETRY,
        },
        "transport": {"link": {
            "protocols": ["tls"],
            "tx": {
                "lease": LEASE_MS, "keep_alive": 4,
                "queue": {"congestion_control": {"block": {"wait_before_close": 1000 * LEASE_MS}}},
            },
            "tls": {**tls, "enable_mtls": True, "verify_name_on_connect": False, "close_link_on_expiration": False},
        }},
    }  # fmt: skip
