"""`live steps graph`: the motion graph of a library: what leads where, what does not, as text, JSON, DOT or SVG."""

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from live.app.whole_file import write_whole
from live.base.errors import PersonError
from live.cli.steps.graph_report import Report, dead_ends, dot_of, json_of, report_of, svg_of
from live.cli.steps.steps_library import NamedStep, named_steps, threshold_for
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library

WINDOW_BEATS = 0.75
SHOWN = 12
"""Missing edges that are told; JSON has them all."""


def print_graph(
    library: Path | None,
    *,
    as_json: bool,
    as_dot: bool,
    svg: Path | None,
    threshold: float | None,
    window: float | None,
    bridges: bool = False,
) -> None:
    """Print the graph of a library, or write its picture; PersonError if the library cannot be read."""
    report = _report(named_steps(library), threshold, window)
    found: list[dict[str, Any]] | None = None
    if bridges:
        from live.cli.steps.steps_bridges import find_missing_bridges, read_recordings_of

        found = find_missing_bridges(report.graph, report.missing, read_recordings_of(library))
    if svg is not None:
        write_whole(svg_of(report).encode(), svg, "--svg")
    if as_json:
        data = json_of(report) if found is None else json_of(report) | {"bridges": found}
        print(json.dumps(data, ensure_ascii=False, indent=1))
    elif as_dot:
        print(dot_of(report), end="")
    else:
        _print(report, svg)
        _print_bridges(found or [])


def _report(steps: Sequence[NamedStep], threshold: float | None, window: float | None) -> Report:
    clips = [clip for step in steps for clip in step.clips]
    metres = Counter(clip.beats_per_measure for clip in clips)
    beats = max(metres, key=lambda metre: metres[metre])
    fitting = [clip for clip in clips if clip.beats_per_measure == beats]
    threshold = threshold_for(steps) if threshold is None else threshold
    share = min(1.0, WINDOW_BEATS / beats) if window is None else window
    try:
        graph = build_graph(build_library(fitting), window=share, threshold=threshold, prune=False)
    except ValueError as error:
        raise PersonError(str(error)) from None
    return report_of(graph, {metre: count for metre, count in metres.items() if metre != beats})


def _print(report: Report, svg: Path | None) -> None:
    console = Console(highlight=False)

    def say(text: str = "", style: str = "") -> None:
        console.print(text, style=style, soft_wrap=True, markup=False)

    graph, library, whole = report.graph, report.graph.library, report.whole
    say(
        f"{len(library.steps)} steps, {len(report.components)} structural variations, {library.node_count} measures, "
        f"{len(graph.joins.source)} edges within {graph.rule.threshold:g} m; "
        f"{int(whole.alive.sum())} measures can be danced for ever"
    )
    for metre, count in report.left_out.items():
        say(f"left out: {count} clips of {metre} beats a measure; this graph has {library.beats_per_measure}", "yellow")
    for step, name in enumerate(library.steps):
        ways = [one for one in report.steps if one.source == step]
        dead = "" if whole.alive[library.node_step == step].any() else "  (no part of an endless dance)"
        say(f"\n{name}{dead}", "bold" if not dead else "yellow")
        for one in sorted(ways, key=lambda lead: lead.nearest):
            say(f"    → {library.steps[one.target]:<24} {one.joins:>5} edges, nearest {100 * one.nearest:5.1f} cm")
        if not ways:
            say("    → nothing", "yellow")
    if report.missing:
        say(f"\n{len(report.missing)} pairs of steps are not joined", "bold")
        for row in report.missing[:SHOWN]:
            say(f"    {row['from']} → {row['to']}: {row['needs']}")
        if len(report.missing) > SHOWN:
            say(f"    and {len(report.missing) - SHOWN} more (--json has them all)")
    ends = dead_ends(report)
    for end in ends[:SHOWN]:
        say(f"dead end: {end['words']} (node {end['node']}): {end['why']}", "yellow")
    if len(ends) > SHOWN:
        say(f"and {len(ends) - SHOWN} more dead ends (--json has them all)", "yellow")
    if svg is not None:
        say(f"\nthe picture is in {svg}", "green")


def _print_bridges(bridges: list[dict[str, Any]]) -> None:
    console = Console(highlight=False)
    for row in bridges:
        worse = 100 * max(row["begin_m"], row["end_m"])
        words = "" if row["joins"] else ", more than the threshold"
        console.print(
            f"bridge {row['from']} → {row['to']}: {row['recording']} from {row['start_s']:.2f} s to "
            f"{row['stop_s']:.2f} s (the worse join {worse:.1f} cm{words})",
            style="green" if row["joins"] else "",
            soft_wrap=True,
            markup=False,
        )
