"""Report of `live steps graph`: a library's motion graph as text, JSON, DOT or SVG.

With `--bridges` it also finds stretches of the recordings that join steps without edges (T141).
"""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from live.app.offline.step_listing import NamedStep, library_folders, named_steps, threshold_for
from live.app.pictures.graph_svg import Arrow, State, state_machine
from live.base.errors import PersonError
from live.graph.build.bridges import PosedRecording, find_bridges
from live.graph.clusters import (
    Component,
    Connectivity,
    JoinSummary,
    connectivity,
    join_summaries,
    nearest_steps,
    structural_components,
)
from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.step_library import build_library
from live.library.recording_file import read_step_files
from live.library.recordings import RecordingReader
from live.library.whole_file import write_atomically
from live.motion.clip import Clip

MAX_BRIDGE_PAIRS = 24
"""Maximum pairs of steps to find bridges for, nearest first: half a second each for half an hour of motion."""


def read_recordings_of(library: Path | None) -> list[Clip]:
    """Return every recording of the library's folders once, in full; raise PersonError if there is none."""
    found: dict[int, Clip] = {}
    for folder in library_folders(library):
        reader = RecordingReader()
        for entries in read_step_files(folder).recordings.values():
            for entry in entries:
                clip = reader.clip(entry)
                found.setdefault(id(clip), clip)
    if not found:
        raise PersonError("--bridges: there are no recordings to search", "sketched steps have nothing around them")
    return list(found.values())


def find_missing_bridges(
    graph: MotionGraph, missing: Sequence[dict[str, Any]], recordings: Sequence[Clip]
) -> list[dict[str, Any]]:
    """Return a row with the best stretch of a recording for each of the nearest pairs of unjoined steps."""
    recorded, library = [PosedRecording.of(clip) for clip in recordings], graph.library
    rows = []
    for row in missing[:MAX_BRIDGE_PAIRS]:
        source, target = library.steps.index(row["from"]), library.steps.index(row["to"])
        bpm = next(clip.bpm for clip in library.clips if clip.step == row["from"])
        measure_s = 60.0 / bpm * library.beats_per_measure
        for bridge in find_bridges(graph, recorded, source, target, measure_s=measure_s, max_count=1):
            rows.append(
                {
                    "from": row["from"],
                    "to": row["to"],
                    "recording": recordings[bridge.recording].name,
                    "start_s": round(bridge.start, 3),
                    "stop_s": round(bridge.stop, 3),
                    "begin_m": round(bridge.begin_cost, 4),
                    "end_m": round(bridge.end_cost, 4),
                    "joins": bridge.cost <= graph.rule.threshold,
                }
            )
    return rows


@dataclass(frozen=True, slots=True, eq=False)
class GraphReport:
    """Analysis of a motion graph."""

    graph: MotionGraph
    components: list[Component]
    steps: list[JoinSummary]
    """Joins from step to step."""
    parts: list[JoinSummary]
    """Joins from component to component."""
    connectivity: Connectivity
    missing: list[dict[str, Any]]
    other_metres: dict[int, int]
    """Number of clips of other metres, by beats per measure."""


def analyse_graph(graph: MotionGraph, left_out: dict[int, int] | None = None) -> GraphReport:
    """Analyse an unpruned graph."""
    library, components = graph.library, structural_components(graph.library)
    part = np.zeros(library.node_count, np.int32)
    for number, component in enumerate(components):
        part[list(component.nodes)] = number
    between = join_summaries(graph, library.node_step, len(library.steps))
    return GraphReport(
        graph=graph,
        components=components,
        steps=between,
        parts=join_summaries(graph, part, len(components)),
        connectivity=connectivity(graph),
        missing=_missing(graph, between),
        other_metres=left_out or {},
    )


