"""Render node: follows a leader's show and draws the outputs that the venue gives to it (`live node`).

The command keeps one process running that does all this, and another one that has everything loaded: if the first dies,
the next is forked from it and is there in a moment. On an operator's order all is loaded anew.
"""

import contextlib
import gc
import json
import secrets
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
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
from live.app.processes.page_relay_main import MODULE as PAGE_MODULE
from live.app.processes.page_relay_main import PagePlan, page_hosts
from live.base.errors import PersonError
from live.base.system.process_control import RESTART_CODE
from live.clock.ticks import TICK
from live.supervisor.cpu_priority import ENGINE_NICE, lower_priority, raise_priority
from live.supervisor.heartbeat import Phase as Beat
from live.supervisor.prefork import PreforkProcess, serve_forks
from live.supervisor.process import AuxiliaryProcess, Child, LineHandler, ProcessManager
from live.supervisor.supervisor_link import SupervisorLink, is_abandoned

if TYPE_CHECKING:
    from live.app.processes.standby_output import StandbyOutput
    from live.app.projector_setup import OutputSetup
    from live.nodes.follower import NodeFollower
    from live.show.loader import LoadedShow

MODULE: Final = "live.app.processes.node_main"
SEARCH_PERIOD: Final = 0.02
"""Seconds between two looks at the bus while there is nothing to draw."""
SPARE_AFTER: Final = 2.0
"""Seconds that a node has run before the process from which the next would be forked is started."""
LONGEST_WAIT: Final = 0.02
SETTLE: Final = 0.0005
"""Seconds by which a node without a picture wakes up after a tick is due, so that it is due for certain."""


@dataclass(frozen=True, slots=True)
class NodePlan:
    """What a node is started with."""

    options: LaunchOptions
    """Patch, venue and picture; its `node` is the node's name."""
    leaders: tuple[tuple[str, int], ...] = ()
    """Addresses of leaders, and of machines that may take over; none: any that answers in the network."""
    web: tuple[str, int] | None = None
    """Where the page of the machine that plays is shown, ..."""
    hosts: tuple[str, ...] = ()
    """... and names by which browsers reach this machine."""


def keep_node(plan: NodePlan, command: Sequence[str] = (sys.executable, "-m", MODULE)) -> int:
    """Run a node until it ends for good, and start it again until then; return its exit code.

    `command`: starts its process; it gets its channel and its heartbeat as two more arguments.
    """
    console = Console(stderr=True, highlight=False)
    codes: list[int] = []

    def say(line: str) -> None:
        console.print(f"note: {line}", style="yellow", soft_wrap=True, markup=False)

    def hear(line: str) -> None:
        told = json.loads(line)
        if told.get("alive") == "note":
            say(str(told.get("words")))
        elif told.get("alive") == "end":
            codes.append(int(told["code"]))

    starter = ProcessManager()
    prefork = PreforkProcess(starter)
    show = json.dumps([plan.options.encode(), plan.leaders])

    def start() -> Child:
        child = None
        if prefork.ready:
            with contextlib.suppress(OSError):
                child = starter.start("node", (), hear, spawn=prefork.fork_engine)
        child = child or starter.start("node", command, hear)
        child.channel.send_json(alive="node", show=show)
        return child

    node, draws_since = AuxiliaryProcess(start, say), None
    page = AuxiliaryProcess(lambda: _start_page(plan, starter, hear), say)
    try:
        node.begin(time.monotonic())
        if plan.web is not None:
            page.begin(time.monotonic())
        while not codes:
            now = starter.poll()
            node.update(now, starter.load.slowdown)
            page.update(now, starter.load.slowdown)
            prefork.update()
            child = node.child
            draws_since = (draws_since or now) if child is not None and child.phase is Beat.RUNNING else None
            if child is not None and draws_since is not None and now - draws_since > SPARE_AFTER:
                prefork.ensure_started(command, {"show": show}, {}, child.memory)
            if codes == [RESTART_CODE]:
                codes.clear()
                prefork.stop()  # it has loaded what was there before
                node.close()
                node.begin(now)
        return codes[0]
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    finally:
        node.close()
        page.close()
        prefork.close()
        starter.close()


