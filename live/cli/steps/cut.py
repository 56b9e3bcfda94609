"""Command `live steps cut`: finds the steps of whole recordings, shows them, and adds those that are accepted."""

from pathlib import Path
from typing import Annotated, Any, Final

import typer

from live.cli.steps.recording_options import (
    Anchor,
    BeatsPerMeasure,
    Bpm,
    Click,
    Count,
    DropFrames,
    FrameRate,
    Repair,
    Song,
    Unit,
    UpAxis,
)

PANEL_STEPS: Final = "What is a step"


def cut(
    files: Annotated[
        list[Path], typer.Argument(help="Recordings; what is alike in several of them is one step.", metavar="FILE...")
    ],
    accept: Annotated[
        str | None,
        typer.Option(help='Add these steps: "all", "repeated" (danced twice or more), or numbers.', metavar="1,3-5"),
    ] = None,
    sheet: Annotated[
        Path | None, typer.Option(help="Write a page with the key poses of every step.", metavar="OUT.html")
    ] = None,
    rename: Annotated[
        list[str] | None, typer.Option(help="Another name for a step; may be repeated.", metavar="NUMBER=NAME")
    ] = None,
    takes: Annotated[int, typer.Option(min=1, max=1000, help="Most occurrences of a step that are added.")] = 8,
    library: Annotated[
        Path | None,
        typer.Option("--library", help="A folder of steps. Default: yours.", metavar="DIR", file_okay=False),
    ] = None,
    alike: Annotated[
        float,
        typer.Option(
            help="Distance of the poses of measures that are alike.", metavar="METRES", rich_help_panel=PANEL_STEPS
        ),
    ] = 0.11,
    longest: Annotated[
        int, typer.Option(min=1, max=16, help="Most measures of a step.", rich_help_panel=PANEL_STEPS)
    ] = 4,
    mirror: Annotated[
        bool,
        typer.Option("--mirror", help="Also add mirror images as variations.", rich_help_panel=PANEL_STEPS),
    ] = False,
    author: Annotated[str | None, typer.Option(help="Name of the dancer.", rich_help_panel=PANEL_STEPS)] = None,
    style: Annotated[str | None, typer.Option(help="Dance style.", rich_help_panel=PANEL_STEPS)] = None,
    bpm: Bpm = None,
    anchor: Anchor = None,
    click: Click = None,
    count: Count = None,
    song: Song = None,
    beats_per_measure: BeatsPerMeasure = None,
    fps: FrameRate = None,
    unit: Unit = None,
    up: UpAxis = None,
    drop_frames: DropFrames = None,
    repair: Repair = False,
    json_out: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Cut whole recordings into steps by themselves.

    Measures are found from the beats. Measures that are alike, and measures that always follow each other, are one
    step. Every step gets a name that says what it does. Without --accept nothing is written but the sheet.
    """
    from live.app.offline.step_adding import ClapReference
    from live.app.option_values import check_range, check_writable
    from live.cli.steps.cut_run import CutRequest, cut_recordings

    check_range(alike, "--alike", 0.01, 1.0)
    check_writable(sheet, "--sheet")
    given: dict[str, Any] = {
        "fps": fps, "unit_m": unit, "up": up, "drop_frames": drop_frames, "repair": repair or None, "bpm": bpm,
        "first_beat_s": anchor, "beats_per_measure": beats_per_measure, "author": author, "style": style,
        "mirror": mirror or None,
    }  # fmt: skip
    cut_recordings(
        CutRequest(
            files=tuple(files), fields={key: value for key, value in given.items() if value is not None},
            reference=ClapReference(click=click, count=count, song=song), accept=accept, sheet=sheet,
            rename=tuple(rename or ()), takes=takes, library=library, alike=alike, longest=longest, json=json_out,
        )
    )  # fmt: skip
