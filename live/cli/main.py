"""Entry point of the command `live`: registers the commands and turns errors into one line and an exit code.

Every command is a function in a separate module that declares its options. Heavy imports are inside the functions,
so that `live --help` needs neither numba nor OpenGL.
"""

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Final

import typer
from typer.core import TyperGroup

from live import __version__
from live.app.bridges import installed_bridges
from live.app.exit_codes import (
    EXIT_INTERRUPTED,
    EXIT_PERSON_ERROR,
    collect_garbage_rarely,
    install_signal_handlers,
    show_person_error,
)
from live.app.launch_options import COMMON_OPTIONS
from live.app.machine import kernel_warmup as warm
from live.app.option_values import expand_optional_values
from live.base.errors import PersonError
from live.cli import (
    bench,
    cluster,
    docs,
    document,
    gateway,
    music,
    node,
    pair,
    play,
    render,
    replay,
    service,
    simulate,
    soak,
)
from live.cli.beats import beats, clock_check
from live.cli.inspect import check, contact_sheet, formation, journal, schema, score, sheets
from live.cli.motion import bvh, character, export, sync
from live.cli.steps import couple, dance, partner, steps, texture
from live.cli.venue import calibrate, devices, doctor

_TAG: Final = re.compile(r"(\\*)(\[[a-zA-Z#/@][^\[\]]*\])")
"""What rich takes for markup in a text."""


def _escape_help(command: Any) -> None:
    """Let rich print the brackets in all helps below `command`, such as those of a table `[[react]]`."""
    for each in (command, *command.params):
        text = getattr(each, "help", None)
        if text:
            each.help = _TAG.sub(r"\1\1\\\2", text)
    for below in getattr(command, "commands", {}).values():
        _escape_help(below)


HELP, HELP_ALL = "--help", "--help-all"


def _shorten_help(command: Any) -> None:
    """Leave what few shows need out of the help of `live play`, and say how to see it."""
    for each in command.params:
        each.hidden = each.name not in COMMON_OPTIONS and each.param_type_name != "argument" and each.name != "help"
    command.epilog = f"All {len(command.params) - 1} options: [bold]live {command.name} {HELP_ALL}[/]."


class _Commands(TyperGroup):
    """All commands."""

    def main(self, args: Sequence[str] | None = None, *arguments: Any, **options: Any) -> Any:
        """Run one of them."""
        words = list(sys.argv[1:] if args is None else args)
        _escape_help(self)
        if words[:1] == ["play"] and HELP_ALL not in words:
            _shorten_help(self.commands["play"])
        return super().main([HELP if word == HELP_ALL else word for word in words], *arguments, **options)


app = typer.Typer(
    name="live",
    cls=_Commands,
    help="Virtual dancers that dance live to music, on a projector.\n\n"
    "First show: [bold]live play[/]. Check this machine: [bold]live doctor[/]. Read: [bold]live docs[/].",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Registered = Callable[..., None] | typer.Typer
HALL: Final = "The hall and its machines"
PANELS: Final[Mapping[str, Mapping[str, Registered]]] = {
    "Play and film": {"play": play.play, "studio": play.studio, "render": render.render, "replay": replay.replay},
    "Shows": {
        "check": check.check,
        "score": score.score,
        "sheets": sheets.sheets,
        "contact-sheet": contact_sheet.contact_sheet,
        "formation": formation.formation,
        "document": document.app,
        "journal": journal.app,
        "schema": schema.schema,
    },
    "Steps and motion": {
        "steps": steps.app,
        "dance": dance.dance,
        "texture": texture.texture,
        "partner": partner.partner,
        "couple": couple.app,
        "export": export.export,
        "bvh": bvh.bvh,
        "sync": sync.sync,
        "character": character.character,
    },
    "Music": {"beats": beats.beats, "music": music.app, "clock-check": clock_check.clock_check},
    HALL: {
        "doctor": doctor.doctor,
        "devices": devices.devices,
        "calibrate": calibrate.app,
        "pair": pair.pair,
        "gateway": gateway.gateway,
        "node": node.node,
        "cluster": cluster.app,
        "service": service.app,
        "warm": warm.warm,
    },
    "Help": {"docs": docs.docs},
    "For those who work on it": {
        "bench": bench.bench,
        "soak": soak.soak,
        "sim": simulate.sim,
        "simulate": simulate.simulate,
    },
}
"""All commands, by whom they are for. Those of bridges are added to HALL, their calibrations to `live calibrate`."""


def _register(name: str, command: Registered, panel: str | None, group: typer.Typer = app) -> None:
    if isinstance(command, typer.Typer):
        group.add_typer(command, name=name, rich_help_panel=panel)
    else:
        group.command(name, rich_help_panel=panel)(command)


for _panel, _commands in PANELS.items():
    for _name, _command in _commands.items():
        _register(_name, _command, _panel)
for _bridge in installed_bridges().bridges:
    for _name, _command in _bridge.commands().items():
        _register(_name, _command, HALL)
    for _name, _command in _bridge.calibrations().items():
        _register(_name, _command, None, calibrate.app)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"live {__version__}")
        raise typer.Exit


@app.callback()
def _live(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Options before the command."""


def main() -> None:
    """Run the command line and exit: 0 done, 1 a check failed, 2 a usage error, 130 Ctrl-C."""
    install_signal_handlers()
    collect_garbage_rarely()
    sys.argv[1:] = expand_optional_values(sys.argv[1:])
    try:
        app()
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
