"""What `live play` does with a wish: a window where there is a screen, else a film, or a bare run in real time."""

from rich.console import Console

from live.app.kernel_warmup import warm_kernels
from live.app.session import Session
from live.app.session_sound import Sound, choose_sound
from live.app.wish import Wish
from live.base.errors import PersonError
from live.control.keyboard import help_lines
from live.render.window.monitor_places import find_place
from live.render.window.monitors import Monitor, UnknownMonitor, list_monitors, screen_problem
from live.show.load import LoadedShow
from live.show.patch.segment import formation_names
from live.supervisor.lifeline import Lifeline

FILM_SECONDS = 20.0
FILM_NAME = "first-show.mp4"


def play_show(
    wish: Wish, *, monitor: str | None, fullscreen: bool, headless: bool, lifeline: Lifeline | None = None
) -> None:
    """Play what `wish` asks for; PersonError if that cannot be. `lifeline`: to the supervisor, if there is one."""
    console = Console(stderr=True, highlight=False)
    warm_kernels(console)
    loaded = wish.load()
    for note in loaded.graph.missing:
        console.print(f"note: {note}", style="yellow", markup=False)
    if wish.shaders is not None:
        from live.app.shader_watch import begin_with

        begin_with(wish.shaders, console)
    venue = wish.read_venue()
    sound = choose_sound(wish, loaded, venue)
    chosen = find_screen(monitor)
    if headless:
        _headless(Session(wish, loaded, sound, venue, lifeline=lifeline), console)
    elif list_monitors():
        from live.app.window_show import play_in_window

        session = Session(wish, loaded, sound, venue, lifeline=lifeline)
        keys = help_lines(formation_names(loaded.patch.formation))
        console.print("\n".join([_welcome(session), *keys]), style="dim", soft_wrap=True, markup=False)
        play_in_window(session, loaded.scene(), monitor=chosen, fullscreen=fullscreen, console=console)
    elif fullscreen:
        raise PersonError(f"--fullscreen: {screen_problem()}", "leave it out to make a film")
    elif sound.device is not None:
        console.print(f"{screen_problem()}; listening and running without a picture", style="dim")
        _headless(Session(wish, loaded, sound, venue, lifeline=lifeline), console)
    else:
        _film(wish, loaded, sound, console)


def find_screen(name: str | None) -> Monitor | None:
    """The monitor of that number, name or place; None for none. PersonError that lists those there are."""
    if name is None:
        return None
    try:
        return find_place(name)
    except UnknownMonitor as error:
        raise PersonError(f"--monitor: {error}") from None


def _headless(session: Session, console: Console) -> None:
    from live.app.headless_show import play_headless

    console.print(f"{_welcome(session)}; Ctrl-C ends it", style="dim", soft_wrap=True, markup=False)
    play_headless(session, session.loaded.scene(), console)


def _film(wish: Wish, loaded: LoadedShow, sound: Sound, console: Console) -> None:
    from pathlib import Path

    from live.app.film_show import film_show

    seconds = wish.seconds or FILM_SECONDS
    path = wish.record or Path(FILM_NAME)
    console.print(f"{screen_problem()}; {seconds:g} s of the show become a film", style="dim", soft_wrap=True)
    if wish.osc != Wish().osc:
        console.print("note: a film takes no OSC; use --headless to play in real time", style="yellow", markup=False)
    film_show(wish, loaded, sound, path=path, seconds=seconds, console=console)
    console.print(f"the film is here: {path.resolve()}", soft_wrap=True, markup=False)


def _welcome(session: Session) -> str:
    host, port = session.wish.osc
    song = session.wish.midi_file
    heard = "music file" if session.sound.music else session.sound.device or "internal clock"
    heard = heard if song is None else song.name
    return f"{session.loaded.patch.name}: {session.loaded.patch.dancer_count} dancers, {heard}, OSC at {host}:{port}"
