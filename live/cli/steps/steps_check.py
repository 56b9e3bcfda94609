"""`live steps check`: what is wrong or doubtful in a library, a line each."""

import json
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from live.cli.steps.steps_library import RECORDING_THRESHOLD_M, SKETCH_THRESHOLD_M, folders
from live.library.library_check import Finding, check_connections, check_folder
from live.library.recording_file import nothing_in
from live.show.patch.patch_search_path import PATCHES


def print_findings(library: Path | None, as_json: bool) -> None:
    """Print all findings; exit 1 if something is wrong. PersonError if a folder cannot be read."""
    where = folders(library)
    checked = [check_folder(folder) for folder in where]
    if not any(one.steps or one.findings for one in checked):
        raise nothing_in(where[0])
    findings = [finding for one in checked for finding in one.findings]
    sketched = all(folder == PATCHES / "steps" for folder in where)
    findings += check_connections(checked, where[0], SKETCH_THRESHOLD_M if sketched else RECORDING_THRESHOLD_M)
    findings = list(dict.fromkeys(findings))
    wrong = sum(finding.kind == "wrong" for finding in findings)
    names = {clip.step for one in checked for clip in one.steps}
    if as_json:
        print(json.dumps({"steps": len(names), "findings": [_row(f) for f in findings]}, ensure_ascii=False, indent=1))
    else:
        _print(findings, len(names), wrong, where)
    if wrong:
        raise typer.Exit(1)


def _row(finding: Finding) -> dict[str, Any]:
    problem = finding.problem
    return {
        "kind": finding.kind,
        "file": str(problem.file),
        "line": problem.line,
        "field": problem.field or None,
        "what": problem.words,
    }


def _print(findings: list[Finding], steps: int, wrong: int, where: list[Path]) -> None:
    console = Console(highlight=False)
    for finding in sorted(findings, key=lambda finding: finding.kind != "wrong"):
        style = "red" if finding.kind == "wrong" else "yellow"
        console.print(f"{finding.kind}: {finding.problem}", style=style, soft_wrap=True, markup=False)
    doubtful = len(findings) - wrong
    counted = "1 step" if steps == 1 else f"{steps} steps"
    summary = f"{counted} in {', '.join(map(str, where))}: {wrong} wrong, {doubtful} doubtful"
    console.print(f"{'ok ' if not findings else ''}{summary}", style="" if findings else "green", soft_wrap=True)
