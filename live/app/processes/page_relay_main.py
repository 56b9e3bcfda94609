"""Process that relays the operator's page over the bus: out of the machine that leads, or into the browser's machine.

It runs beside the show. Where the show plays, it is a client of the supervisor's bus (`live.nodes.page_relay`): what
browsers send takes no Python there. The supervisor imports this module, but not what the process needs.
"""

import base64
import contextlib
import os
import sys
from dataclasses import asdict, dataclass, field
from typing import Final

from live.app.launch_options import LaunchOptions
from live.base.errors import PersonError
from live.base.field_types import build_dataclass
from live.control.message_codec import decode_packet, encode_packet
from live.supervisor.supervisor_link import SupervisorLink

MODULE: Final = "live.app.processes.page_relay_main"
LOOK_EVERY: Final = 0.25
"""Seconds between two looks whether the process that started this one has gone."""
LISTEN_AGAIN: Final = 0.5
"""Seconds after which a port is tried again that an engine still holds."""
BACKLOG: Final = 128


@dataclass(frozen=True, slots=True)
class PagePlan:
    """What such a process is to do."""

    web: tuple[str, int]
    """Of the page's server on this machine, or where browsers connect."""
    leaders: tuple[tuple[str, int], ...]
    """Addresses of the bus, as of a node; of this machine, if its page is served."""
    leader: str = ""
    """Name of this machine's side of the bus, whose page is served to other machines; empty: theirs is shown here."""
    key: str = field(default="", repr=False)
    """Of the page that is served."""
    hosts: tuple[str, ...] = ()
    """Names by which browsers reach this machine."""

    def encode(self) -> str:
        """As one word, for another process of this program."""
        return base64.b64encode(encode_packet(asdict(self))).decode()

    @classmethod
    def decode(cls, word: str) -> "PagePlan":
        """What `encode` made; ValueError for anything else."""
        return build_dataclass(cls, decode_packet(base64.b64decode(word, validate=True)))


def page_hosts(options: LaunchOptions) -> tuple[str, ...]:
    """Return the names by which browsers reach this machine: of the command line and of the venue."""
    venue = options.read_venue()
    return options.web_hosts + (() if venue is None else venue.web.hosts)


async def relay(plan: PagePlan, lifeline: SupervisorLink) -> None:
    """Relay until the process that started this one has gone; PersonError if the bus cannot be used."""
    import asyncio

    from live.app.services.http_services import own_address
    from live.app.services.listening_socket import listening_socket
    from live.nodes.bus import ZenohBus
    from live.nodes.page_relay import Entrance, Exit
    from live.nodes.signed_bus import SignedBus
    from live.supervisor.network.identity import Pairings, load_identity

    identity, pairings = load_identity(), Pairings()
    scout = not plan.leaders
    transport = ZenohBus(identity, pairings, connect=plan.leaders, scout=scout, client=bool(plan.leader))
    bus = SignedBus(transport, identity, pairings)
    if plan.leader:
        task = asyncio.ensure_future(Exit(bus, plan.leader, plan.web, plan.key).run())
    else:
        entrance, told, sock = Entrance(bus, plan.hosts), False, None
        while sock is None:
            try:
                sock = listening_socket(plan.web, BACKLOG, resumes=False)
            except (OSError, OverflowError) as error:
                if not told:
                    lifeline.send_note(f"--web {plan.web[0]}:{plan.web[1]}: {error}; it is tried again")
                told = True
                if await _has_gone_within(lifeline, LISTEN_AGAIN):
                    return
        host = own_address() if plan.web[0] in ("0.0.0.0", "::") else plan.web[0]
        link = f"http://{f'[{host}]' if ':' in host else host}:{sock.getsockname()[1]}"
        lifeline.send_note(
            f"the page and studio of the machine that plays are at {link}/ and {link}/studio, with its key"
        )
        task = asyncio.ensure_future(entrance.serve(sock))
    while not task.done() and not await _has_gone_within(lifeline, LOOK_EVERY):
        pass
    bus.close()
    if task.done():
        task.result()  # an error: another process takes its place


async def _has_gone_within(lifeline: SupervisorLink, seconds: float) -> bool:
    import asyncio

    await asyncio.sleep(seconds)
    lifeline.receive()
    lifeline.channel.flush()
    return lifeline.orphaned


def main() -> None:
    """Relay until the process that started this one has gone."""
    import asyncio

    from live.base.system.process_control import ignore_interrupts, yield_priority
    from live.control.web.task_guard import loop_factory

    ignore_interrupts()
    lifeline = SupervisorLink.of_arguments(*sys.argv[1:3])
    plan = PagePlan.decode(lifeline.receive_brief().show)
    yield_priority(2)
    try:
        with asyncio.Runner(loop_factory=loop_factory()) as runner:
            runner.run(relay(plan, lifeline))
    except PersonError as error:
        lifeline.send_note(f"the page is not relayed: {error}")
        with contextlib.suppress(OSError):
            lifeline.channel.flush()
    os._exit(0)  # threads of the bus may not end by themselves


if __name__ == "__main__":
    main()
