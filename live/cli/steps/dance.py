"""Command `live dance`: writes a sequence of steps, aligned to measures, as a motion file with a report."""

from pathlib import Path
from typing import Annotated

import typer

PANEL_STAGE = "Place on the stage"
PANEL_JOINS = "Transitions"


def dance(
    library: Annotated[
        str, typer.Argument(help='A folder of steps, or "sketches" for the built-in ones.', metavar="LIBRARY")
    ],
    sequence: Annotated[
        str,
        typer.Option(
            help='Steps, separated by commas: "couru left, échappé x2, *"; * is a measure of any step. '
            "@FILE reads them from a file.",
            metavar="STEPS",
        ),
    ],
    bpm: Annotated[float | None, typer.Option(help="Tempo. Default: that of the first step.")] = None,
    out: Annotated[Path | None, typer.Option(help="Write the motion.", metavar="OUT.bvh|OUT.glb|OUT.vrma")] = None,
    report: Annotated[Path | None, typer.Option(help="Write motion figures.", metavar="FILE.json")] = None,
    path: Annotated[
        str | None,
        typer.Option(
            help="Points of the path over the stage in metres, from the dancer's start.",
            metavar="X,Z,X,Z,...",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = None,
    heading: Annotated[
        str | None,
        typer.Option(
            help="Facing in degrees (0: the audience, 90: to its right), two numbers for start and end of a path, "
            "or 'path' to face along it. Default: 0.",
            metavar="DEGREES|path",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = None,
    correction: Annotated[
        float,
        typer.Option(
            help="On a path: maximum correction of the hips per measure.",
            metavar="METRES",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = 0.1,
    start: Annotated[
        str | None,
        typer.Option(help="The preceding step.", metavar="STEP", rich_help_panel=PANEL_JOINS),
    ] = None,
    window: Annotated[
        float | None,
        typer.Option(help="Length of a transition. Default: 0.75.", metavar="BEATS", rich_help_panel=PANEL_JOINS),
    ] = None,
    threshold: Annotated[
        float | None,
        typer.Option(
            help="Maximum distance of joined poses. Default: 0.16 for sketches, 0.35 for recordings.",
            metavar="METRES",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = None,
    foot_rule: Annotated[
        bool,
        typer.Option(
            "--foot-rule",
            help="Steps that travel left must lead with the right foot, and vice versa.",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = False,
    depth_first: Annotated[
        bool,
        typer.Option(
            "--depth-first",
            help="Search as in the thesis: take the first dance that matches every measure, not the smoothest.",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the dance and missing transitions as JSON.")] = False,
) -> None:
    """Dance a sequence of steps. If it cannot be danced exactly, use the nearest dance and list missing transitions."""
    from live.app.offline.dance_plan import DanceOptions, assemble_plan, make_plan
    from live.app.offline.dance_report import check_targets, print_dance, write_motion, write_report
    from live.app.option_values import check_range
    from live.base.errors import PersonError

    check_range(bpm, "--bpm", 20, 400)
    check_range(threshold, "--threshold", 0.001, 10)
    check_range(window, "--window", 0.05, 16)
    check_range(correction, "--correction", 0, 2)
    check_targets(out, report, force=force)
    if path is not None and start is not None:
        raise PersonError("--start: a path begins at its first point, with any step", "leave --start or --path out")
    asked = DanceOptions(
        library=library, sequence=sequence, bpm=bpm, path=path, heading=heading, correction=correction, start=start,
        window=window, threshold=threshold, foot_rule=foot_rule, depth_first=depth_first,
    )  # fmt: skip
    plan = make_plan(asked)
    if out is not None or report is not None:
        dance = assemble_plan(plan)
        if out is not None:
            write_motion(dance.clip, out)
        if report is not None:
            write_report(plan, dance, report)
    print_dance(plan, as_json=as_json)
