"""Reports of `live steps list`, `show` and `check`: steps as table or JSON, one step in full, and library problems.

`live steps show STEP --reach OUT.svg|OUT.png` draws the region that one measure of a step can reach.
"""

import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from live.app.offline.step_listing import (
    RECORDING_THRESHOLD_M,
    SKETCH_THRESHOLD_M,
    NamedStep,
    find_step,
    library_folders,
    named_steps,
    threshold_for,
)
from live.app.option_values import check_writable
from live.app.pictures.reach_picture import PngCanvas, SvgCanvas, draw_reach
from live.base.errors import PersonError
from live.graph.clusters import successors
from live.graph.motion_graph import build_graph
from live.graph.select.candidates import find_candidates
from live.graph.select.reachability import Reach, reach_of
from live.graph.step_library import build_library
from live.library.library_check import Finding, check_connections, check_folder
from live.library.recording_file import no_steps_error
from live.library.whole_file import write_atomically
from live.motion.step_clip import StepClip, beat_contacts, foot_slide, travel
from live.show.patch.patch_search_path import PATCHES


def step_row(step: NamedStep) -> dict[str, Any]:
    """Return a step as JSON: the values of all its variations."""
    first = step.clips[0]
    distances = [round(clip.distance_m, 3) for clip in step.clips]
    return {
        "name": step.name,
        "variations": len(step.clips),
        "mood_examples": step.examples,
        "measures": sorted({clip.measures for clip in step.clips}),
        "beats_per_measure": first.beats_per_measure,
        "beats": sorted({clip.beats for clip in step.clips}),
        "bpm": sorted({round(clip.bpm, 3) for clip in step.clips}),
        "directions": step.directions,
        "distance_m": [min(distances), max(distances)],
        "leading_foot": step.values_of("leading_foot"),
        "begin_pose": step.values_of("begin_pose"),
        "end_pose": step.values_of("end_pose"),
        "weight_transfer": any(clip.weight_transfer for clip in step.clips),
        "author": step.values_of("author"),
        "style": step.values_of("style"),
        "tags": step.tags,
        "folder": str(step.folder),
    }


def print_list(library: Path | None, as_json: bool) -> None:
    """Print all steps; raise PersonError if the library cannot be read."""
    rows = [step_row(step) for step in named_steps(library)]
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
        ", ".join(
            [*row["style"], *row["tags"], *([f"{row['mood_examples']} mood examples"] * (row["mood_examples"] > 0))]
        ),
    ]
    return [escape(cell) for cell in cells]


def _span(values: list[float]) -> str:
    return f"{values[0]:g}" if len(values) == 1 else f"{values[0]:g}–{values[-1]:g}"


CONTACT = " ▁▂▃▄▅▆▇█"
"""Characters for a beat's share of contact, from none to all."""


def print_step(name: str, library: Path | None, as_json: bool) -> None:
    """Print everything about the step called `name`; raise PersonError if there is none."""
    steps = named_steps(library)
    step = find_step(steps, name)
    beats = step.clips[0].beats_per_measure
    clips = [clip for one in steps for clip in one.clips if clip.beats_per_measure == beats]
    graph_library = build_library(clips)
    index = graph_library.steps.index(step.name)
    threshold = threshold_for(steps)
    row = step_row(step) | {
        "clips": [clip_row(number, clip) for number, clip in enumerate(step.clips, start=1)],
        "followers": [
            {"step": f.step, "distance_m": round(f.distance_m, 4), "pairs": f.pairs}
            for f in successors(graph_library, index, threshold=threshold)
        ],
        "threshold_m": threshold,
    }
    if as_json:
        print(json.dumps(row, ensure_ascii=False, indent=1))
    else:
        _print_row(row)


def clip_row(number: int, clip: StepClip) -> dict[str, Any]:
    """Return one variation as JSON; contacts are shares of each beat, left and right foot."""
    slide = foot_slide(clip)
    return {
        "variation": number,
        "clip": clip.clip.name,
        "seconds": round(clip.measures * clip.samples_per_measure / clip.clip.sample_rate, 3),
        "measures": clip.measures,
        "bpm": clip.bpm,
        "direction": clip.direction,
        "distance_m": round(clip.distance_m, 3),
        "mirrored": clip.mirrored,
        "leading_foot": clip.leading_foot or None,
        "begin_pose": clip.begin_pose or None,
        "end_pose": clip.end_pose or None,
        "travel_m": [round(float(value), 3) for value in travel(clip)],
        "contacts": [[round(float(share), 2) for share in beat] for beat in beat_contacts(clip)],
        "foot_slide": None if slide is None else round(slide, 4),
    }


