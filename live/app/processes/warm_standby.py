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

from live.app.launch_options import LaunchOptions
from live.app.machine.kernel_warmup import load_kernels
from live.app.processes.resume_state import ResumeState
from live.app.session import Session
from live.app.session_audio import AudioChoice, choose_audio
from live.base.errors import PersonError
from live.control.events.events import ChooseSource
from live.show.background_work import import_late_modules
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.venue.venue import Latencies, Venue
from live.supervisor.cpu_priority import ENGINE_NICE, lower_priority, raise_priority
from live.supervisor.heartbeat import Phase
from live.supervisor.prefork import serve_forks
from live.supervisor.recovery import Death, Recovery
from live.supervisor.state_follower import StateFollower
from live.supervisor.supervisor_link import SupervisorLink, describe_error, is_abandoned

if TYPE_CHECKING:
    from live.app.film.live_recording import LiveSharing
    from live.app.headless_picture import HeadlessPicture


LOWEST_QUALITY = 99
"""A quality level below all others, which selects the lowest one."""
CHECK_INTERVAL = 0.5
"""Interval [s] between checks whether supervisor and engine have ended, while no message arrives."""


def run_warm_standby(
    options: LaunchOptions, lifeline: SupervisorLink, loaded: LoadedShow | None = None, show: Show | None = None, *,
    background: bool, console: Console,
) -> None:  # fmt: skip
    """Prepare, follow the show until the order to take over, then resume it.

    `background`: run at low priority meanwhile; `loaded`, `show`: already loaded, together with all kernels.
    """
    processors = lower_priority() if background else frozenset()
    if loaded is None:
        load_kernels()
        loaded = options.load(whole=False)
    venue = options.read_venue()
    sound = available_audio(options, loaded, venue)
    picture = None
    try:
        picture = open_windows(options, loaded, venue, hidden=True, show=show)
    except Exception as error:  # driver lost: show, lights and audio run without a picture
        lifeline.send_note(f"no picture: {describe_error(error)}")
    try:
        order, following = _follow_until_order(loaded, lifeline)
        if order is None:
            return
        raise_priority(ENGINE_NICE, processors)
        promote(options, loaded, venue, sound, lifeline, following, picture, order, console)
    finally:
        if picture is not None:
            picture.close()


def promote(
    options: LaunchOptions, loaded: LoadedShow, venue: Venue | None, sound: AudioChoice, lifeline: SupervisorLink,
    follower: StateFollower, picture: Any, order: dict[str, Any], console: Console, *, from_other_machine: bool = False,
    headless: "HeadlessPicture | None" = None, sharing: "LiveSharing | None" = None,
) -> None:  # fmt: skip
    """Resume the followed show where it ended.

    `from_other_machine`: it ran on another machine; `headless`, `sharing`: this machine's output meanwhile.
    """
    calm, death = bool(order["calm"]), order["death"]
    if from_other_machine:
        options = LaunchOptions.decode(order["show"])  # with the keys of that machine's page and phones
    if death.get("plain"):
        options = replace(options, quality=LOWEST_QUALITY)
    recovered = Recovery(follower, Death.from_message(death)).run()
    show = recovered.show
    for line in recovered.lines:
        lifeline.send_line(line)
    for words in recovered.notes:
        lifeline.send_note(words)
        show.refusals.add(words)
    lead = Latencies.of(venue, nodes=options.nodes is not None).lead
    origin = follower.local_origin(lead) if from_other_machine else follower.origin
    resumed = ResumeState(
        show, follower.tick, origin, follower.latencies, from_other_machine=from_other_machine,
        audio_start=follower.music_start
    )  # fmt: skip
    session = Session(options, loaded, AudioChoice() if calm else sound, venue, lifeline=lifeline, resumed=resumed)
    if calm:
        session.inbox.put(ChooseSource(time=session.clock.now(), source="supervisor", name="internal"))
    scene = loaded.scene(whole=False)
    if picture is None:
        from live.app.headless_loop import play_headless

        play_headless(session, scene, console, picture=headless, sharing=sharing)
        return
    from live.app.window_loop import run_in_windows

    reveal = None if from_other_machine else bool(order["screen"]["fullscreen"])
    run_in_windows(session, scene, picture, console=console, reveal=reveal, sharing=sharing)


def _follow_until_order(loaded: LoadedShow, lifeline: SupervisorLink) -> tuple[dict[str, Any] | None, StateFollower]:
    """Follow the show until the order to take over; None if there will be no order."""
    following = StateFollower(loaded, heartbeat=lifeline.heartbeat)
    while True:
        lifeline.receive()
        for line in lifeline.lines:
            following.add_line(line)
            lifeline.log.add_line(line)
        lifeline.lines.clear()
        order = lifeline.pop_request("go")
        if order is not None:
            return order, following
        if is_abandoned(lifeline):
            return None, following
        if not following.advance():
            lifeline.beat(following.tick, Phase.WAITING)
            lifeline.wait(CHECK_INTERVAL)


def available_audio(options: LaunchOptions, loaded: LoadedShow, venue: Venue | None) -> AudioChoice:
    """Return the show's audio source; no source if it is not available any more."""
    try:
        return choose_audio(options, loaded, venue, elsewhere=True)
    except PersonError:
        return AudioChoice()


def open_windows(
    options: LaunchOptions, loaded: LoadedShow, venue: Venue | None, *, hidden: bool, show: Show | None = None
) -> Any:
    """Open the windows and warm up the renderer; return None for a show without a picture.

    `hidden`: keep the windows invisible; `show`: drawn once for the warm-up.
    """
    from live.render.window.monitors import list_monitors

    if options.headless or not list_monitors():
        return None
    from live.app.headless_loop import find_screen
    from live.app.window_loop import ShowWindows

    scene = loaded.scene(whole=False)
    try:
        monitor = find_screen(options.monitor)
    except PersonError:  # unplugged since: use any other one
        monitor = None
    picture = ShowWindows.from_options(
        options, scene, monitor=monitor, fullscreen=options.fullscreen, hidden=hidden, venue=venue,
    )  # fmt: skip
    picture.warm_up(show or loaded.start(seed=options.seed))
    return picture


def prefork_engine(
    options: LaunchOptions, prefork_lifeline: SupervisorLink
) -> tuple[SupervisorLink | None, LoadedShow, Show]:
    """Load everything while a show runs, then fork engines on request.

    Return in each of them, with its own lifeline and a show for the renderer's warm-up. The prefork process itself
    returns None as lifeline.
    """
    processors = lower_priority()
    load_kernels()
    for name in ("headless_loop", *(() if options.headless else ("window_loop",))):
        importlib.import_module(f"live.app.{name}")  # imports all that a standby needs
    import_late_modules()
    if not options.headless:
        from live.render.body.body_lookup import build_figure
        from live.render.body.body_mesh import LEVELS
        from live.render.window.monitors import load_glfw

        with contextlib.suppress(ImportError):
            load_glfw()
        for level in LEVELS:
            build_figure(level)
    loaded = options.load(whole=False)
    show = loaded.start(seed=options.seed)  # fills the values cached in the graph
    raise_priority(0, processors)
    gc.collect()
    gc.freeze()
    return serve_forks(prefork_lifeline), loaded, show
