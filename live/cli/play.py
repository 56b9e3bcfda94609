"""`live play`: the show, live; on a machine without a screen its film. `live studio`: the same with the studio's page.

Its options are those of `LaunchOptions` and of the bridges.
"""

import inspect
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import Field, fields
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from live.app.bridges import installed_bridges
from live.app.launch_options import NETWORK, PROGRAMS, LaunchOptions
from live.app.option_values import OPTION, Option

NewWebKey = Annotated[
    bool,
    typer.Option(
        "--new-web-key",
        help="Make another key for that page: the old one lets nobody in any more.",
        rich_help_panel=NETWORK,
    ),
]


def with_launch_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the parameters that it has itself, and one for each of the launch options.

    `command` takes what was written as keyword arguments. Typer reads the signature that is set here.
    """
    parameters = [
        inspect.Parameter(each.name, inspect.Parameter.KEYWORD_ONLY, default=how.default, annotation=_annotation(
            each.name, types[each.name], how, None if kind is LaunchOptions else PROGRAMS
        ))
        for kind in _option_classes()
        for types in [get_type_hints(kind)]
        for each, how in _options(kind)
    ]  # fmt: skip
    own = [
        each for each in inspect.signature(command).parameters.values() if each.kind is inspect.Parameter.KEYWORD_ONLY
    ]
    command.__signature__ = inspect.Signature([*parameters, *own])  # type: ignore[attr-defined]
    return command


def _option_classes() -> list[type[Any]]:
    """The dataclasses whose fields are options of this command."""
    return [LaunchOptions, *(bridge.options for bridge in installed_bridges().bridges)]


def _options(kind: type[Any]) -> Iterator[tuple[Field[Any], Option]]:
    """The fields of a dataclass that are options."""
    for each in fields(kind):
        how = each.metadata.get(OPTION)
        if how is not None:
            yield each, how


def _annotation(name: str, own: Any, how: Option, panel: str | None) -> Any:
    written = own if how.written is None else how.written
    if how.default is None:
        written |= None
    make: Callable[..., Any] = typer.Argument if how.argument else typer.Option
    flags = () if how.argument else how.flags or (f"--{name.replace('_', '-')}",)
    details = {"help": how.help, "rich_help_panel": how.panel or panel, **how.details}
    return Annotated[written, make(*flags, **details)]


def parsed(written: dict[str, Any]) -> dict[str, Any]:
    """The fields of `LaunchOptions` from what was written; PersonError names the option that is wrong."""
    bridges = {}
    for bridge in installed_bridges().bridges:
        found = bridge.options(**_parsed_fields(bridge.options, written))
        if found != bridge.options():
            bridges[bridge.name] = found
    return _parsed_fields(LaunchOptions, written) | {"bridges": bridges}


def _parsed_fields(kind: type[Any], written: dict[str, Any]) -> dict[str, Any]:
    """The fields of one dataclass that are options."""
    values = {}
    for each, how in _options(kind):
        value = written[each.name]
        if value is None:
            value = each.default
        elif how.parse is not None:
            value = how.parse(value, (how.flags or (f"--{each.name.replace('_', '-')}",))[0])
        values[each.name] = value
    return values


@with_launch_options
def play(*, new_web_key: NewWebKey = False, **written: Any) -> None:
    """Play a show: music in, dancers on the projector.

    Keys: Space tap, 1 this is the one, B blackout, F full screen, O overlay, S spread; click or drag = attractor,
    with shift = repulsor. Closing the window, Esc in a window or Ctrl-C here ends the show; music from a file begins
    again at its end. Without a screen, 20 s of the show become a film of its name, as first-show.mp4.
    """
    import secrets
    from dataclasses import replace

    from rich.console import Console

    from live.app.machine.kernel_warmup import start_native_build, warm_kernels
    from live.app.option_values import check_film_path
    from live.app.processes.engine_main import is_supervised, supervise
    from live.app.services.http_services import parse_web
    from live.show.patch.patch_search_path import find_patch

    values = parsed(written)
    check_film_path(values["record"], "--record", inputs=[values["audio"], values["patch"]])
    find_patch(values["patch"])  # an unknown name is reported before seconds of loading
    console = Console(stderr=True, highlight=False)
    page = parse_web(
        written["web"], key=written["web_key"], new_key=new_web_key, hosts=values["web_hosts"],
        note=lambda words: console.print(f"note: {words}", style="yellow", markup=False, soft_wrap=True),
    )  # fmt: skip
    values |= {"web_key": page.key, "audience_secret": b"" if values["audience"] is None else secrets.token_bytes(32)}
    options = LaunchOptions(**values)
    options.check_privacy()
    if is_supervised(options):
        try:
            supervise(options if options.osc_process is not None else replace(options, osc_process=True))
        finally:
            start_native_build()
        return
    warm_kernels(console)  # before anything is imported that has kernels
    from live.app.headless_loop import play_show

    play_show(options)


STUDIO_PORT = 8010
START_TIMEOUT = 120.0
"""Longest wait for the engine to answer the browser [s]."""


def studio(
    patch: Annotated[
        str | None,
        typer.Argument(metavar="[SHOW]", help="A patch: a file, a folder, or a name. Left out: chosen on the page."),
    ] = None,
    web: Annotated[str, typer.Option(help="Where the page is served.", metavar="[HOST:]PORT")] = str(STUDIO_PORT),
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
    osc: Annotated[
        str | None,
        typer.Option(help="Where OSC is received; default: 9010.", metavar="[HOST:]PORT"),
    ] = None,
    song: Annotated[
        Path | None, typer.Option(help="Begin a new show in the folder SHOW, to this music.", metavar="FILE")
    ] = None,
    dancers: Annotated[int | None, typer.Option(help="Number of dancers of a new show. Default: 12.")] = None,
    from_: Annotated[
        str | None, typer.Option("--from", help="Begin a new show in the folder SHOW, as a copy of an example.")
    ] = None,
    journal: Annotated[
        Path | None, typer.Option(help="Write the journal here, for `live replay`.", metavar="FILE")
    ] = None,
) -> None:
    """Make a show where it is seen: the studio in the browser; the show runs here without a projector.

    Without a show that exists the page asks for one: it is begun from a song or an example, in this folder, or opened.
    `live play SHOW --web` serves the same page beside a projector.
    """
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels

    warm_kernels(Console(stderr=True, highlight=False))  # the first time it takes up to a minute, and says so
    if song is not None or from_ is not None or dancers is not None:
        from live.app.services.new_show import make_show

        patch = str(make_show(Path(patch or "my show"), song=song, dancers=dancers, example=from_))
    from live.app.option_values import parse_endpoint
    from live.app.services.http_services import stored_key

    key, where = stored_key(), parse_endpoint(web, "--web")
    if browser:
        open_browser_later(where, key)
    if patch is None or not _is_there(patch):
        from live.app.services.studio_start import choose_show

        print(f"studio: {studio_link(where, key)}", file=sys.stderr)
        patch = choose_show(Path.cwd(), Path(patch or "").name, where, key)
    written = {each.name: None for kind in _option_classes() for each, _ in _options(kind)}
    play(**{**written, "patch": patch, "web": web, "web_key": key, "osc": osc, "journal": journal, "headless": True})


def _is_there(patch: str) -> bool:
    """Whether a show has this name."""
    from live.base.errors import PersonError
    from live.show.patch.patch_search_path import find_patch

    try:
        find_patch(patch)
    except PersonError:
        return False
    return True


def _host_here(host: str) -> str:
    """Return the host at which this machine reaches a server that listens at `host`."""
    return {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)


def studio_link(where: tuple[str, int], key: str) -> str:
    """Return the address of the studio that is served at `where`, with its key."""
    host = _host_here(where[0])
    return f"http://{f'[{host}]' if ':' in host else host}:{where[1]}/studio#key={key}"


def open_browser_later(where: tuple[str, int], key: str) -> None:
    """Open the studio in the browser, by a thread, as soon as it is served at `where`."""
    from live.base.fault_isolation import run_once

    task = "opening the browser", partial(_open_browser, where, key)
    threading.Thread(target=run_once, args=task, daemon=True).start()


def _open_browser(where: tuple[str, int], key: str) -> None:
    """Open the studio in the browser as soon as the engine answers."""
    import webbrowser

    end = time.monotonic() + START_TIMEOUT
    while time.monotonic() < end:
        try:
            socket.create_connection((_host_here(where[0]), where[1]), timeout=1.0).close()
        except OSError:
            time.sleep(0.2)
            continue
        webbrowser.open(studio_link(where, key))
        return
