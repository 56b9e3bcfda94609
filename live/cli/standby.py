"""Standby: this machine dances what another one does, in lockstep and with its own picture, until it takes over."""

import contextlib
import time
from collections.abc import Iterator
from typing import Any

from rich.console import Console

from live.alive.following import Following
from live.alive.heartbeat import Phase
from live.alive.lifeline import Lifeline, nobody_left
from live.alive.priority import ENGINE_NICE, come_forward
from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.cli.heir import go_on, open_picture, sound_of
from live.cli.played import Played
from live.cli.warm import warm_kernels
from live.clock.source import SystemClock
from live.clock.ticks import TICK
from live.control.events import ControlEvent, TakeOver
from live.control.osc import OscInput
from live.render.pacing import Pacer
from live.show.replay_start import ReplayError

RATE = 30.0
"""Pictures a second while another machine leads."""


def stand_by(played: Played, lifeline: Lifeline, console: Console) -> None:
    """Follow, wait for the word, and play on."""
    warm_kernels(console)
    loaded = played.wish.load()
    venue = played.wish.read_venue()
    sound = sound_of(played, loaded, venue)
    picture = open_picture(played, loaded, venue, hidden=False)
    try:
        order, following = _follow(Following(loaded, heart=lifeline.heart), lifeline, played, picture)
        if order is None:
            return
        come_forward(ENGINE_NICE)
        go_on(played, loaded, venue, sound, lifeline, following, picture, order, console, elsewhere=True)
    finally:
        if picture is not None:
            picture.close()


@contextlib.contextmanager
def _listening(lifeline: Lifeline, played: Played) -> Iterator[Inbox[ControlEvent]]:
    """OSC, of which only /dance/takeover counts here."""
    inbox: Inbox[ControlEvent] = Inbox()
    osc = OscInput(*played.wish.osc, inbox.lane(), SystemClock(), inherited=lifeline.osc)
    osc.start()
    try:
        yield inbox
    finally:
        osc.stop()


def follow(following: Following) -> None:
    """Run what was told; PersonError if this machine plays another show, or has not the steps for it."""
    if (other := following.other_show()) is not None:
        raise PersonError(f"the leader plays another show: {other}", "start both machines with the same patch")
    try:
        following.follow()
    except ReplayError as error:
        raise PersonError(
            f"the leader's show cannot be danced here: {error}", "use the same steps on both machines"
        ) from None


def _follow(
    following: Following, lifeline: Lifeline, played: Played, picture: Any
) -> tuple[dict[str, Any] | None, Following]:
    """Run what the leader runs, and draw it, until the word comes; None if it never will."""
    pacer = Pacer(RATE, time.perf_counter, time.sleep)
    view: Any = None
    with _listening(lifeline, played) as inbox:
        while not nobody_left(lifeline):
            lifeline.listen()
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
            show = following.show
            if picture is not None:
                for _ in picture.poll():
                    pass
                if show is not None:
                    view = view or show.view()
                    show.fill(view, following.tick * TICK)
                    picture.draw(view)
                    picture.show(following.tick * TICK)
            lifeline.beat(following.tick, Phase.RUNNING)
            lifeline.tell_following(following.facts())
            pacer.wait()
    return None, following
