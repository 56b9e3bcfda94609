"""Standby on another machine: runs the leader's show in lockstep, with its own picture, until it takes over."""

import contextlib
import time
from collections.abc import Iterator
from typing import Any

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.machine.kernel_warmup import compile_all, load_kernels
from live.app.processes.standby_output import StandbyOutput, check_status_writable
from live.app.processes.warm_standby import available_audio, promote
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent, TakeOver
from live.control.osc.osc_server import OscInput
from live.render.timing.frame_stats import Pacer
from live.show.journal.replay import ReplayError
from live.show.loader import LoadedShow
from live.supervisor.cpu_priority import ENGINE_NICE, raise_priority
from live.supervisor.heartbeat import Phase
from live.supervisor.state_follower import StateFollower, cannot_run, check_show
from live.supervisor.supervisor_link import SupervisorLink, is_abandoned

STANDBY_FPS = 30.0
"""Pictures per second while another machine leads."""


def run_remote_standby(options: LaunchOptions, lifeline: SupervisorLink, console: Console) -> None:
    """Follow the leader until the order to take over, then resume the show here."""
    compile_all(console)
    load_kernels()
    loaded = options.load()
    venue = options.read_venue()
    sound = available_audio(options, loaded, venue)
    check_status_writable(options)
    output = StandbyOutput(options, loaded, venue, sound, lifeline.status)
    try:
        order, following = _follow_until_order(loaded, lifeline, options, output)
        if order is None:
            return
        output.release_status()
        raise_priority(ENGINE_NICE)
        promote(
            options, loaded, venue, sound, lifeline, following, output.window, order, console, from_other_machine=True,
            headless=output.headless, sharing=output.sharing,
        )  # fmt: skip
    finally:
        output.close(console)


@contextlib.contextmanager
def _takeover_osc(lifeline: SupervisorLink, options: LaunchOptions) -> Iterator[EventQueue[ControlEvent]]:
    """Receive OSC; only /dance/takeover is used here."""
    inbox: EventQueue[ControlEvent] = EventQueue()
    osc = OscInput(*options.osc, inbox.add_queue(), SystemClock(), inherited=lifeline.osc)
    osc.start()
    try:
        yield inbox
    finally:
        osc.stop()


def apply_log(following: StateFollower) -> None:
    """Apply the received log; raise PersonError if this machine plays another show or lacks its steps."""
    check_show(following)
    try:
        following.run_pending()
    except ReplayError as error:
        raise cannot_run(error) from None


def _follow_until_order(
    loaded: LoadedShow, lifeline: SupervisorLink, options: LaunchOptions, output: StandbyOutput
) -> tuple[dict[str, Any] | None, StateFollower]:
    """Follow and draw the leader's show until the order to take over; None if there will be no order."""
    pacer = Pacer(STANDBY_FPS, time.perf_counter, time.sleep)
    following = StateFollower(loaded, heartbeat=lifeline.heartbeat)
    with _takeover_osc(lifeline, options) as inbox:
        while not is_abandoned(lifeline):
            lifeline.receive()
            while lifeline.pop_request("anew") is not None:
                following = StateFollower(loaded, heartbeat=lifeline.heartbeat)
            for line in lifeline.lines:
                following.add_line(line, arrived=time.perf_counter())
                lifeline.log.add_line(line)
            lifeline.lines.clear()
            try:
                apply_log(following)
            except PersonError as error:
                lifeline.channel.send_json(alive="cannot", why=error.message)
                raise
            order = lifeline.pop_request("go")
            if order is not None:
                return order, following
            if any(isinstance(event, TakeOver) for event in inbox.drain()):
                lifeline.channel.send_json(alive="takeover")
            for _ in () if output.window is None else output.window.poll():
                pass
            if following.show is not None:
                output.frame(following.show, following.tick, following.tick * TICK)
            lifeline.beat(following.tick, Phase.RUNNING)
            lifeline.send_following({**following.facts(), "ready": int(following.ready and output.is_drawing)})
            lifeline.channel.flush()
            pacer.wait()
    return None, following
