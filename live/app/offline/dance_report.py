"""Output of `live dance`: motion file, report, and the dance as table or JSON."""

import json
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from live.app.offline.dance_plan import DancePlan
from live.app.option_values import check_writable
from live.base.errors import PersonError
from live.graph.dance_metrics import DanceMetrics
from live.graph.render_dance import RenderedDance
from live.library.motion_formats import check_written_name, encode_motion
from live.library.whole_file import write_atomically
from live.motion.clip import Clip

MAX_ROWS: Final = 200
"""Maximum number of measures in the table; JSON has all of them."""


def check_targets(out: Path | None, report: Path | None, *, force: bool) -> None:
    """Raise PersonError for files that cannot or must not be written."""
    if out is not None:
        check_written_name(out, "--out", ".bvh")
    if report is not None and report.suffix.lower() != ".json":
        raise PersonError(f"--report {report}: a name that ends in .json expected", f"--report {report.stem}.json")
    for file, option in ((out, "--out"), (report, "--report")):
        check_writable(file, option)
        if file is not None and file.exists() and not force:
            raise PersonError(
                f"{option} {file}: the file exists already", "give another name, or --force to overwrite it"
            )


def write_motion(clip: Clip, out: Path) -> None:
    """Write the dance in the format that the file's suffix names."""
    write_atomically(encode_motion(clip, out), out, "--out")


def write_report(plan: DancePlan, dance: RenderedDance, report: Path) -> None:
    """Write the metrics of the dance, with keys as in the contracts."""
    values = DanceMetrics(plan.graph, dance, plan.targets).result()
    values |= {"steps": step_rows(plan), "missing": [one.row() for one in plan.missing]}
    write_atomically((json.dumps(values, ensure_ascii=False, indent=1) + "\n").encode(), report, "--report")


def step_rows(plan: DancePlan) -> list[dict[str, Any]]:
    """Return a row per measure, numbered from 1; `weight`: the clip's share if another take is mixed in."""
    library, followed = plan.graph.library, plan.followed
    share = np.zeros(len(plan.node)) if followed is None else followed.share
    return [
        {
            "dancer": 1,
            "measure": measure + 1,
            "step": library.steps[library.node_step[node]],
            "clip": library.describe(node),
            "weight": round(1.0 - float(share[measure]), 3),
            "cost": round(float(plan.edge_cost[measure]), 4),
        }
        for measure, node in enumerate(plan.node.tolist())
    ]


def print_dance(plan: DancePlan, *, as_json: bool) -> None:
    """Print the dance on stdout; with the table, print missing transitions on stderr."""
    rows, wrong = step_rows(plan), plan.deviations
    if as_json:
        value = {
            "measures": len(rows),
            "bpm": plan.bpm,
            "cost": int(wrong.sum()),
            "roughness_m": round(float(plan.edge_cost.sum()), 4),
            "steps": rows,
            "missing": [one.row() for one in plan.missing],
        }
        print(json.dumps(value, ensure_ascii=False))
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("measure", "clip", "join"):
        table.add_column(column, overflow="fold", justify="left" if column == "clip" else "right")
    for row, off in zip(rows[:MAX_ROWS], wrong, strict=False):
        clip = escape(row["clip"]) + (" [yellow](differs)[/]" if off else "")
        table.add_row(str(row["measure"]), clip, f"{100.0 * row['cost']:.1f} cm")
    console = Console(highlight=False)
    console.print(table)
    if len(rows) > MAX_ROWS:
        console.print(f"... {len(rows)} measures in all; --json holds them")
    told = Console(stderr=True, highlight=False, soft_wrap=True)
    if wrong.any():
        told.print(
            f"{wrong.sum()} of {len(rows)} measures {'is' if wrong.sum() == 1 else 'are'} different: "
            "this is the nearest dance",
            style="yellow",
        )
    for words in plan.off_tempo:
        told.print(words, style="yellow", markup=False)
    for one in plan.missing:
        where = "" if one.source is None else f" after {one.source}"
        told.print(f"missing in measure {one.measure}{where}: {one.needs}", markup=False)
