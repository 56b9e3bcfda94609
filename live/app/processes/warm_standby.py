"""Warm standby of an engine, and the prefork process from which engines are forked.

A standby has loaded everything and follows the running show, so that it can resume it at once. The prefork process
has loaded program, kernels, patch and steps but opened nothing. See `live.supervisor.prefork`.
"""

import contextlib
import gc
import importlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rich.console import Console

from live.app.kernel_warmup import warm_kernels
from live.app.launch_options import LaunchOptions
from live.app.processes.resume_state import Resumed
from live.app.session import Session
from live.app.session_audio import Sound, choose_sound
from live.base.errors import PersonError
from live.control.events.events import ChooseSource
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.venue.venue import Latencies, Venue
from live.supervisor.cpu_priority import ENGINE_NICE, come_forward, stand_back
from live.supervisor.heartbeat import Phase
from live.supervisor.prefork import wait_to_be_born
from live.supervisor.recovery import Death, Recovery
from live.supervisor.state_follower import Following
from live.supervisor.supervisor_link import Lifeline, in_words, nobody_left

if TYPE_CHECKING:
    from live.app.headless_picture import HeadlessPicture
    from live.app.live_recording import LiveSharing


LOWEST = 99
"""A quality level below all others, which selects the lowest one."""
PATIENCE = 0.5
"""Interval [s] between checks whether supervisor and engine have ended, while no message arrives."""


def take_over(
    options: LaunchOptions, lifeline: Lifeline, loaded: LoadedShow | None = None, show: Show | None = None, *,
    waits: bool, console: Console,
) -> None:  # fmt: skip
    """Prepare, follow the show until the order to take over, then resume it.

    `waits`: run at low priority meanwhile; `loaded`, `show`: already loaded, together with all kernels.
    """
    processors = stand_back() if waits else frozenset()
    if loaded is None:
        warm_kernels(console)
        loaded = options.load(whole=False)
    venue = options.read_venue()
    sound = sound_of(options, loaded, venue)
    picture = None
    try:
        picture = open_picture(options, loaded, venue, hidden=True, show=show)
    except Exception as error:  # driver lost: show, lights and audio run without a picture
        lifeline.tell_note(f"no picture: {in_words(error)}")
    try:
        order, following = _follow(loaded, lifeline)
        if order is None:
            return
        come_forward(ENGINE_NICE, processors)
        go_on(options, loaded, venue, sound, lifeline, following, picture, order, console)
    finally:
        if picture is not None:
            picture.close()


def go_on(
    options: LaunchOptions, loaded: LoadedShow, venue: Venue | None, sound: Sound, lifeline: Lifeline,
    following: Following, picture: Any, order: dict[str, Any], console: Console, *, elsewhere: bool = False,
    headless: "HeadlessPicture | None" = None, sharing: "LiveSharing | None" = None,
) -> None:  # fmt: skip
    """Resume the followed show where it ended.

    `elsewhere`: it ran on another machine; `headless`, `sharing`: this machine's output meanwhile.
    """
    calm, death = bool(order["calm"]), order["death"]
    if death.get("plain"):
        options = replace(options, quality=LOWEST)
    recovered = Recovery(following, Death.of(death)).run()
    show = recovered.show
    for line in recovered.lines:
        lifeline.say(line)
    for words in recovered.notes:
        lifeline.tell_note(words)
        show.refusals.add(words)
    lead = Latencies.of(venue).lead
    origin = following.origin_here(lead) if elsewhere else following.origin
    resumed = Resumed(
        show, following.tick, origin, following.latencies, calm, elsewhere=elsewhere, begun=following.begun
    )  # fmt: skip
    session = Session(options, loaded, Sound() if calm else sound, venue, lifeline=lifeline, resumed=resumed)
    if calm:
        session.inbox.put(ChooseSource(time=session.clock.now(), source="supervisor", name="internal"))
    scene = loaded.scene(whole=False)
    if picture is None:
        from live.app.headless_loop import play_headless

        play_headless(session, scene, console, picture=headless, sharing=sharing)
        return
    from live.app.window_loop import play_picture

    reveal = None if elsewhere else bool(order["screen"]["fullscreen"])
    play_picture(session, scene, picture, console=console, reveal=reveal, sharing=sharing)


def _follow(loaded: LoadedShow, lifeline: Lifeline) -> tuple[dict[str, Any] | None, Following]:
    """Follow the show until the order to take over; None if there will be no order."""
    following = Following(loaded, heart=lifeline.heart)
    while True:
        lifeline.listen()
        for line in lifeline.lines:
            following.take(line)
            lifeline.log.take(line)
        lifeline.lines.clear()
        order = lifeline.order("go")
        if order is not None:
            return order, following
        if nobody_left(lifeline):
            return None, following
        if not following.advance():
            lifeline.beat(following.tick, Phase.WAITING)
            lifeline.wait(PATIENCE)


def sound_of(options: LaunchOptions, loaded: LoadedShow, venue: Venue | None) -> Sound:
    """Return the show's audio source; no source if it is not available any more."""
    try:
        return choose_sound(options, loaded, venue)
    except PersonError:
        return Sound()


def open_picture(
    options: LaunchOptions, loaded: LoadedShow, venue: Venue | None, *, hidden: bool, show: Show | None = None
) -> Any:
    """Open the windows and warm up the renderer; return None for a show without a picture.

    `hidden`: keep the windows invisible; `show`: drawn once for the warm-up.
    """
    from live.render.window.monitors import list_monitors

    if options.headless or not list_monitors():
        return None
    from live.app.headless_loop import find_screen
    from live.app.window_loop import Picture

    scene = loaded.scene(whole=False)
    try:
        monitor = find_screen(options.monitor)
    except PersonError:  # unplugged since: use any other one
        monitor = None
    picture = Picture.opened(
        options, scene, monitor=monitor, fullscreen=options.fullscreen, hidden=hidden, venue=venue,
    )  # fmt: skip
    picture.rehearse(show or loaded.start(seed=options.seed))
    return picture


def be_born(options: LaunchOptions, nursery: Lifeline, console: Console) -> tuple[Lifeline | None, LoadedShow, Show]:
    """Load everything while a show runs, then fork engines on request.

    Return in each of them, with its own lifeline and a show for the renderer's warm-up. The prefork process itself
    returns None as lifeline.
    """
    processors = stand_back()
    warm_kernels(console)
    for name in ("headless_loop", *(() if options.headless else ("window_loop",))):
        importlib.import_module(f"live.app.{name}")  # imports all that a standby needs
    if not options.headless:
        from live.render.body.body_mesh import COARSE, FINE, LIGHT, build_body
        from live.render.window.monitors import load_glfw

        with contextlib.suppress(ImportError):
            load_glfw()
        for level in (COARSE, LIGHT, FINE):
            build_body(level)
    loaded = options.load(whole=False)
    show = loaded.start(seed=options.seed)  # fills the values cached in the graph
    come_forward(0, processors)
    gc.collect()
    gc.freeze()
    return wait_to_be_born(nursery), loaded, show