def _missing(graph: MotionGraph, between: list[JoinSummary]) -> list[dict[str, Any]]:
    """Return the pairs of unjoined steps, nearest first, and recordings that would join them (T003, T043)."""
    steps, there = graph.library.steps, {(one.source, one.target) for one in between}
    nearest = nearest_steps(graph)
    rows: list[dict[str, Any]] = []
    for a, b in sorted(np.ndindex(nearest.shape), key=lambda pair: nearest[pair]):
        if (a, b) in there:
            continue
        distance = float(nearest[a, b])
        if np.isfinite(distance):
            needs = (
                f"their nearest poses are {distance:.2f} m apart: record a {steps[b]} that begins as {steps[a]} ends, "
                f"or raise the threshold"
            )
        elif a == b:
            needs = f"it is repeated on the other side: record {steps[a]} on the other foot, or mirror it"
        else:
            needs = f"{steps[a]} never ends in a pose in which {steps[b]} begins: record one that does"
        row = {"from": steps[a], "to": steps[b], "nearest_m": round(distance, 4) if np.isfinite(distance) else None}
        rows.append({**row, "needs": needs})
    return rows


def json_of(report: GraphReport) -> dict[str, Any]:
    """Return the graph as JSON; nodes, components and strong components are numbered from 0."""
    graph, library, whole = report.graph, report.graph.library, report.connectivity
    joins = graph.joins
    part = {node: number for number, one in enumerate(report.components) for node in one.nodes}
    groups = [np.flatnonzero(whole.label == label).tolist() for label in np.unique(whole.label)]
    return {
        "threshold_m": graph.rule.threshold,
        "window": graph.window,
        "beats_per_measure": library.beats_per_measure,
        "other_metres": {str(beats): count for beats, count in report.other_metres.items()},
        "clusters": [
            {
                "step": name,
                "clips": len({int(c) for c in library.node_clip[library.node_step == step]}),
                "nodes": np.flatnonzero(library.node_step == step).tolist(),
                "alive": bool(whole.alive[library.node_step == step].any()),
            }
            for step, name in enumerate(library.steps)
        ],
        "components": [
            {
                "step": library.steps[one.step],
                "side": one.side,
                "begin_pose": one.begin_pose or None,
                "end_pose": one.end_pose or None,
                "nodes": list(one.nodes),
            }
            for one in report.components
        ],
        "nodes": [
            {
                "node": node,
                "step": library.steps[library.node_step[node]],
                "words": library.describe(node),
                "clip": library.clips[library.node_clip[node]].clip.name,
                "measure": int(library.node_measure[node]) + 1,
                "measures": int(library.node_measures[node]),
                "component": part[node],
                "alive": bool(whole.alive[node]),
                "travel_m": [round(float(way), 4) for way in library.node_travel[node]],
            }
            for node in range(library.node_count)
        ],
        "edges": [
            {"from": a, "to": b, "cost_m": round(cost, 5)}
            for a, b, cost in zip(joins.source.tolist(), joins.target.tolist(), joins.cost.tolist(), strict=True)
        ],
        "leads": [
            {
                "from": library.steps[one.source],
                "to": library.steps[one.target],
                "edges": one.join_count,
                "nearest_m": round(one.nearest, 5),
            }
            for one in report.steps
        ],
        "strong_components": sorted(groups, key=len, reverse=True),
        "dead_ends": dead_ends(report),
        "missing": report.missing,
    }


def dead_ends(report: GraphReport) -> list[dict[str, Any]]:
    """Return nodes that are not part of any cycle, with the reason."""
    whole, library = report.connectivity, report.graph.library
    rows = []
    for node in np.flatnonzero(~whole.alive).tolist():
        on, reached = whole.has_successor[node], whole.has_predecessor[node]
        why = "no way back" if on and reached else "nothing leads to it" if on else "it leads nowhere"
        if not on and not reached:
            why = "it has no transitions in or out"
        rows.append({"node": node, "words": library.describe(node), "why": why})
    return rows


def dot_of(report: GraphReport) -> str:
    """Return the component graph (T062) for Graphviz: a cluster per step, a node per structural variation."""
    library = report.graph.library
    lines = ["digraph steps {", "  compound=true; node [shape=box, style=rounded];"]
    for step, name in enumerate(library.steps):
        lines.append(f"  subgraph cluster_{step} {{ label={_quoted(name)};")
        for number, one in enumerate(report.components):
            if one.step == step:
                words = [
                    one.side,
                    " → ".join(filter(None, (one.begin_pose, one.end_pose))),
                    "1 measure" if len(one.nodes) == 1 else f"{len(one.nodes)} measures",
                ]
                lines.append(f"    c{number} [label={_quoted(chr(10).join(filter(None, words)))}];")
        lines.append("  }")
    lines += [
        f'  c{one.source} -> c{one.target} [label="{one.join_count}", tooltip="{100 * one.nearest:.1f} cm"];'
        for one in report.parts
    ]
    return "\n".join([*lines, "}", ""])


