"""Command `live doctor`: checks whether this machine can run shows, and prints how to install what is missing."""

import json
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

from live.app.machine.machine_check import Check, all_checks

_MARKS = {"ok": "[green]OK[/]", "limited": "[yellow]limited[/]", "missing": "[red]missing[/]"}


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Report what is missing on this machine and how to get it; exit 1 if no show can run."""
    verdicts = ("A show can run here", "No show can run here yet")
    print_checks(list(all_checks()), "can_run", verdicts, as_json=as_json)


def print_checks(checks: Sequence[Check], key: str, verdicts: tuple[str, str], *, as_json: bool) -> NoReturn:
    """Print a table and the good or the bad one of `verdicts`, or JSON with the verdict at `key`; then exit, with 1 if
    something required is missing."""
    from dataclasses import asdict

    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    good = not any(check.needed and check.state != "ok" for check in checks)
    if as_json:
        print(json.dumps({key: good, "checks": [asdict(check) for check in checks]}))
        raise typer.Exit(0 if good else 1)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in ("", "what", "found", "how to get it"):
        table.add_column(heading, overflow="fold")
    for check in checks:
        table.add_row(_MARKS[check.state], check.name, Text(check.detail), Text(check.remedy))
    console = Console(highlight=False)
    console.print(table)
    limited = sum(check.state == "limited" for check in checks)
    if not good:
        console.print(f"[red]{verdicts[1]}:[/] follow the last column.")
    else:
        console.print(f"[green]{verdicts[0]}[/]" + (f", with {limited} limitations." if limited else "."))
    raise typer.Exit(0 if good else 1)
