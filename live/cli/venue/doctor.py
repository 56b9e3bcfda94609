"""Command `live doctor`: checks whether this machine can run shows, and prints how to install what is missing."""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from live.app.machine.machine_check import Check, all_checks

if TYPE_CHECKING:
    from rich.table import Table


_MARKS = {"ok": "[green]OK[/]", "limited": "[yellow]limited[/]", "missing": "[red]missing[/]"}


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Report what is missing on this machine and how to get it; exit 1 if no show can run."""
    from dataclasses import asdict

    checks = list(all_checks())
    can_run = not any(check.needed and check.state != "ok" for check in checks)
    if as_json:
        print(json.dumps({"can_run": can_run, "checks": [asdict(check) for check in checks]}))
        raise typer.Exit(0 if can_run else 1)

    from rich.console import Console

    console = Console()
    console.print(checks_table(checks))
    limited = sum(check.state == "limited" for check in checks)
    if not can_run:
        console.print("[red]No show can run here yet:[/] follow the last column.")
    elif limited:
        console.print(f"[green]A show can run here[/], with {limited} limitations.", highlight=False)
    else:
        console.print("[green]A show can run here.[/]")
    raise typer.Exit(0 if can_run else 1)


def checks_table(checks: Sequence[Check]) -> "Table":
    """Return the table of checks for printing."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in ("", "what", "found", "how to get it"):
        table.add_column(heading, overflow="fold")
    for check in checks:
        table.add_row(_MARKS[check.state], check.name, Text(check.detail), Text(check.remedy))
    return table
