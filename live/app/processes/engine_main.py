"""Engine process of a supervised show, and the start of the supervisor itself.

An engine begins a show, or waits as a standby until it resumes one. See `live.supervisor`.
"""

import hashlib
import ipaddress
import json
import os
import socket
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.app.exit_codes import (
    EXIT_INTERRUPTED,
    EXIT_PERSON_ERROR,
    collect_garbage_rarely,
    install_signal_handlers,
    show_person_error,
)
from live.app.launch_options import LaunchOptions
from live.app.machine.systemd_unit import check_name
from live.app.processes.page_relay_main import MODULE as PAGE_MODULE
from live.app.processes.page_relay_main import PagePlan, page_hosts
from live.base.errors import PersonError
from live.base.system.features import LINUX, has_desktop
from live.base.system.native_stderr import survive_terminal_close
from live.base.system.process_control import (
    HANG_UP_CODE,
    INTERRUPT_CODE,
    RESTART_CODE,
    TERMINATE_CODE,
    machine_memory,
    restart_program,
)
from live.show.journal.journal_writer import move_aside
from live.supervisor.adoption.adoption import Adoption, CannotAdopt, EngineHung, find_engine
from live.supervisor.adoption.journal_resume import read_interrupted
from live.supervisor.cpu_priority import ENGINE_NICE, raise_priority
from live.supervisor.network.identity import Identity, Pairings, load_identity
from live.supervisor.supervisor import Supervisor
from live.supervisor.supervisor_config import SupervisorConfig
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.nodes.leader import NodeLeader
    from live.show.loader import LoadedShow
    from live.show.show import Show


STARTING_ROLES: Final = ("engine", "standby")
"""Roles that begin a show instead of resuming one."""


def run_role(lifeline: SupervisorLink, loaded: "LoadedShow | None" = None, show: "Show | None" = None) -> None:
    """Run in the role that the supervisor assigns. `loaded`, `show`: inherited from the prefork process, if any."""
    brief = lifeline.receive_brief()
    options = LaunchOptions.decode(brief.show)
    console = Console(stderr=True, highlight=False)
    if brief.role == "nursery":
        from live.app.processes.warm_standby import prefork_engine

        here, loaded, show = prefork_engine(options, lifeline)
        if here is not None:
            install_signal_handlers()
            run_role(here, loaded, show)
        return
    try:
        _run_engine_role(brief.role, options, lifeline, loaded, show, console)
    except PersonError:
        if brief.role in STARTING_ROLES:  # the command line is wrong, not a running show: no restart
            lifeline.send_end(EXIT_PERSON_ERROR)
        raise
    lifeline.send_end(0)


def _run_engine_role(
    role: str,
    options: LaunchOptions,
    lifeline: SupervisorLink,
    loaded: "LoadedShow | None",
    show: "Show | None",
    console: Console,
) -> None:
    if role == "engine":
        from live.app.headless_loop import play_show

        raise_priority(ENGINE_NICE)
        play_show(options, lifeline=lifeline)
    elif role == "standby":
        from live.app.processes.remote_standby import run_remote_standby

        run_remote_standby(options, lifeline, console)
    else:
        from live.app.processes.warm_standby import run_warm_standby

        run_warm_standby(options, lifeline, loaded, show, background=role == "spare", console=console)


def main() -> None:
    """Run until the show ends; exit codes as for `live`."""
    install_signal_handlers()
    collect_garbage_rarely()
    survive_terminal_close()
    try:
        run_role(SupervisorLink.of_arguments(*sys.argv[1:3]))
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)


MIN_SUPERVISED_SECONDS: Final = 60.0
"""Runs shorter than this [s] are not supervised."""
SIGNAL_EXIT_CODES: Final = (HANG_UP_CODE, INTERRUPT_CODE, TERMINATE_CODE)
"""Exit codes of shows that a signal ended."""
PORT_FREE_TIMEOUT: Final = 5.0
"""Time limit [s] for the port of a killed engine to become free."""
RETRY_INTERVAL: Final = 0.05
PORT: Final = 9020
"""Default port of a machine that leads."""
ENGINE: Final = ["live.app.processes.engine_main"]
"""The engine's module and its first arguments."""
MEMORY_SHARE: Final = 0.6
"""Share of the machine's memory that an engine may use."""


GENERATED_OPTIONS: Final = ("web_key", "audience_secret")
"""Options that are generated at each start."""


def is_supervised(options: LaunchOptions) -> bool:
    """Whether to supervise this show: on a screen or headless, and not shorter than `MIN_SUPERVISED_SECONDS`.

    Films are made by one process, because a standby cannot continue half a film. Raise PersonError where the show
    has to follow another machine, or to be followed by one, and cannot be supervised.
    """
    machines = options.lead is not None or options.standby is not None or options.nodes is not None
    screen = options.headless or has_desktop()
    able = screen and options.record is None and options.shaders is None and not options.alone
    if machines and not (able and LINUX):
        raise PersonError(
            "--lead, --standby and --nodes need a supervisor: Linux, a screen or --headless, no --record, --shaders "
            "and --alone"
        )
    short = options.seconds is not None and options.seconds < MIN_SUPERVISED_SECONDS
    return able and (machines or not short)


