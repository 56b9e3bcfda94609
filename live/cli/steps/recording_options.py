"""Options of the commands that read recordings into the step library: how a file is read, and its music."""

from pathlib import Path
from typing import Annotated, Final, Literal

import typer

PANEL_FILE: Final = "Reading files"
PANEL_MUSIC: Final = "Music"

Bpm = Annotated[float | None, typer.Option(help="Tempo of the recorded dance.", rich_help_panel=PANEL_MUSIC)]
Anchor = Annotated[
    float | None,
    typer.Option(help="Start of measure 1. Default: detected.", metavar="SECONDS", rich_help_panel=PANEL_MUSIC),
]
Click = Annotated[
    float | None, typer.Option(help="Tempo of the click that the claps follow.", rich_help_panel=PANEL_MUSIC)
]
Count = Annotated[int | None, typer.Option(help="Number of clapped beats of the click.", rich_help_panel=PANEL_MUSIC)]
Song = Annotated[Path | None, typer.Option(help="Audio file that the claps follow.", rich_help_panel=PANEL_MUSIC)]
BeatsPerMeasure = Annotated[int | None, typer.Option(help="Default: 4.", rich_help_panel=PANEL_MUSIC)]

FrameRate = Annotated[
    float | None, typer.Option(help="True frame rate, if the header is wrong.", rich_help_panel=PANEL_FILE)
]
Unit = Annotated[float | None, typer.Option(help="Metres per unit, to check the size.", rich_help_panel=PANEL_FILE)]
UpAxis = Annotated[Literal["Y", "Z"] | None, typer.Option(help="The axis that points up.", rich_help_panel=PANEL_FILE)]
DropFrames = Annotated[int | None, typer.Option(help="Leading frames to leave out.", rich_help_panel=PANEL_FILE)]
Repair = Annotated[
    bool, typer.Option("--repair", help="Repair tracking errors where that is safe.", rich_help_panel=PANEL_FILE)
]
