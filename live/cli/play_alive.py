"""Options of `live play` for who watches over it, and takes over when it ends."""

from typing import Annotated

import typer

PANEL = "Staying alive"

Alone = Annotated[
    bool,
    typer.Option(
        "--alone",
        help="One process only: nobody watches over the show and takes over when it ends in a crash.",
        rich_help_panel=PANEL,
    ),
]
Lead = Annotated[
    str | None,
    typer.Option(
        help="Let machines that stand by follow this show here.", metavar="[HOST:]PORT", rich_help_panel=PANEL
    ),
]
Service = Annotated[
    str | None,
    typer.Option(
        help="Which service this is (`live service install` writes it): a start goes on with what was cut off.",
        metavar="NAME",
        rich_help_panel=PANEL,
    ),
]
Standby = Annotated[
    str | None,
    typer.Option(
        help="Follow the show of the machine that leads there, and take over when it falls silent.",
        metavar="HOST[:PORT]",
        rich_help_panel=PANEL,
    ),
]