def _quoted(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{plain}"'


def svg_of(report: GraphReport) -> str:
    """Return the state machine of the steps as SVG (Fig 5.11)."""
    library = report.graph.library
    states = []
    for step, name in enumerate(library.steps):
        own = library.node_step == step
        lengths = sorted({int(n) for n in library.node_measures[own]})
        many = "1 measure" if lengths == [1] else f"{'/'.join(map(str, lengths))} measures"
        clips = len(np.unique(library.node_clip[own]))
        states.append(State(name, many, clips, bool(report.connectivity.alive[own].any())))
    arrows = [Arrow(one.source, one.target, one.join_count) for one in report.steps]
    threshold = report.graph.rule.threshold
    counted = f"{len(states)} steps, {len(library.clips)} clips, {len(report.graph.joins.source)} edges"
    return state_machine(states, arrows, f"{counted} within {threshold:g} m")


WINDOW_BEATS = 0.75
MAX_ROWS = 12
"""Maximum number of missing edges printed; JSON has all of them."""


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
    """Print the graph of a library, or write its picture; raise PersonError if the library cannot be read."""
    report = _report(named_steps(library), threshold, window)
    found: list[dict[str, Any]] | None = None
    if bridges:
        found = find_missing_bridges(report.graph, report.missing, read_recordings_of(library))
    if svg is not None:
        write_atomically(svg_of(report).encode(), svg, "--svg")
    if as_json:
        data = json_of(report) if found is None else json_of(report) | {"bridges": found}
        print(json.dumps(data, ensure_ascii=False, indent=1))
    elif as_dot:
        print(dot_of(report), end="")
    else:
        _print(report, svg)
        _print_bridges(found or [])


def _report(steps: Sequence[NamedStep], threshold: float | None, window: float | None) -> GraphReport:
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
    return analyse_graph(graph, {metre: count for metre, count in metres.items() if metre != beats})


def _print(report: GraphReport, svg: Path | None) -> None:
    console = Console(highlight=False)

    def say(text: str = "", style: str = "") -> None:
        console.print(text, style=style, soft_wrap=True, markup=False)

    graph, library, whole = report.graph, report.graph.library, report.connectivity
    say(
        f"{len(library.steps)} steps, {len(report.components)} structural variations, {library.node_count} measures, "
        f"{len(graph.joins.source)} edges within {graph.rule.threshold:g} m; "
        f"{int(whole.alive.sum())} measures can be danced for ever"
    )
    for metre, count in report.other_metres.items():
        say(f"left out: {count} clips of {metre} beats a measure; this graph has {library.beats_per_measure}", "yellow")
    for step, name in enumerate(library.steps):
        ways = [one for one in report.steps if one.source == step]
        dead = "" if whole.alive[library.node_step == step].any() else "  (no part of an endless dance)"
        say(f"\n{name}{dead}", "bold" if not dead else "yellow")
        for one in sorted(ways, key=lambda lead: lead.nearest):
            say(f"    → {library.steps[one.target]:<24} {one.join_count:>5} edges, nearest {100 * one.nearest:5.1f} cm")
        if not ways:
            say("    → nothing", "yellow")
    if report.missing:
        say(f"\n{len(report.missing)} pairs of steps are not joined", "bold")
        for row in report.missing[:MAX_ROWS]:
            say(f"    {row['from']} → {row['to']}: {row['needs']}")
        if len(report.missing) > MAX_ROWS:
            say(f"    and {len(report.missing) - MAX_ROWS} more (--json has them all)")
    ends = dead_ends(report)
    for end in ends[:MAX_ROWS]:
        say(f"dead end: {end['words']} (node {end['node']}): {end['why']}", "yellow")
    if len(ends) > MAX_ROWS:
        say(f"and {len(ends) - MAX_ROWS} more dead ends (--json has them all)", "yellow")
    if svg is not None:
        say(f"\npicture written: {svg}", "green")


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
