"""Gateway on another machine than the show: it serves a part of the audience's phones until it is stopped."""

import asyncio
import importlib.util
import signal
import socket
import sys
from pathlib import Path

from live.app.services.audience_tls import read_identity
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.system.process_control import restart_program
from live.supervisor.network.identity import Pairings, load_identity

BACKLOG = 4096
"""Connections that wait to be accepted."""


def run_gateway(
    where: tuple[str, int], listen: tuple[str, int], tls: tuple[Path, Path] | None, phones: int, name: str
) -> None:
    """Serve up to `phones` phones at the address `listen`, for the show whose gateways join at `where`. On an
    operator's order the program starts again.

    PersonError if this machine is not paired with any other, or nobody can listen there.
    """
    if importlib.util.find_spec("aiohttp") is None:
        raise PersonError("live gateway needs the package aiohttp", "make play installs it")
    identity, peers = load_identity(), Pairings().read()
    local = where[0] in ("127.0.0.1", "::1", "localhost")
    if not peers and not local:
        raise PersonError(f"this machine is not paired with {where[0]}", f"live pair there, then live pair {where[0]}")
    certificate = None if tls is None else read_identity(*tls, "--tls")
    try:
        sock = listening_socket(listen, BACKLOG, resumes=False)
    except (OSError, OverflowError) as error:
        raise PersonError(f"--listen {listen[0]}:{listen[1]}: {error}", "choose another port") from None
    from live.control.audience.gateway import prepare_process
    from live.control.shards.packet_link import LinkKeys
    from live.control.shards.shard import ShardUplink, run_shard
    from live.control.web.task_guard import loop_factory

    keys = LinkKeys(identity.path.read_bytes(), (identity.certificate, *(peer.certificate for peer in peers)))
    prepare_process(phones)
    sock.setblocking(False)

    uplink = ShardUplink(name or socket.gethostname(), phones)

    async def run() -> None:
        ended, loop = asyncio.Event(), asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(ended.set))
        await run_shard(
            uplink, where, keys, sock, ended,
            None if certificate is None else (certificate.certificate, certificate.key),
            lambda words: print(f"note: {words}", file=sys.stderr, flush=True),
        )  # fmt: skip

    with asyncio.Runner(loop_factory=loop_factory()) as runner:
        runner.run(run())
    if uplink.restart_asked:
        restart_program()