def _start_page(plan: NodePlan, starter: ProcessManager, hear: LineHandler) -> Child:
    """Start the process that shows the page of the machine that plays, for a plan with `web`."""
    child = starter.start("page", [sys.executable, "-m", PAGE_MODULE], hear)
    assert plan.web is not None
    told = PagePlan(plan.web, plan.leaders, hosts=(*plan.hosts, *page_hosts(plan.options)))
    child.channel.send_json(alive="page", show=told.encode())
    return child


def main(now: Callable[[], float] = time.perf_counter) -> None:
    """Run a node until its keeper or an operator ends it; exit codes as for `live`. `now`: this machine's clock [s]."""
    install_signal_handlers()
    collect_garbage_rarely()
    lifeline = SupervisorLink.of_arguments(*sys.argv[1:3])
    brief, loaded, code = lifeline.receive_brief(), None, 0
    word, leaders = json.loads(brief.show)
    plan = NodePlan(LaunchOptions.decode(word), tuple((str(host), int(port)) for host, port in leaders))
    try:
        if brief.role == "nursery":
            processors = lower_priority()
            loaded = load_node(plan.options)
            raise_priority(0, processors)
            gc.collect()
            gc.freeze()
            forked = serve_forks(lifeline)
            if forked is None:
                return
            install_signal_handlers()
            lifeline = forked
            lifeline.receive_brief()
        run_node(plan, lifeline, loaded, now=now)
    except PersonError as error:
        show_person_error(error)
        code = EXIT_PERSON_ERROR
    except KeyboardInterrupt:
        code = EXIT_INTERRUPTED
    except SystemExit as ended:
        code = int(ended.code or 0)
    lifeline.send_end(code)
    sys.exit(code)


def load_node(options: LaunchOptions) -> "LoadedShow":
    """Load all that a node needs and return its show; nothing is opened, and no thread is started."""
    from live.app.machine.kernel_warmup import compile_all, load_kernels
    from live.app.processes import standby_output
    from live.nodes import follower
    from live.show.background_work import import_late_modules

    del standby_output, follower  # imported for later
    compile_all(Console(stderr=True, highlight=False))
    load_kernels()
    loaded = options.load()
    loaded.start(seed=options.seed).tick(TICK)  # fills the values cached in the graph, and loads what a tick needs
    import_late_modules()
    return loaded


def run_node(
    plan: NodePlan, lifeline: SupervisorLink, loaded: "LoadedShow | None" = None, *,
    now: Callable[[], float] = time.perf_counter,
) -> None:  # fmt: skip
    """Follow and draw until the keeper goes; PersonError if the leader refuses this machine or its show cannot be drawn
    here; SystemExit with RESTART_CODE on an operator's order.

    `loaded`: by `load_node`; `now`: this machine's monotonic clock [s].
    """
    from live.app.processes.standby_output import StandbyOutput, check_status_writable
    from live.app.session_audio import AudioChoice
    from live.base.jit import KERNEL_SET
    from live.base.system.clock_discipline import clock_discipline
    from live.nodes.bus import ZenohBus
    from live.nodes.follower import NodeFollower, NodeIdentity
    from live.nodes.signed_bus import SignedBus
    from live.show.stages.row_threads import row_threads
    from live.show.venue.venue import Latencies
    from live.supervisor.network.identity import Pairings, load_identity

    options, console = plan.options, Console(stderr=True, highlight=False)
    identity, pairings = load_identity(), Pairings()
    loaded, venue = loaded or load_node(options), options.read_venue()
    check_status_writable(options)
    transport = ZenohBus(identity, pairings, connect=plan.leaders, scout=not plan.leaders)
    bus = SignedBus(transport, identity, pairings)
    follower: NodeFollower | None = None
    output = StandbyOutput(
        options, loaded, venue, AudioChoice(), lambda: {} if follower is None else asdict(follower.state())
    )
    try:
        if output.window is None and not options.headless:
            raise PersonError("this node has no monitor to draw on", "connect one, or follow with --headless")
        me = NodeIdentity(
            options.node, secrets.token_hex(8), KERNEL_SET, str(clock_discipline()), describe_output(output)
        )
        follower = NodeFollower(me, loaded, bus, lifeline.send_note, heartbeat=lifeline.heartbeat, now=now)
        raise_priority(ENGINE_NICE)
        with row_threads():
            gc.freeze()
            gc.disable()
            try:
                _draw(follower, output, options, lifeline, Latencies.of(venue).lead)
            except PersonError as error:
                follower.report_refused(error.message)
                raise
    finally:
        gc.enable()
        lifeline.beat(0, Beat.LEAVING)
        output.close(console)
        bus.close()


