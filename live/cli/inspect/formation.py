"""Command `live formation`: draws a formation from above, and the dancers' paths into it."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    pass


def formation(
    spec: Annotated[
        str,
        typer.Argument(
            help="circle, line, star:6, 'circle poisson', text:LIVE, svg:FILE.svg, or a TOML or JSON file "
            "(FILE.toml:NAME takes one of several).",
            metavar="SPEC",
        ),
    ],
    svg: Annotated[
        Path | None, typer.Option(help="Draw it from above, with the audience below.", metavar="OUT.svg")
    ] = None,
    dancers: Annotated[int | None, typer.Option(help="Number of dancers. Default: as in SPEC, or 24.")] = None,
    from_: Annotated[
        str | None, typer.Option("--from", help="Also draw the paths from this formation.", metavar="SPEC2")
    ] = None,
    stage: Annotated[str, typer.Option(help="Width and depth of the stage in metres.", metavar="WxD")] = "12x8",
    seed: Annotated[int, typer.Option(help="Random seed.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print slots, distances and warnings as JSON.")] = False,
) -> None:
    """Draw a formation and the dancers' paths into it, and report whether it fits the stage.

    Paths are straight, with slots assigned for the least sum of squared distances: dancers who start together never
    collide if all slots are more than 0.71 m apart.
    """
    from rich.console import Console

    from live.agents.evolutions.slot_assignment import assign
    from live.agents.formations.formation import formation_of
    from live.agents.formations.stage_fit import fit_stage
    from live.app.offline.formation_report import (
        default_count,
        describe,
        read_spec,
        report_json,
        write_svg,
    )
    from live.app.option_values import check_range, parse_stage
    from live.base.errors import PersonError

    check_range(dancers, "--dancers", 0, 10_000)
    if not 0 <= seed < 2**31:
        raise PersonError(f"--seed {seed}: 0 to {2**31 - 1} expected")
    floor = parse_stage(stage)
    wished = read_spec(spec)
    count = dancers if dancers is not None else default_count(wished)
    made = formation_of(wished, count, seed)
    before = None if from_ is None else formation_of(read_spec(from_), count, seed)
    slot = None if before is None else assign(before.slots, made.slots)
    fit = fit_stage(made, *floor)
    if svg is not None:
        write_svg(svg, made, floor, fit, before, slot, spec)
    if as_json:
        print(json.dumps(report_json(made, fit, floor, before, slot)))
        return
    console = Console(highlight=False)
    for line in describe(made, fit, floor, svg):
        console.print(line, soft_wrap=True, markup=False)
