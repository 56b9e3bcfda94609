"""Options of `live play` for its picture: where it is shown, and how it is drawn."""

from pathlib import Path
from typing import Annotated

import typer

PANEL = "Picture"

Monitor = Annotated[
    str | None,
    typer.Option(
        help='Monitor by number, name or place ("right of primary").',
        metavar="N|NAME",
        rich_help_panel=PANEL,
    ),
]
Fullscreen = Annotated[bool, typer.Option("--fullscreen", help="Full screen.", rich_help_panel=PANEL)]
Operator = Annotated[
    str | None,
    typer.Option(
        help="A window of the operator's own on this monitor: the picture with overlay and guides, which "
        "no projector shows then.",
        metavar="N|NAME",
        rich_help_panel=PANEL,
    ),
]
Headless = Annotated[
    bool,
    typer.Option(
        "--headless",
        help="No window: run in real time without a picture, or --record or --share it.",
        rich_help_panel=PANEL,
    ),
]
Size = Annotated[str, typer.Option(help="Size of the window or film.", metavar="WxH", rich_help_panel=PANEL)]
Fps = Annotated[
    float | None,
    typer.Option(help="Default: the monitor's; 30 without a graphics card.", rich_help_panel=PANEL),
]
Shaders = Annotated[
    Path | None,
    typer.Option(
        help="For who works on looks: draw with the shaders of this folder, and anew whenever one is edited. "
        "A folder that is not there is made, with copies of the program's own.",
        file_okay=False,
        metavar="FOLDER",
        rich_help_panel=PANEL,
    ),
]
Quality = Annotated[
    int | None,
    typer.Option(
        help="Hold a step of quality, 0 is the best. Default: as the machine can afford.",
        rich_help_panel=PANEL,
    ),
]
