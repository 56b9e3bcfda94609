"""`live dance`: a sequence of steps, danced exactly on the measures, as a motion file with its report."""

from pathlib import Path
from typing import Annotated

import typer

PANEL_STAGE = "Where it is danced"
PANEL_JOINS = "What may follow what"


def dance(
    library: Annotated[
        str, typer.Argument(help='A folder of steps, or "sketches" for the project\'s own.', metavar="LIBRARY")
    ],
    sequence: Annotated[
        str,
        typer.Option(
            help='Steps with commas between: "couru left, échappé x2, *"; * is a measure of anything. '
            "@FILE reads them from a file.",
            metavar="STEPS",
        ),
    ],
    bpm: Annotated[float | None, typer.Option(help="Tempo. Default: that of the first step.")] = None,
    out: Annotated[Path | None, typer.Option(help="Write the motion.", metavar="OUT.bvh|OUT.glb|OUT.vrma")] = None,
    report: Annotated[Path | None, typer.Option(help="Write the figures of the motion.", metavar="FILE.json")] = None,
    path: Annotated[
        str | None,
        typer.Option(
            help="Points of the way over the stage in metres, the first is where she begins.",
            metavar="X,Z,X,Z,...",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = None,
    heading: Annotated[
        str | None,
        typer.Option(
            help="Where she faces: degrees (0: the audience, 90: to its right), two numbers for begin and end of a "
            "path, or 'path' to face along it. Default: 0.",
            metavar="DEGREES|path",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = None,
    correction: Annotated[
        float,
        typer.Option(
            help="On a path: hips may be moved by so much each measure beyond what the steps do.",
            metavar="METRES",
            rich_help_panel=PANEL_STAGE,
        ),
    ] = 0.1,
    start: Annotated[
        str | None,
        typer.Option(help="The step she comes from.", metavar="STEP", rich_help_panel=PANEL_JOINS),
    ] = None,
    window: Annotated[
        float | None,
        typer.Option(help="Length of a transition. Default: 0.75.", metavar="BEATS", rich_help_panel=PANEL_JOINS),
    ] = None,
    threshold: Annotated[
        float | None,
        typer.Option(
            help="How far apart poses may be. Default: 0.16 for sketches, 0.35 for recordings.",
            metavar="METRES",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = None,
    foot_rule: Annotated[
        bool,
        typer.Option(
            "--foot-rule",
            help="Steps that travel left must lead with the right foot, and the other way round.",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = False,
    depth_first: Annotated[
        bool,
        typer.Option(
            "--depth-first",
            help="Search as the thesis does: the first dance without a wrong measure, not the smoothest.",
            rich_help_panel=PANEL_JOINS,
        ),
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Write over files that are there.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the dance and what is missing as JSON.")] = False,
) -> None:
    """Dance a sequence of steps. Where it cannot be danced as it is, the nearest dance, and what is missing for it."""
    from live.app.offline.dance_plan import Asked, make_plan, put_together
    from live.app.offline.dance_report import check_targets, print_dance, write_motion, write_report
    from live.app.option_values import parse_number
    from live.base.errors import PersonError

    parse_number(bpm, "--bpm", 20, 400)
    parse_number(threshold, "--threshold", 0.001, 10)
    parse_number(window, "--window", 0.05, 16)
    parse_number(correction, "--correction", 0, 2)
    check_targets(out, report, force=force)
    if path is not None and start is not None:
        raise PersonError("--start: a path begins at its first point, with any step", "leave --start or --path out")
    asked = Asked(
        library=library, sequence=sequence, bpm=bpm, path=path, heading=heading, correction=correction, start=start,
        window=window, threshold=threshold, foot_rule=foot_rule, depth_first=depth_first,
    )  # fmt: skip
    plan = make_plan(asked)
    if out is not None or report is not None:
        dance = put_together(plan)
        if out is not None:
            write_motion(dance.clip, out)
        if report is not None:
            write_report(plan, dance, report)
    print_dance(plan, as_json=as_json)
