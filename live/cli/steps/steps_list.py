"""`live steps list`: the steps of a library as a table or JSON."""

import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from live.cli.steps.steps_library import NamedStep, named_steps


def row_of(step: NamedStep) -> dict[str, Any]:
    """A step as JSON: what all its variations say together."""
    first = step.clips[0]
    distances = [round(clip.distance_m, 3) for clip in step.clips]
    return {
        "name": step.name,
        "variations": len(step.clips),
        "measures": sorted({clip.measures for clip in step.clips}),
        "beats_per_measure": first.beats_per_measure,
        "beats": sorted({clip.beats for clip in step.clips}),
        "bpm": sorted({round(clip.bpm, 3) for clip in step.clips}),
        "directions": step.ways,
        "distance_m": [min(distances), max(distances)],
        "leading_foot": step.told("leading_foot"),
        "begin_pose": step.told("begin_pose"),
        "end_pose": step.told("end_pose"),
        "weight_transfer": any(clip.weight_transfer for clip in step.clips),
        "author": step.told("author"),
        "style": step.told("style"),
        "tags": step.tags,
        "folder": str(step.folder),
    }


def print_list(library: Path | None, as_json: bool) -> None:
    """Print all steps; PersonError if the library cannot be read."""
    rows = [row_of(step) for step in named_steps(library)]
    if as_json:
        print(json.dumps(rows, ensure_ascii=False, indent=1))
        return
    console = Console(highlight=False)
    table = Table(box=None, pad_edge=False, header_style="bold")
    columns = ("step", "variations", "beats", "bpm", "ways", "foot", "poses", "style, tags")
    cells = [_cells(row) for row in rows]
    told = [at for at in range(len(columns)) if any(row[at] for row in cells)]
    for at in told:
        table.add_column(columns[at], overflow="fold", no_wrap=columns[at] in ("variations", "beats", "bpm"))
    for row in cells:
        table.add_row(*(row[at] for at in told))
    console.print(table)


def _cells(row: dict[str, Any]) -> list[str]:
    low, high = row["distance_m"]
    distance = f"{high:.2f} m" if high - low < 0.005 else f"{low:.2f}–{high:.2f} m"
    ways = ", ".join(row["directions"]) if len(row["directions"]) <= 2 else f"{len(row['directions'])} directions"
    poses = " → ".join(filter(None, ("/".join(row["begin_pose"]), "/".join(row["end_pose"]))))
    foot = "/".join(row["leading_foot"]) + (" ⇄" if row["weight_transfer"] else "")
    cells = [
        row["name"],
        str(row["variations"]),
        f"{_span(row['beats'])} ({row['beats_per_measure']})",
        _span(row["bpm"]),
        ways if high < 0.005 else f"{ways}, {distance}",
        foot.strip(),
        poses,
        ", ".join([*row["style"], *row["tags"]]),
    ]
    return [escape(cell) for cell in cells]


def _span(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g}–{values[-1]:g}"
