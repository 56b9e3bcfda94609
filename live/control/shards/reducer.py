"""Reducer process: beside the show, it makes one audience of what several gateways tell."""

import asyncio
import gc
import logging
import ssl
import sys
import time
from typing import Any, Final

from live.clock.ticks import TICK
from live.control.audience.session_state import BeatClock, Rules
from live.control.audience.uplink import ShowUplink
from live.control.helper_process import HelperChannel
from live.control.message_codec import PacketError, decode_packet, encode_packet
from live.control.shards.packet_link import LinkKeys, PacketLink
from live.control.shards.reduction import Reduction, Shard
from live.control.tls import pinned_context
from live.control.web.task_guard import guarded, keep_task, loop_factory

FACTS_EVERY: Final = 0.5
FULL_COLLECTION: Final = 120
"""Every so many facts all garbage is collected, else the youngest."""
HANDSHAKE_TIMEOUT: Final = 5.0
MAX_LINKS: Final = 128
"""Most connections at a time, with those that have not said hello."""


class Reducer:
    """Reducer of one show. Thread: the loop's."""

    def __init__(self, channel: HelperChannel, plan: dict[str, Any]) -> None:
        self._origin = float(plan["origin"])
        self.reduction = Reduction(plan)
        self._uplink, self._channel = ShowUplink(channel, plan), channel
        self._keys = LinkKeys(bytes(plan["identity"]), tuple(plan["peers"]))
        self._tls = pinned_context(ssl.PROTOCOL_TLS_SERVER, self._keys.identity, self._keys.peers)
        self._links: set[PacketLink] = set()
        self._due = 0.0
        self._ended = asyncio.Event()

    def _now(self) -> float:
        return time.perf_counter() - self._origin

    def handle(self, packet: Any) -> None:
        """Handle a packet from the show."""
        if isinstance(packet, Rules):
            self.reduction.update_rules(packet, self._now())
        elif isinstance(packet, BeatClock):
            self.reduction.pass_on("beat", encode_packet(packet))
        elif isinstance(packet, tuple) and packet[0] == "stage":
            self.reduction.pass_on("stage", encode_packet(packet))
        elif isinstance(packet, tuple) and packet[0] == "restart":
            self.reduction.restart(str(packet[1]))
        elif isinstance(packet, tuple) and packet[0] == "peers":
            self._pair(tuple(packet[1]))

    def _pair(self, peers: tuple[bytes, ...]) -> None:
        """Let other machines in from now on, and cut off those that are not paired any more."""
        self._keys = LinkKeys(self._keys.identity, peers)
        self._tls.load_verify_locations(cadata=b"".join(peers))
        known = self._keys.names()
        for link in list(self._links):
            if link.fingerprint not in known:
                link.close()

    def accept(self, link: PacketLink) -> None:
        """Wait for a gateway's hello on a new connection."""
        if len(self._links) >= MAX_LINKS:
            link.close()
            return
        self._links.add(link)
        link.on_end = lambda: self._links.discard(link)
        machine = link.fingerprint[:8]

        def enter(data: bytes) -> None:
            try:
                hello = decode_packet(data)
            except PacketError:
                hello = None
            shard = self.reduction.enter(hello, machine, link.publish, link.close, self._now())
            if shard is None:
                return
            link.on_packet = lambda packet: self._receive(shard, packet)
            link.on_end = lambda: self._lose(shard, link)

        link.on_packet = enter

    def _receive(self, shard: Shard, packet: bytes) -> None:
        self.reduction.handle(shard, packet, self._now())
        if self._now() >= self._due:
            self.gather()

    def _lose(self, shard: Shard, link: PacketLink) -> None:
        self._links.discard(link)
        self.reduction.leave(shard)

    def gather(self) -> None:
        """Tell the show what all gateways hear, once per tick."""
        now = self._now()
        self._due = now + TICK
        self._uplink.publish(self.reduction.report(now), now)

    def _run_timer(self) -> None:
        if self._now() >= self._due:
            guarded("gathering the voices of gateways", self.gather)()
        asyncio.get_running_loop().call_later(max(self._due - self._now(), 0.001), self._run_timer)

    async def _report_status(self) -> None:
        count = 0
        while True:
            now = self._now()
            self._uplink.report_facts(self.reduction.facts(now), now)
            count += 1
            gc.collect(0 if count % FULL_COLLECTION else 2)
            await asyncio.sleep(FACTS_EVERY)

    async def run(self) -> None:
        """Serve until the show ends."""
        loop = asyncio.get_running_loop()
        self._uplink.start(self.handle, self._ended.set)
        server = await loop.create_server(
            lambda: PacketLink(self._keys, self.accept), sock=self._channel.listening_socket(), ssl=self._tls,
            ssl_handshake_timeout=HANDSHAKE_TIMEOUT, backlog=64,
        )  # fmt: skip
        telling = keep_task("the figures of gateways", self._report_status)
        self._run_timer()
        await self._ended.wait()
        telling.cancel()
        server.close()
        for link in list(self._links):
            link.close()


def main() -> None:
    """Serve until the show ends."""
    logging.disable(logging.CRITICAL)
    told = HelperChannel(sys.argv[1])
    gc.collect()
    gc.freeze()
    gc.disable()  # see `Reducer._report_status`

    async def run() -> None:
        await Reducer(told, told.plan).run()

    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        runner.run(run())


if __name__ == "__main__":
    main()
