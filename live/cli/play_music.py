"""Options of `live play` for music and time: what the show hears, and which clock it follows."""

from pathlib import Path
from typing import Annotated

import typer

PANEL = "Music and time"

Audio = Annotated[
    str | None,
    typer.Option(
        help="An input device to listen to (see `live devices`), or a music file.",
        metavar="DEVICE|FILE",
        rich_help_panel=PANEL,
    ),
]
AudioChannel = Annotated[
    str | None,
    typer.Option(
        help="Which channels of the input: 3, or 5,6, or all. Default: the first two.",
        metavar="N[,N]|all",
        rich_help_panel=PANEL,
    ),
]
Venue = Annotated[
    str | None,
    typer.Option(
        help="The hall: its devices and delays (see `live calibrate`).",
        metavar="NAME",
        rich_help_panel=PANEL,
    ),
]
Bpm = Annotated[
    float | None,
    typer.Option(help="The tempo to begin with; without --audio the internal clock keeps it.", rich_help_panel=PANEL),
]
Link = Annotated[
    str | None,
    typer.Option(
        help="Ableton Link: follow others' tempo and beat, or lead them with the show's. Default: the patch's.",
        metavar="follow|lead|off",
        rich_help_panel=PANEL,
    ),
]
Midi = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port to listen to (see `live devices`): clock, time code, pedals and keys; tcp:HOST:PORT, "
        "rtp:HOST:PORT, raw:PATH; or off.",
        metavar="NAME",
        rich_help_panel=PANEL,
    ),
]
MidiFile = Annotated[
    Path | None,
    typer.Option(
        help="A MIDI file: its tempo map leads the beat, its notes move the dance and work what the map says.",
        metavar="FILE.mid",
        rich_help_panel=PANEL,
    ),
]
MidiOut = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port that is told present values, for lights of pads and motor faders; or off.",
        metavar="NAME",
        rich_help_panel=PANEL,
    ),
]
MidiClockOut = Annotated[
    str | None,
    typer.Option(
        help="A MIDI port that the show's beat is sent to as MIDI clock; or off.",
        metavar="NAME",
        rich_help_panel=PANEL,
    ),
]
Click = Annotated[
    str | None,
    typer.Option(
        help="An output on which the players hear a click (see `live devices`).",
        metavar="DEVICE",
        rich_help_panel=PANEL,
    ),
]
ClickChannels = Annotated[
    str | None,
    typer.Option(help="Which channels of it, from 1: 3, or 5,6.", metavar="N", rich_help_panel=PANEL),
]
Seconds = Annotated[float | None, typer.Option(help="End after so many seconds.", rich_help_panel=PANEL)]
Measures = Annotated[
    str | None,
    typer.Option(
        help="Practise these measures of the score, again and again, without the patch's music.",
        metavar="17-24",
        rich_help_panel=PANEL,
    ),
]
TempoShare = Annotated[
    float | None,
    typer.Option(help="Practise at this share of the tempo: 0.8 is slower.", metavar="0.1-2", rich_help_panel=PANEL),
]
