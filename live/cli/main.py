"""Entry point of the command `live`: registers the commands and turns errors into one line and an exit code.

Every command is a function in a separate module that declares its options. Heavy imports are inside the functions,
so that `live --help` needs neither numba nor OpenGL.
"""

import sys
from typing import Annotated

import typer

from live import __version__
from live.app.bridges import installed_bridges
from live.app.exit_codes import (
    EXIT_INTERRUPTED,
    EXIT_PERSON_ERROR,
    collect_garbage_rarely,
    install_signal_handlers,
    show_person_error,
)
from live.app.machine import kernel_warmup as warm
from live.app.option_values import expand_audience_option
from live.base.errors import PersonError
from live.cli import bench, document, music, pair, play, render, replay, service, simulate, soak
from live.cli.beats import beats, clock_check
from live.cli.inspect import check, contact_sheet, formation, journal, schema, score
from live.cli.motion import bvh, character, export, sync
from live.cli.steps import dance, partner, steps, texture
from live.cli.venue import calibrate, devices, doctor

app = typer.Typer(
    name="live",
    help="Virtual dancers that dance live to music, on a projector.",
    epilog="Play the first show: [bold]live play[/]. Check this machine: [bold]live doctor[/].",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.command("play")(play.play)
app.command("studio")(play.studio)
app.command("render")(render.render)
app.command("replay")(replay.replay)
app.command("check")(check.check)
app.command("score")(score.score)
app.command("contact-sheet")(contact_sheet.contact_sheet)
app.command("clock-check")(clock_check.clock_check)
app.command("dance")(dance.dance)
app.command("devices")(devices.devices)
app.command("calibrate")(calibrate.calibrate)
app.command("character")(character.character)
app.command("doctor")(doctor.doctor)
app.command("beats")(beats.beats)
app.command("bench")(bench.bench)
app.command("bvh")(bvh.bvh)
app.command("pair")(pair.pair)
app.command("partner")(partner.partner)
app.command("export")(export.export)
app.command("formation")(formation.formation)
app.command("schema")(schema.schema)
app.command("sim")(simulate.sim)
app.command("simulate")(simulate.simulate)
app.command("soak")(soak.soak)
app.command("texture")(texture.texture)
app.command("warm")(warm.warm)
app.command("sync")(sync.sync)
app.add_typer(document.app, name="document")
app.add_typer(journal.app, name="journal")
app.add_typer(music.app, name="music")
app.add_typer(steps.app, name="steps")
app.add_typer(service.app, name="service")
for bridge in installed_bridges().bridges:
    for name, command in bridge.commands().items():
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
        else:
            app.command(name)(command)


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
    sys.argv[1:] = expand_audience_option(sys.argv[1:])
    try:
        app()
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