def supervise(options: LaunchOptions) -> None:
    """Run the show under a supervisor; exit with the engine's exit code."""
    from live.control.osc.osc_socket import CannotListen

    console = Console(stderr=True, highlight=False)

    def say(line: str) -> None:
        console.print(f"note: {line}", style="yellow", soft_wrap=True, markup=False)

    lead, standby, service = options.lead, options.standby, options.service
    if service is not None:
        check_name(service)
    label = show_label(options)
    adoption, hung = None, False
    try:
        adoption = _find_running_engine(label, say)
    except EngineHung as error:
        say(str(error))
        hung = True
    except CannotAdopt as error:
        console.print(f"error: {error}", style="red", soft_wrap=True, markup=False)
        raise SystemExit(1) from None
    there = {} if adoption is None else adoption.descriptors
    leads_at = None if lead is None else _parse_endpoint(lead, "--lead")
    follows = None if standby is None else _parse_endpoint(standby, "--standby")
    identity, pairings = _load_pairings(leads_at, follows)
    leads = None if leads_at is None else _listen(*leads_at)
    nodes = None if options.nodes is None else _open_nodes(options, leads_at, say)
    try:
        osc = _osc_socket(options, there, hung)
    except CannotListen as error:
        if service is None:
            raise PersonError(str(error)) from None
        say(f"{error}")  # ending processes of the show before may still hold the port: systemd tries again
        raise SystemExit(1) from None
    python = [sys.executable, "-m"]
    silent = options.audio is None and (options.bpm is not None or options.is_practice)
    orders = SupervisorConfig(
        engine=[*python, *ENGINE],
        show=options.encode() if adoption is None else adoption.show,
        audio=[] if silent or not LINUX else [*python, "live.app.processes.audio_main"],
        fallback_window=() if options.headless else [*python, "live.app.processes.fallback_window_main"],
        screen=(options.fullscreen, options.monitor),
        osc=osc,
        osc_reader=[*python, "live.app.processes.osc_reader_main"] if options.osc_process and LINUX else (),
        journal=options.journal,
        lead=leads,
        identity=identity,
        pairings=pairings,
        follow=follows,
        nodes=nodes,
        page=[*python, PAGE_MODULE] if relays_page(options) else (),
        page_plan=lambda show, follows: page_plan(show, "" if nodes is None else nodes.name, follows=follows),
        keys=options.keys,
        with_keys=lambda show, keys: LaunchOptions.decode(show).with_keys(keys).encode(),
        memory_budget=int(MEMORY_SHARE * machine_memory()),
        label=label if LINUX else "",
    )
    left, journal = None, options.journal
    if (service is not None or hung) and adoption is None and journal is not None and standby is None:
        left = read_interrupted(journal)
    supervisor = Supervisor(orders, say, adoption, left)
    if left is not None:
        say(f"the show is resumed from its journal after {left.interrupted_s:.0f} s")
    code = supervisor.run()
    if left is not None and code not in (0, *SIGNAL_EXIT_CODES) and not supervisor.engines.has_run:
        say(f"the show cannot be resumed from its journal, now {move_aside(Path(str(journal)))}: it starts again")
        raise SystemExit(1)  # systemd starts it again
    _end(code)


def _end(code: int) -> None:
    """End this program as its show has ended."""
    if code == INTERRUPT_CODE:
        raise KeyboardInterrupt
    if code == RESTART_CODE:
        restart_program()
    if code:
        raise SystemExit(code)


def _open_nodes(
    options: LaunchOptions, leads_at: tuple[str, int] | None, say: Callable[[str], None]
) -> "NodeLeader":  # fmt: skip
    """Open the bus of the render nodes; PersonError if that fails, or no other machine is paired."""
    from live.nodes.bus import ZenohBus
    from live.nodes.leader import NodeLeader
    from live.nodes.signed_bus import SignedBus
    from live.show.venue.venue import Latencies

    host, port = nodes_address(str(options.nodes), "127.0.0.1" if leads_at is None else leads_at[0])
    identity, pairings = _load_pairings(None, None, (host, port))
    assert identity is not None
    assert pairings is not None
    ahead = Latencies.of(options.read_venue(), nodes=True).nodes
    raise_priority(ENGINE_NICE)  # all nodes wait for the lines that this process sends on
    scout = not _is_this_machine(host)
    bus = SignedBus(ZenohBus(identity, pairings, listen=(host, port), scout=scout), identity, pairings)
    return NodeLeader(bus, say, ahead=ahead)


