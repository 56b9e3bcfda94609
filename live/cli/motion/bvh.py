"""Command `live bvh`: prints the contents of a motion file, with warnings about irregularities."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from live.motion.formats.file_report import MotionReport, SourceTracks
    from live.motion.formats.source_motion import UpAxis


def bvh(
    file: Annotated[Path, typer.Argument(help="A motion file of any format (`live docs steps`).")],
    fps: Annotated[float | None, typer.Option(help="The true frame rate, if the header is wrong.")] = None,
    unit: Annotated[float | None, typer.Option(help="Metres per unit.", metavar="METRES")] = None,
    up: Annotated[str | None, typer.Option(help="The axis that points up.", metavar="Y|Z")] = None,
    skeleton: Annotated[
        Path | None, typer.Option(help="The file with its skeleton, as for .amc. Default: the one next to it.")
    ] = None,
    joints: Annotated[
        Path | None,
        typer.Option(help="Write all joints in metres, Y up: names (J,), positions (T, J, 3).", metavar="OUT.npz"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Print the facts of a motion file: joints, frame rate, axes, unit, floor, travel, and warnings."""
    from live.app.option_values import check_range, check_writable
    from live.base.errors import PersonError
    from live.library.motion_file import read_motion
    from live.motion.formats.file_error import MotionFileError
    from live.motion.formats.file_report import analyze_motion

    check_range(fps, "--fps", 1, 10_000)
    check_range(unit, "--unit", 1e-6, 1000)
    if up is not None and up.upper() not in ("Y", "Z"):
        raise PersonError(f"--up {up!r}: Y or Z expected")
    check_writable(joints, "--joints")
    if joints is not None and joints.suffix.lower() != ".npz":  # else a recording named by mistake would be overwritten
        raise PersonError(f"--joints {joints}: a name that ends in .npz expected", f"--joints {joints.stem}.npz")
    if joints is not None and joints.exists() and file.exists() and joints.samefile(file):
        raise PersonError(f"--joints {joints}: that is the input file", "give the new file another name")
    axis: UpAxis | None = None if up is None else "Z" if up.upper() == "Z" else "Y"
    try:
        motion = read_motion(file, skeleton=skeleton, up=axis)
        facts, tracks = analyze_motion(motion, fps=fps, unit_m=unit, up=axis)
    except MotionFileError as error:
        raise PersonError(str(error)) from None
    if joints is not None:
        _write_joints(joints, tracks)
    if as_json:
        print(json.dumps(facts_json(facts)))
        return
    from rich.console import Console

    Console().print(_table(str(file), facts))


def facts_json(facts: "MotionReport") -> dict[str, Any]:
    """Return the object that `--json` prints; a warning is {what}, and if known `frame` (from 0) or `line` (from 1)."""
    from dataclasses import fields

    values = {field.name: getattr(facts, field.name) for field in fields(facts)}
    values["warnings"] = [
        {key: value for key, value in (("frame", one.frame), ("line", one.line)) if value is not None}
        | {"what": one.what}
        for one in facts.warnings
    ]
    return values


def _write_joints(path: Path, tracks: "SourceTracks") -> None:
    import numpy as np

    from live.base.errors import PersonError

    try:
        with path.open("wb") as out:
            np.savez(out, names=np.array(tracks.names), positions=tracks.positions)
    except OSError as error:
        raise PersonError(f"--joints {path}: cannot be written: {error.strerror}") from None


def _table(file: str, facts: "MotionReport") -> "Table":
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(file), title_justify="left", box=None, show_header=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, words in _rows(facts):
        table.add_row(name, Text(words))
    return table


def _rows(facts: "MotionReport") -> list[tuple[str, str]]:
    """Return the facts as pairs of label and text."""

    def metres(value: float | None) -> str:
        return "unknown" if value is None else f"{value:.3g} m"

    declared = "" if facts.frames == facts.frames_declared else f" (the file says {facts.frames_declared})"
    header = "" if facts.fps == facts.header_fps else f" (the file says {facts.header_fps:.6g})"
    offset = {
        "zero": "none",
        "add": "to be added to its position channels",
        "replace": "already in its position channels",
        None: "unknown",
    }
    rows = [
        ("skeleton", f"{facts.joints} joints, {facts.end_sites} end sites, {facts.channels} channels"),
        ("frames", f"{facts.frames}{declared}, {facts.fps:.6g} a second{header}: {facts.seconds:.2f} s"),
        ("unit, up axis", f"{metres(facts.unit_m)}, {facts.up or 'unknown'}"),
        ("root offset", offset[facts.root_offset]),
        ("floor", f"{metres(facts.floor_m)} over zero"),
        ("body height", metres(facts.height_m)),
        ("travel of the hips", metres(facts.travel_m)),
    ]
    rows += [(engine, source or "-") for engine, source in facts.mapped.items()]
    for one in facts.warnings:
        place = (
            f"line {one.line}: " if one.line is not None else f"frame {one.frame}: " if one.frame is not None else ""
        )
        rows.append(("warning", place + one.what))
    return rows
