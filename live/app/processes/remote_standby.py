"""Standby on another machine: runs the leader's show in lockstep, with its own picture, until it takes over."""

import contextlib
import time
from collections.abc import Iterator
from typing import Any

from rich.console import Console

from live.app.kernel_warmup import warm_kernels
from live.app.launch_options import LaunchOptions
from live.app.processes.standby_output import StandbyOutput, status_can_be_written
from live.app.processes.warm_standby import go_on, sound_of
from live.base.errors import PersonError
from live.base.event_queue import Inbox
from live.clock.time_source import SystemClock
from live.control.events.events import ControlEvent, TakeOver
from live.control.osc.osc_server import OscInput
from live.render.frame_stats import Pacer
from live.show.journal.replay import ReplayError
from live.show.loader import LoadedShow
from live.supervisor.cpu_priority import ENGINE_NICE, come_forward
from live.supervisor.heartbeat import Phase
from live.supervisor.state_follower import Following
from live.supervisor.supervisor_link import Lifeline, nobody_left

RATE = 30.0
"""Pictures per second while another machine leads."""


def stand_by(options: LaunchOptions, lifeline: Lifeline, console: Console) -> None:
    """Follow the leader until the order to take over, then resume the show here."""
    warm_kernels(console)
    loaded = options.load()
    venue = options.read_venue()
    sound = sound_of(options, loaded, venue)
    status_can_be_written(options)
    output = StandbyOutput(options, loaded, venue, sound, lifeline)
    try:
        order, following = _follow(loaded, lifeline, options, output)
        if order is None:
            return
        output.hand_over()
        come_forward(ENGINE_NICE)
        go_on(
            options, loaded, venue, sound, lifeline, following, output.window, order, console, elsewhere=True,
            headless=output.headless, sharing=output.sharing,
        )  # fmt: skip
    finally:
        output.close(console)


@contextlib.contextmanager
def _listening(lifeline: Lifeline, options: LaunchOptions) -> Iterator[Inbox[ControlEvent]]:
    """Receive OSC; only /dance/takeover is used here."""
    inbox: Inbox[ControlEvent] = Inbox()
    osc = OscInput(*options.osc, inbox.lane(), SystemClock(), inherited=lifeline.osc)
    osc.start()
    try:
        yield inbox
    finally:
        osc.stop()


def follow(following: Following) -> None:
    """Apply the received log; raise PersonError if this machine plays another show or lacks its steps."""
    if (other := following.other_show()) is not None:
        raise PersonError(f"the leader plays another show: {other}", "start both machines with the same patch")
    try:
        following.follow()
    except ReplayError as error:
        raise PersonError(
            f"the leader's show cannot run here: {error}", "use the same steps on both machines"
        ) from None


def _follow(
    loaded: LoadedShow, lifeline: Lifeline, options: LaunchOptions, output: StandbyOutput
) -> tuple[dict[str, Any] | None, Following]:
    """Follow and draw the leader's show until the order to take over; None if there will be no order."""
    pacer = Pacer(RATE, time.perf_counter, time.sleep)
    following = Following(loaded, heart=lifeline.heart)
    with _listening(lifeline, options) as inbox:
        while not nobody_left(lifeline):
            lifeline.listen()
            while lifeline.order("anew") is not None:
                following = Following(loaded, heart=lifeline.heart)
            for line in lifeline.lines:
                following.take(line, arrived=time.perf_counter())
                lifeline.log.take(line)
            lifeline.lines.clear()
            try:
                follow(following)
            except PersonError as error:
                lifeline.wire.tell(alive="cannot", why=error.message)
                raise
            order = lifeline.order("go")
            if order is not None:
                return order, following
            if any(isinstance(event, TakeOver) for event in inbox.drain()):
                lifeline.wire.tell(alive="takeover")
            output.frame(following)
            lifeline.beat(following.tick, Phase.RUNNING)
            lifeline.tell_following({**following.facts(), "ready": int(following.ready and output.draws)})
            lifeline.wire.flush()
            pacer.wait()
    return None, following