def _print_row(row: dict[str, Any]) -> None:
    console = Console(highlight=False)

    def say(text: str = "", style: str = "") -> None:
        console.print(text, style=style, soft_wrap=True, markup=False)

    say(row["name"], "bold")
    for label, value in _detail_rows(row):
        say(f"  {label:<16} {value}")
    say()
    for clip in row["clips"]:
        x, z = clip["travel_m"]
        mirrored = ", mirrored" if clip["mirrored"] else ""
        slide = "no contact" if clip["foot_slide"] is None else f"feet slide {100 * clip['foot_slide']:.1f} cm/s"
        say(
            f"  {clip['variation']:>3}  {clip['direction']}{mirrored}: {clip['distance_m']:.2f} m "
            f"(x {x:+.2f}, z {z:+.2f}), {clip['seconds']:.2f} s at {clip['bpm']:g} bpm, {slide}"
        )
        say(f"       {clip['clip']}", "dim")
        for foot, side in enumerate(("left", "right")):
            marks = "".join(CONTACT[round(beat[foot] * (len(CONTACT) - 1))] * 2 + " " for beat in clip["contacts"])
            console.print(Text(f"       {side:<5} foot on the floor  |{marks[:-1]}|", style="dim"), soft_wrap=True)
    say()
    if row["followers"]:
        say(f"  can be followed by (within {row['threshold_m']:g} m):")
        for follower in row["followers"]:
            say(f"    {follower['step']:<24} {100 * follower['distance_m']:5.1f} cm, {follower['pairs']} joins")
    else:
        say(f"  no step can follow it within {row['threshold_m']:g} m: record a step that begins as it ends", "yellow")


def _detail_rows(row: dict[str, Any]) -> list[tuple[str, str]]:
    beats = ", ".join(f"{count}" for count in row["beats"])
    told = [("length", f"{beats} beats, {row['beats_per_measure']} to a measure"), ("folder", row["folder"])]
    for key in ("leading_foot", "begin_pose", "end_pose", "author", "style", "tags"):
        if row[key]:
            told.append((key.replace("_", " "), ", ".join(row[key])))
    if row["weight_transfer"]:
        told.append(("weight transfer", "repeats alternate the sides"))
    return told


ANY_POSE_THRESHOLD = 1e3
"""Join threshold [m] for reach pictures, which do not depend on joins."""


def check_picture(to: Path) -> None:
    """Raise PersonError unless the picture could be written."""
    if to.suffix.lower() not in (".svg", ".png"):
        raise PersonError(f"--reach {to}: a name that ends in .svg or .png expected", f"--reach {to.stem}.svg")
    check_writable(to, "--reach")


def reach_of_step(name: str, library: Path | None) -> Reach:
    """Return the reach of the step called `name` at its own tempo; raise PersonError if there is none."""
    step = find_step(named_steps(library), name)
    beats = step.clips[0].beats_per_measure
    own = build_library([clip for clip in step.clips if clip.beats_per_measure == beats])
    graph = build_graph(own, threshold=ANY_POSE_THRESHOLD, prune=False)
    return reach_of(graph, find_candidates(graph), 0, beats * 60.0 / step.clips[0].bpm)


def write_reach(name: str, library: Path | None, to: Path) -> None:
    """Draw the reach of the step called `name` and write the picture."""
    check_picture(to)
    canvas = SvgCanvas() if to.suffix.lower() == ".svg" else PngCanvas()
    draw_reach(reach_of_step(name, library), canvas)
    write_atomically(canvas.data(), to, "--reach")


def print_findings(library: Path | None, as_json: bool) -> int:
    """Print all findings; return the number of errors. Raise PersonError if a folder cannot be read."""
    where = library_folders(library)
    checked = [check_folder(folder) for folder in where]
    if not any(one.steps or one.findings for one in checked):
        raise no_steps_error(where[0])
    findings = [finding for one in checked for finding in one.findings]
    sketched = all(folder == PATCHES / "steps" for folder in where)
    findings += check_connections(checked, where[0], SKETCH_THRESHOLD_M if sketched else RECORDING_THRESHOLD_M)
    findings = list(dict.fromkeys(findings))
    wrong = sum(finding.kind == "wrong" for finding in findings)
    names = {clip.step for one in checked for clip in one.steps}
    if as_json:
        print(json.dumps({"steps": len(names), "findings": [_row(f) for f in findings]}, ensure_ascii=False, indent=1))
    else:
        _print_findings(findings, len(names), wrong, where)
    return wrong


def _row(finding: Finding) -> dict[str, Any]:
    problem = finding.problem
    return {
        "kind": finding.kind,
        "file": str(problem.file),
        "line": problem.line,
        "field": problem.field or None,
        "what": problem.message,
    }


def _print_findings(findings: list[Finding], steps: int, wrong: int, where: list[Path]) -> None:
    console = Console(highlight=False)
    for finding in sorted(findings, key=lambda finding: finding.kind != "wrong"):
        style = "red" if finding.kind == "wrong" else "yellow"
        console.print(f"{finding.kind}: {finding.problem}", style=style, soft_wrap=True, markup=False)
    doubtful = len(findings) - wrong
    counted = "1 step" if steps == 1 else f"{steps} steps"
    summary = f"{counted} in {', '.join(map(str, where))}: {wrong} wrong, {doubtful} doubtful"
    console.print(f"{'ok ' if not findings else ''}{summary}", style="" if findings else "green", soft_wrap=True)
