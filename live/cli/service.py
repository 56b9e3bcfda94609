"""Commands `live service install | uninstall | stop | status`: a show run and restarted by the user's systemd."""

from pathlib import Path
from typing import Annotated, Any

import typer

app = typer.Typer(
    help="Run a show with systemd (Linux): started with the machine or the session, restarted whenever it ends.",
    no_args_is_help=True,
)
Name = Annotated[str, typer.Argument(help="The service's name, as `live service status` lists it.")]
PASS_THROUGH = {"allow_extra_args": True, "ignore_unknown_options": True}
REFUSED_OPTIONS = ("--alone", "--record", "--shaders", "--service")
"""Options of `live play` that run a show without a supervisor."""


@app.command("install", context_settings=PASS_THROUGH)
def install(
    context: typer.Context,
    name: Annotated[str | None, typer.Option(help="The service's name. Default: the patch's.")] = None,
    now: Annotated[bool, typer.Option("--now", help="Start it now.")] = False,
) -> None:
    """Write the unit and enable it for the session: live service install my_show --headless …

    The arguments are those of `live play`. Without --journal the show gets a journal, since a restarted service resumes
    from it.
    """
    import os

    import platformdirs
    from rich.console import Console

    from live.app.machine.systemd_unit import (
        OWN_JOURNAL,
        SystemdService,
        default_service_name,
        linger_enabled,
        systemctl,
        systemd_version,
        units_folder,
    )
    from live.app.option_values import expand_optional_values
    from live.library.whole_file import write_atomically

    arguments = expand_optional_values(context.args)
    asked = _parse_play_arguments(arguments)
    service = SystemdService(
        name or default_service_name(asked.get("patch")),
        arguments,
        Path.cwd(),
        bool(asked["headless"]),
        dict(os.environ),
    )
    if asked["journal"] is None:
        folder = Path(platformdirs.user_state_dir("choreographics-live"))
        folder.mkdir(parents=True, exist_ok=True)
        arguments += [OWN_JOURNAL, str(folder / f"{service.name}.jsonl")]
    folder = units_folder()
    folder.mkdir(parents=True, exist_ok=True)
    text = service.text(version=systemd_version())
    write_atomically(text.encode(), folder / service.unit, "the unit")
    console = Console(highlight=False)
    console.print(f"written: {folder / service.unit}", soft_wrap=True, markup=False)
    begin = ["enable", *(["--now"] if now else []), service.unit]
    for words in (["daemon-reload"], begin):
        if (problem := systemctl(*words)) is not None:
            console.print(
                f"failed: systemctl --user {' '.join(words)}: {problem}", style="yellow", soft_wrap=True, markup=False
            )
    if not now:
        console.print(f"to start it now: systemctl --user start {service.unit}", soft_wrap=True, markup=False)
    if not linger_enabled():
        console.print(
            "it ends when you log out; to start it with the machine and keep it running: loginctl enable-linger",
            soft_wrap=True, markup=False,
        )  # fmt: skip


@app.command("uninstall")
def uninstall(name: Name) -> None:
    """End the show and remove its unit; the journal is kept."""
    from rich.console import Console

    from live.app.machine.systemd_unit import systemctl, unit_name, units_folder
    from live.base.errors import PersonError

    path = units_folder() / unit_name(name)
    if not path.is_file():
        raise PersonError(f"there is no service {name}: no {path}", "live service status")
    _stop_service(name)
    systemctl("disable", unit_name(name))
    path.unlink()
    systemctl("daemon-reload")
    Console(highlight=False).print(f"removed: {path}", soft_wrap=True, markup=False)


@app.command("stop")
def stop(name: Name) -> None:
    """End the show: its service, and any engine that runs without a supervisor."""
    from rich.console import Console

    from live.app.machine.systemd_unit import check_name

    ended, problem = _stop_service(check_name(name))
    console = Console(highlight=False)
    for pid in ended:
        console.print(f"ended an engine without a supervisor (process {pid})")
    if problem is not None:
        console.print(f"systemctl --user stop: {problem}", style="yellow", markup=False)


@app.command("status")
def status() -> None:
    """List the services, with their state, number of restarts, and whether they outlive a logout."""
    from rich.console import Console

    from live.app.machine.systemd_unit import linger_enabled, unit_state, units_folder

    console = Console(highlight=False)
    found = sorted(units_folder().glob("live-*.service"))
    for path in found:
        name = path.stem.removeprefix("live-")
        console.print(f"{name}: {unit_state(path.name)}", soft_wrap=True, markup=False)
    if not found:
        console.print(f"no service in {units_folder()}; live service install [PLAY ARGUMENTS]", markup=False)
    lingers = "start with the machine and outlive a logout" if linger_enabled() else "end with the session"
    console.print(f"services of this user {lingers} (loginctl enable-linger, disable-linger)", soft_wrap=True)


def _parse_play_arguments(arguments: list[str]) -> dict[str, Any]:
    """Return the parameters that `live play` would parse from these arguments; raise PersonError if it would fail."""
    import click

    from live.base.errors import PersonError
    from live.cli.play import play

    one = typer.Typer(add_completion=False)
    one.command()(play)
    for option in REFUSED_OPTIONS:
        if any(each == option or each.startswith(f"{option}=") for each in arguments):
            raise PersonError(f"{option} cannot be used with a service", "leave it out")
    try:
        return typer.main.get_command(one).make_context("live play", list(arguments)).params
    except click.exceptions.Exit:
        raise PersonError("--help: nothing to install", "live play --help") from None
    except click.ClickException as error:
        raise PersonError(f"live play rejects these arguments: {error.format_message()}", "live play --help") from None


def _stop_service(name: str) -> tuple[list[int], str | None]:
    """Stop the service, then any remaining engines; return their process ids, and systemd's error or None."""
    from live.app.machine.systemd_unit import systemctl, unit_name
    from live.app.processes.engine_main import service_label
    from live.supervisor.adoption.adoption import end_engines

    problem = systemctl("stop", unit_name(name))
    return end_engines(service_label(name)), problem
