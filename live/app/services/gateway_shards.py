"""Several gateways for one audience: the processes on this machine, and the keys by which all gateways join."""

import math
import socket
from typing import TYPE_CHECKING, Any, Final

from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.system.channel import hand_over
from live.base.system.features import LINUX
from live.clock.time_source import Clock
from live.control.helper_process import HelperProcess

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions

BACKLOG: Final = 1024
"""Queue of connections of each gateway that it has not accepted yet."""
HEADROOM: Final = 1.25
"""The system divides connections by chance: a gateway has room for so much more than its part."""
LOOK_EVERY: Final = 2.0
"""Interval at which pairings are looked at [s]."""
SPARE_NUMBERS: Final = 4096
"""Numbers for phones that a gateway can have been given within a second."""


class GatewayShards:
    """The gateways of a show on this machine. Thread: the show's."""

    def __init__(self, options: "LaunchOptions", phones: int, clock: Clock, *, resumes: bool) -> None:
        """`phones`: most phones at a time of all gateways. PersonError if nobody can listen there."""
        from live.supervisor.network.identity import Pairings, load_identity

        assert options.audience is not None
        count, self._clock = options.gateways, clock
        if not count and options.gateways_listen is None:
            raise PersonError(
                "--gateways 0: nobody serves the phones", "--gateways-listen 0.0.0.0:9023, and live gateway elsewhere"
            )
        if count > 1 and not LINUX:
            raise PersonError(
                f"--gateways {count}: on this system processes cannot share a port",
                "one here, and live gateway on other machines or ports",
            )
        self._identity, self._pairings = load_identity(), Pairings()
        self._version, self._look_at = self._pairings.version(), 0.0
        self.reducer_socket = _listen(options.gateways_listen or ("127.0.0.1", 0), "--gateways-listen", resumes)
        host, port = self.reducer_socket.getsockname()[:2]
        self._reducer_at = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(str(host), str(host)), int(port)
        self._sockets: list[socket.socket] = []
        where = options.audience
        for _ in range(count):
            self._sockets.append(_listen(where, "--audience", resumes or bool(self._sockets)))
            where = (where[0], int(self._sockets[0].getsockname()[1]))
        self.port = where[1]
        self._most = part_of(phones, count)
        self._has_others = options.gateways_listen is not None
        self._names: dict[str, str] = {}  # machines by the fingerprints of their certificates
        self._shards: list[HelperProcess] = []

    @property
    def keys(self) -> dict[str, Any]:
        """This machine's key, and the certificates of all machines whose gateways may join."""
        return {"identity": self._identity.path.read_bytes(), "peers": self._peers()}

    def _peers(self) -> list[bytes]:
        others = self._pairings.read() if self._has_others else []
        self._names = {peer.fingerprint: peer.name for peer in others} | {self._identity.fingerprint: ""}
        return [self._identity.certificate, *(peer.certificate for peer in others)]

    def machine_name(self, fingerprint: str) -> str:
        """Return the name of a paired machine by the begin of its certificate's fingerprint; empty for this one."""
        return next((name for known, name in self._names.items() if known.startswith(fingerprint)), fingerprint)

    @property
    def spare_numbers(self) -> int:
        """Numbers for phones that all gateways can have been given within a second."""
        return SPARE_NUMBERS * max(len(self._sockets), 16 if self._has_others else 1)

    @property
    def pids(self) -> list[int | None]:
        """The process ids of the gateways."""
        return [shard.pid for shard in self._shards]

    def start(self, certificate: tuple[bytes, bytes] | None) -> None:
        """Start the gateways; `certificate`: with its key, for https."""
        for index, sock in enumerate(self._sockets):
            http, inherit = hand_over(sock)
            plan = {
                "http": http, "reducer": list(self._reducer_at), "most": self._most, "name": f"here {index + 1}",
                "certificate": certificate, **self.keys,
            }  # fmt: skip
            shard = HelperProcess("live.control.shards.shard", self._clock, plan, lambda: None, *inherit)
            shard.start()
            self._shards.append(shard)

    def frame(self) -> None:
        """Start gateways again that have died."""
        for shard in self._shards:
            shard.frame()

    def changed_peers(self) -> list[bytes] | None:
        """Return the certificates of all machines whose gateways may join, if they have changed."""
        now = self._clock.now()
        if not self._has_others or now < self._look_at:
            return None
        self._look_at = now + LOOK_EVERY
        version = self._pairings.version()
        if version == self._version:
            return None
        self._version = version
        try:
            return self._peers()
        except PersonError:  # a file that cannot be read: who is in stays
            return None

    def stop(self) -> None:
        """Stop the gateways and close their port."""
        for shard in self._shards:
            shard.stop()
        for sock in (*self._sockets, self.reducer_socket):
            sock.close()


def part_of(phones: int, gateways: int) -> int:
    """Return the most phones of each of so many gateways: its part, and room for those of one that has died."""
    if gateways < 2:
        return phones
    return min(math.ceil(max(HEADROOM * phones / gateways, phones / (gateways - 1))), phones)


def _listen(where: tuple[str, int], option: str, resumes: bool) -> socket.socket:
    try:
        return listening_socket(where, BACKLOG, resumes=resumes)
    except (OSError, OverflowError) as error:
        raise PersonError(f"{option} {where[0]}:{where[1]}: {error}", "choose another port") from None
