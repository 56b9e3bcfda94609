"""What there is to say of a motion graph: as JSON, as Graphviz text, and as the picture of a state machine."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from live.cli.pictures.graph_svg import Arrow, State, state_machine
from live.graph.clusters import (
    Component,
    Connectivity,
    Lead,
    connectivity,
    leads,
    nearest_steps,
    structural_components,
)
from live.graph.motion_graph import MotionGraph


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """A graph and what there is to say of it."""

    graph: MotionGraph
    components: list[Component]
    steps: list[Lead]
    """From step to step."""
    parts: list[Lead]
    """From component to component."""
    whole: Connectivity
    missing: list[dict[str, Any]]
    left_out: dict[int, int]
    """Beats per measure of the clips of another metre → how many there are."""


def report_of(graph: MotionGraph, left_out: dict[int, int] | None = None) -> Report:
    """What there is to say of a graph from which nothing was pruned."""
    library, components = graph.library, structural_components(graph.library)
    part = np.zeros(library.node_count, np.int32)
    for number, component in enumerate(components):
        part[list(component.nodes)] = number
    between = leads(graph, library.node_step, len(library.steps))
    return Report(
        graph=graph,
        components=components,
        steps=between,
        parts=leads(graph, part, len(components)),
        whole=connectivity(graph),
        missing=_missing(graph, between),
        left_out=left_out or {},
    )


def _missing(graph: MotionGraph, between: list[Lead]) -> list[dict[str, Any]]:
    """The pairs of steps that nothing joins, the nearest first, and what would join them (T003, T043)."""
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


def json_of(report: Report) -> dict[str, Any]:
    """The graph as JSON; nodes, components and strong components are named by their number, from 0."""
    graph, library, whole = report.graph, report.graph.library, report.whole
    joins = graph.joins
    part = {node: number for number, one in enumerate(report.components) for node in one.nodes}
    groups = [np.flatnonzero(whole.label == label).tolist() for label in np.unique(whole.label)]
    return {
        "threshold_m": graph.rule.threshold,
        "window": graph.window,
        "beats_per_measure": library.beats_per_measure,
        "other_metres": {str(beats): count for beats, count in report.left_out.items()},
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
                "edges": one.joins,
                "nearest_m": round(one.nearest, 5),
            }
            for one in report.steps
        ],
        "strong_components": sorted(groups, key=len, reverse=True),
        "dead_ends": dead_ends(report),
        "missing": report.missing,
    }


def dead_ends(report: Report) -> list[dict[str, Any]]:
    """Nodes that are no part of an endless dance, and why."""
    whole, library = report.whole, report.graph.library
    rows = []
    for node in np.flatnonzero(~whole.alive).tolist():
        on, reached = whole.leads_on[node], whole.reached[node]
        why = "no way back" if on and reached else "nothing leads to it" if on else "it leads nowhere"
        if not on and not reached:
            why = "nothing leads to it, and it leads nowhere"
        rows.append({"node": node, "words": library.describe(node), "why": why})
    return rows


def dot_of(report: Report) -> str:
    """The component graph (T062) for Graphviz: a cluster for each step, a node for each structural variation."""
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
        f'  c{one.source} -> c{one.target} [label="{one.joins}", tooltip="{100 * one.nearest:.1f} cm"];'
        for one in report.parts
    ]
    return "\n".join([*lines, "}", ""])


def _quoted(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{plain}"'


def svg_of(report: Report) -> str:
    """The state machine of the steps (Fig 5.11)."""
    library = report.graph.library
    states = []
    for step, name in enumerate(library.steps):
        own = library.node_step == step
        lengths = sorted({int(n) for n in library.node_measures[own]})
        many = "1 measure" if lengths == [1] else f"{'/'.join(map(str, lengths))} measures"
        clips = len(np.unique(library.node_clip[own]))
        states.append(State(name, many, clips, bool(report.whole.alive[own].any())))
    arrows = [Arrow(one.source, one.target, one.joins) for one in report.steps]
    threshold = report.graph.rule.threshold
    counted = f"{len(states)} steps, {len(library.clips)} clips, {len(report.graph.joins.source)} edges"
    return state_machine(states, arrows, f"{counted} within {threshold:g} m")