def relays_page(options: LaunchOptions) -> bool:
    """Whether the operator's page of this show can be opened from other machines, by the bus."""
    return options.web is not None and options.web[1] != 0 and options.nodes is not None


def page_plan(show: str, leader: str, *, follows: bool) -> str:
    """Return the plan of the process that relays the page. `leader`: name of this machine's side of the bus; `follows`:
    another machine leads."""
    options = LaunchOptions.decode(show)
    assert options.web is not None
    leads_at = None if options.lead is None else _parse_endpoint(options.lead, "--lead")
    own = nodes_address(str(options.nodes), "127.0.0.1" if leads_at is None else leads_at[0])
    if follows:
        leads = None if options.standby is None else _parse_endpoint(options.standby, "--standby")[0]
        leaders = () if leads is None else ((leads, own[1]),)
        return PagePlan(options.web, leaders, hosts=page_hosts(options)).encode()
    loopback = {"0.0.0.0": "127.0.0.1", "::": "::1"}
    web, bus = ((loopback.get(host, host), port) for host, port in (options.web, own))
    return PagePlan(web, (bus,), leader=leader, key=options.web_key).encode()


def nodes_address(text: str, host: str) -> tuple[str, int]:
    """Parse [HOST:]PORT of --nodes; `host`: the default one."""
    named = text if ":" in text else f"{f'[{host}]' if ':' in host else host}:{text}"
    return _parse_endpoint(named, "--nodes")


def _find_running_engine(label: str, say: Callable[[str], None]) -> Adoption | None:
    adoption = find_engine(label)
    if adoption is not None:
        say(f"adopted the running show: its engine (process {adoption.process.pid}) had no supervisor")
    return adoption


def _osc_socket(options: LaunchOptions, there: Mapping[str, int], hung: bool) -> socket.socket | None:
    """Return the socket for OSC that the engines inherit; None where they cannot, and each binds the port itself."""
    if "osc" in there:
        return socket.socket(fileno=there["osc"])
    return _bind_osc(*options.osc, hung) if LINUX else None


def _bind_osc(host: str, port: int, hung: bool) -> socket.socket:
    """Return the socket for OSC. After an engine that `hung`, its processes may hold the port for a moment: retry."""
    from live.control.osc.osc_socket import CannotListen, bound_socket

    deadline = time.monotonic() + (PORT_FREE_TIMEOUT if hung else 0.0)
    while True:
        try:
            return bound_socket(host, port)
        except CannotListen:
            if time.monotonic() > deadline:
                raise
            time.sleep(RETRY_INTERVAL)


def service_label(name: str) -> str:
    """Return the prefix of the labels of a service's shows."""
    return f"service-{name}."


def show_label(options: LaunchOptions) -> str:
    """Return the label by which this show's engine is found: the same command in the same folder is the same show."""
    table = {name: value for name, value in asdict(options).items() if name not in GENERATED_OPTIONS}
    words = json.dumps([os.getcwd(), table], sort_keys=True, default=str)
    begin = "play." if options.service is None else service_label(options.service)
    return begin + hashlib.sha256(words.encode()).hexdigest()[:16]


def _parse_endpoint(text: str, option: str) -> tuple[str, int]:
    """Parse [HOST:]PORT or HOST[:PORT]; the default port is `PORT`, the default host this machine."""
    host, _, port = text.strip().rpartition(":")
    if ":" not in text and not port.isdecimal():
        host, port = port, str(PORT)
    named = bool(host) or ":" not in text
    if not (port.isdecimal() and named and int(port) <= 65535) or any(mark.isspace() for mark in host):
        raise PersonError(f"{option} {text!r}: HOST:PORT expected", f"{option} 127.0.0.1:{PORT}")
    return (host or "127.0.0.1").strip("[]"), int(port)


def _load_pairings(
    lead: tuple[str, int] | None, follow: tuple[str, int] | None, nodes: tuple[str, int] | None = None
) -> tuple[Identity | None, Pairings | None]:
    """Return this machine's key and pairings if the show runs on several machines; raise PersonError if not paired."""
    if lead is None and follow is None and nodes is None:
        return None, None
    identity, pairings = load_identity(), Pairings()
    paired = pairings.read()
    for place, option in ((lead, "--lead"), (follow, "--standby"), (nodes, "--nodes")):
        if place is not None and not paired and not _is_this_machine(place[0]):
            raise PersonError(
                f"{option} {place[0]}: this machine is not paired with another one",
                "run `live pair` here, then `live pair` with this machine's address on the other one",
            )
    return identity, pairings


def _is_this_machine(host: str) -> bool:
    """Whether an address is a loopback address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=16)
    except OSError as error:
        raise PersonError(f"--lead: cannot listen at {host}:{port}: {error.strerror}", "choose another port") from None


if __name__ == "__main__":
    main()
