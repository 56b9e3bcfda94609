"""The command `live`: registers the commands and turns errors into one line and an exit code.

Every command is a function in a module of its own. Those modules hold the options and no heavy import at the top,
so that `live --help` needs neither numba nor OpenGL; what a command works with is imported when it runs.
"""

import signal
import sys
from typing import Annotated

import typer
from rich.console import Console
from rich.text import Text

from live import __version__
from live.base.errors import PersonError
from live.cli import (
    beats,
    bench,
    bvh,
    calibrate,
    character,
    check,
    clock_check,
    contact_sheet,
    dance,
    devices,
    doctor,
    export,
    formation,
    journal,
    layout,
    mocap,
    pair,
    partner,
    play,
    render,
    replay,
    schema,
    score,
    service,
    sim,
    simulate,
    soak,
    steps,
    sync,
    texture,
    warm,
)
from live.cli.options import with_audience

EXIT_PERSON_ERROR = 2
EXIT_INTERRUPTED = 130

app = typer.Typer(
    name="live",
    help="Virtual dancers that dance live to music, on a projector.",
    epilog="The first show: [bold]live play[/]. What is missing on this machine: [bold]live doctor[/].",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

app.command("play")(play.play)
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
app.command("layout")(layout.layout)
app.command("schema")(schema.schema)
app.command("sim")(sim.sim)
app.command("simulate")(simulate.simulate)
app.command("soak")(soak.soak)
app.command("texture")(texture.texture)
app.command("warm")(warm.warm)
app.command("sync")(sync.sync)
app.add_typer(mocap.app, name="mocap")
app.add_typer(journal.app, name="journal")
app.add_typer(steps.app, name="steps")
app.add_typer(service.app, name="service")


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


def show_person_error(error: PersonError) -> None:
    """Print the error on stderr: one line, and one more for the remedy; nothing in it is read as markup."""
    console = Console(stderr=True, soft_wrap=True, highlight=False)
    console.print(Text.assemble(("error: ", "bold red"), " ".join(error.message.split())))
    if error.remedy is not None:
        console.print(Text.assemble(("  try: ", "bold"), error.remedy))


def end_cleanly() -> None:
    """Closed terminals, `kill` and a second Ctrl-C must not cost the film and the end of the journal.

    Scripts start what runs behind `&` with Ctrl-C ignored; here it always counts.
    """

    def interrupt(_number: int, _frame: object) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # closing takes a moment: let it
        raise KeyboardInterrupt

    def leave(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_IGN)
        raise SystemExit(128 + number)

    signal.signal(signal.SIGINT, interrupt)
    for name in ("SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), leave)


def main() -> None:
    """Run the command line and exit: 0 done, 1 a check failed, 2 an error of use, 130 Ctrl-C."""
    end_cleanly()
    sys.argv[1:] = with_audience(sys.argv[1:])
    try:
        app()
    except PersonError as error:
        show_person_error(error)
        sys.exit(EXIT_PERSON_ERROR)
    except KeyboardInterrupt:
        sys.exit(EXIT_INTERRUPTED)