def _draw(
    follower: "NodeFollower", output: "StandbyOutput", options: LaunchOptions, lifeline: SupervisorLink, lead: float
) -> None:  # fmt: skip
    from live.app.film.live_recording import live_fps
    from live.render.timing.frame_stats import Pacer

    window, headless = output.window, output.headless
    pacer = None
    if window is not None:
        refresh = window.window.monitor.refresh_hz
        pacer = Pacer(live_fps(options, window.window.ctx, refresh), time.perf_counter, time.sleep)
    elif headless is not None:
        pacer = Pacer(live_fps(options, headless.ctx), time.perf_counter, time.sleep)
    setup = None if window is None else _node_setup(options, output, lifeline)
    cards: dict[str, str] = {}
    whole_for = ""
    while not is_abandoned(lifeline):
        lifeline.receive()
        lifeline.leave_if_asked()
        follower.update()
        if follower.restart_asked:
            raise SystemExit(RESTART_CODE)
        if window is not None and setup is not None:
            for screen, value in window.poll():
                setup.handle_input(screen, value)
        shown = follower.present(lead)
        lifeline.beat(0 if shown is None else shown.tick, Beat.RUNNING)
        if shown is None:
            output.dark()
            time.sleep(SEARCH_PERIOD)
        else:
            if setup is not None and cards != shown.show.desk.master.cards:
                cards = dict(shown.show.desk.master.cards)
                setup.replace_cards(cards)
            for screen in () if window is None else window.screens:
                screen.tick = shown.tick
            output.frame(shown.show, shown.tick, shown.time)
            whole_for = _tell_whole(output, whole_for, lifeline)
        lifeline.channel.flush()
        gc.collect(0)
        if pacer is not None:
            pacer.wait()
        elif shown is not None:
            time.sleep(min(follower.until_next_tick(lead) + SETTLE, LONGEST_WAIT))


def _tell_whole(output: "StandbyOutput", told: str, lifeline: SupervisorLink) -> str:
    """Tell why the whole picture is drawn where outputs show a part, unless that has been `told`; return the reason."""
    why: str = "" if output.window is None else output.window.whole_for
    if why != told:
        lifeline.send_note(f"this node draws the whole picture: {why}")
    return why


def _node_setup(options: LaunchOptions, output: "StandbyOutput", lifeline: SupervisorLink) -> "OutputSetup":
    """Return what handles the keys at this node's windows: F8 test cards, F9 its warps, saved to the venue."""
    from live.app.output_config import VenueWriter
    from live.app.projector_setup import OutputSetup

    def told(words: str) -> None:
        setup.save_result = words
        lifeline.send_note(words)

    keeping = VenueWriter(options.venue, told)
    setup = OutputSetup(output.window, keeping.save_output, lifeline.send_note, lambda name, card: None)
    return setup


def describe_output(output: "StandbyOutput") -> str:
    """Return the outputs of this node and the renderer that draws them."""
    if output.window is not None:
        names = ", ".join(screen.output.name for screen in output.window.screens)
        drawn = output.window.describe_part()
        return f"{names}: {drawn} ({output.window.window.ctx.info['GL_RENDERER']})"
    if output.headless is not None:
        return f"shared ({output.headless.ctx.info['GL_RENDERER']})"
    return "no picture"


def parse_leaders(texts: Sequence[str]) -> tuple[tuple[str, int], ...]:
    """Parse HOST[:PORT] of leaders; PersonError for anything else."""
    from live.app.option_values import NODES_PORT, add_default_port, parse_endpoint

    return tuple(parse_endpoint(add_default_port(text, NODES_PORT), "HOST") for text in texts)


if __name__ == "__main__":
    main()
