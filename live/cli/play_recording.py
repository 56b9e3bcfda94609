"""Options of `live play` for what is kept of it, or given to others: film, picture, journal, figures."""

from pathlib import Path
from typing import Annotated

import typer

PANEL = "Recording"

Record = Annotated[
    Path | None,
    typer.Option(help="Record the picture as an mp4.", metavar="FILE.mp4", rich_help_panel=PANEL),
]
Share = Annotated[
    list[str] | None,
    typer.Option(
        help="Share the picture with other programs: shm:NAME, or a stream like udp://127.0.0.1:5000.",
        metavar="shm:NAME|URL",
        rich_help_panel=PANEL,
    ),
]
Journal = Annotated[Path | None, typer.Option(help="Write the journal here, for `live replay`.", rich_help_panel=PANEL)]
StatusJson = Annotated[
    Path | None, typer.Option(help="Write one JSON line of figures a second.", rich_help_panel=PANEL)
]
