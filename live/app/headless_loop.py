"""Frame loop without a window, and the choice between window, film and headless run for `live play`.

A headless show runs in real time, for rehearsals, tests and long runs. It draws only if it is recorded or shared.
"""

import contextlib
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rich.console import Console

from live.app.bridges import installed_bridges
from live.app.headless_picture import HeadlessPicture
from live.app.launch_options import LaunchOptions
from live.app.machine.kernel_warmup import is_warm, warm_kernels
from live.app.processes.audio_client import prepare_music
from live.app.session import Session
from live.app.session_audio import AudioChoice, choose_audio
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.base.stage_snapshot import Scene, StageView
from live.control.keyboard import help_lines
from live.render.timing.frame_stats import Pacer
from live.render.window.monitors import Monitor, UnknownMonitor, list_monitors, resolve_monitor, screen_problem
from live.show.loader import LoadedShow
from live.show.patch.patch_search_path import show_stem
from live.show.patch.section_score import formation_names
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.app.adaptive_quality import QualityController
    from live.app.film.live_recording import LiveSharing
    from live.render.window.start_window import StartWindow
    from live.show.patch.patch import Patch


def play_headless(
    session: Session, scene: Scene, console: Console, *, picture: HeadlessPicture | None = None,
    sharing: "LiveSharing | None" = None,
) -> None:  # fmt: skip
    """Run until the time limit or Ctrl-C; draw only if the picture is recorded or shared.

    `picture`, `sharing`: already made by a standby; the caller releases them.
    """
    if session.lifeline is not None:
        session.engine.on_error = lambda error: FAULTS.record("drawing", error)
    if session.options.record is None and not session.options.share:
        with session.running():
            _loop(session, lambda view: None, session.options.film_fps)
        return
    made = picture or HeadlessPicture(session.options, scene)
    try:
        _draw(session, made, console, sharing)
    finally:
        if picture is None:
            made.close()


def _draw(session: Session, picture: HeadlessPicture, console: Console, sharing: "LiveSharing | None") -> None:
    from live.app.adaptive_quality import QualityController, handle_pass_resets, watch_shaders
    from live.app.film.live_recording import live_fps
    from live.app.window_loop import FrameSinks
    from live.show.view.render_scene import draw_patch

    options, renderer = session.options, picture.renderer
    session.status.extra_figures["flashes_held"] = lambda: picture.flashes.dimmed_count
    rate = live_fps(options, picture.ctx)
    watch = None if options.quality is None else QualityController(session, renderer)  # without --quality: best
    if watch is not None:
        watch.period = 1.0 / rate
    if watch is None:
        handle_pass_resets(session, renderer)
        session.status.notices.append(lambda: "; ".join(renderer.problems))
    takers = FrameSinks(session, picture.ctx, options.size, sharing=sharing)
    shaders = watch_shaders(session, renderer.reload_shaders)

    def update_patch(patch: "Patch") -> None:
        with contextlib.suppress(PersonError):  # compiled once before; else the last good one stays
            draw_patch(renderer, patch)

    if watch is None:
        session.engine.patch_listeners.append(update_patch)
    update_patch(session.show.patch)  # of a show that goes on, it may have been edited

    def draw(view: StageView) -> None:
        if shaders is not None:
            shaders.check(session.clock.now())
        framebuffer = picture.draw(view, session.clock.now)
        takers.frame(framebuffer, session.clock.now())

    try:
        with session.running():
            _loop(session, draw, rate, watch)
    finally:
        takers.close(console)


def _loop(
    session: Session, draw: Callable[[StageView], None], rate: float, watch: "QualityController | None" = None
) -> None:
    pacer = Pacer(rate, session.clock.now, time.sleep)
    previous = session.clock.now()
    while True:
        started = pacer.wait()
        if watch is not None:
            watch.begin(pacer.late, started - previous)
        session.before_frame()
        session.engine.frame(draw)
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        if watch is not None:
            watch.end()
        previous = started
        if session.finished(started):
            return


FILM_SECONDS = 20.0


def play_show(options: LaunchOptions, *, lifeline: SupervisorLink | None = None) -> None:
    """Play the show in a window, as a film or headless; raise PersonError if that is not possible.

    `lifeline`: the link to the supervisor, if there is one.
    """
    console = Console(stderr=True, highlight=False)
    with contextlib.ExitStack() as start:
        try:
            loaded = _load(options, console, start)
        except StartCancelled:
            return
        _play(options, loaded, console, lifeline, opened=start.close)


def _play(
    options: LaunchOptions, loaded: LoadedShow, console: Console, lifeline: SupervisorLink | None,
    opened: Callable[[], None],
) -> None:  # fmt: skip
    """Play a loaded show; `opened` is called when its windows are open."""
    venue = options.read_venue()
    for note in (*loaded.graph.missing, *loaded.notes, *installed_bridges().notes(loaded, venue)):
        console.print(f"note: {note}", style="yellow", soft_wrap=True, markup=False)
    if options.shaders is not None:
        from live.app.adaptive_quality import use_shader_folder

        use_shader_folder(options.shaders, console)
    there = None if lifeline is None else lifeline.sound
    sound = choose_audio(options, loaded, venue, elsewhere=there is not None)
    if there is not None and sound.path is not None:
        prepare_music(there, sound.path)
    chosen = find_screen(options.monitor)
    if options.headless:
        _headless(Session(options, loaded, sound, venue, lifeline=lifeline), console)
    elif list_monitors():
        from live.app.window_loop import play_in_window

        session = Session(options, loaded, sound, venue, lifeline=lifeline)
        keys = help_lines(formation_names(loaded.patch.formation))
        console.print("\n".join([_welcome(session), *keys]), style="dim", soft_wrap=True, markup=False)
        play_in_window(
            session, loaded.scene(), monitor=chosen, fullscreen=options.fullscreen, console=console, opened=opened
        )
    elif options.fullscreen:
        raise PersonError(f"--fullscreen: {screen_problem()}", "leave it out to make a film")
    elif sound.device is not None:
        console.print(f"{screen_problem()}; listening and running without a picture", style="dim")
        _headless(Session(options, loaded, sound, venue, lifeline=lifeline), console)
    else:
        _film(options, loaded, sound, console)


class StartCancelled(Exception):
    """The window of a first start was closed."""


def _load(options: LaunchOptions, console: Console, start: contextlib.ExitStack) -> LoadedShow:
    """Load the show. On a first start compile what its first frames need; a window, which `start` closes, shows it.

    Raise StartCancelled if the user closes that window.
    """
    if is_warm():
        return options.load()
    from live.app.machine.kernel_loader import rehearse_show

    window = None if options.headless else _open_start_window(options)
    if window is not None:
        start.callback(window.close)

    def show(line: str, share: float) -> None:
        if window is not None and not window.show(line, share):
            raise StartCancelled

    warm_kernels(
        console, lambda done, total, share: show(f"compiling for this machine, once: {done} of {total}", share)
    )
    show("loading the show", 1.0)
    loaded = options.load()
    rehearse_show(loaded, options.seed)
    show("opening the windows", 1.0)
    return loaded


def _open_start_window(options: LaunchOptions) -> "StartWindow | None":
    from live.render.window.start_window import StartWindow
    from live.render.window.window import NoWindow
    from live.show.patch.patch_search_path import find_patch

    path = find_patch(options.patch)
    title = (path.parent.name if path.stem in ("show", "patch") else path.stem).replace("_", " ")
    if not list_monitors():
        return None
    try:
        return StartWindow(
            title, monitor=find_screen(options.monitor), fullscreen=options.fullscreen, size=options.size
        )
    except (NoWindow, UnknownMonitor):  # the show's own windows will say why
        return None


def find_screen(name: str | None) -> Monitor | None:
    """Return the monitor with that number, name or position; None for None.

    Raise PersonError, which lists the monitors, if there is no such monitor.
    """
    if name is None:
        return None
    try:
        return resolve_monitor(name)
    except UnknownMonitor as error:
        raise PersonError(f"--monitor: {error}") from None


def _headless(session: Session, console: Console) -> None:

    console.print(f"{_welcome(session)}; Ctrl-C stops it", style="dim", soft_wrap=True, markup=False)
    play_headless(session, session.loaded.scene(), console)


def _film(options: LaunchOptions, loaded: LoadedShow, sound: AudioChoice, console: Console) -> None:
    from pathlib import Path

    from live.app.film.show_film import film_show

    seconds = options.seconds or FILM_SECONDS
    path = options.record or Path(f"{show_stem(options.patch)}.mp4")
    console.print(f"{screen_problem()}; rendering {seconds:g} s of the show to a film", style="dim", soft_wrap=True)
    if options.osc != LaunchOptions().osc:
        console.print("note: a film receives no OSC; use --headless to play in real time", style="yellow", markup=False)
    film_show(options, loaded, sound, path=path, seconds=seconds, console=console)
    console.print(f"the film is here: {path.resolve()}", soft_wrap=True, markup=False)


def _welcome(session: Session) -> str:
    host, port = session.options.osc
    song = session.options.midi_file
    heard = "music file" if session.sound.file else session.sound.device or "internal clock"
    heard = heard if song is None else song.name
    return f"{session.loaded.patch.name}: {session.loaded.patch.dancer_count} dancers, {heard}, OSC at {host}:{port}"
