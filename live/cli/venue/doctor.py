"""`live doctor`: what this machine has and lacks for a show, and how to get it."""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from live.cli.venue.checks import Check

_MARKS = {"ok": "[green]OK[/]", "limited": "[yellow]limited[/]", "missing": "[red]missing[/]"}


def doctor(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Say what is missing on this machine and how to get it; exit 1 if no show can run."""
    from dataclasses import asdict

    from live.cli.venue.checks import all_checks

    checks = list(all_checks())
    can_run = not any(check.needed and check.state != "ok" for check in checks)
    if as_json:
        print(json.dumps({"can_run": can_run, "checks": [asdict(check) for check in checks]}))
        raise typer.Exit(0 if can_run else 1)

    from rich.console import Console

    console = Console()
    console.print(table_of(checks))
    limited = sum(check.state == "limited" for check in checks)
    if not can_run:
        console.print("[red]No show can run here yet:[/] do what the last column says.")
    elif limited:
        console.print(f"[green]A show can run here[/], with {limited} limits.", highlight=False)
    else:
        console.print("[green]A show can run here.[/]")
    raise typer.Exit(0 if can_run else 1)


def table_of(checks: "Sequence[Check]") -> "Table":
    """The table of checks, as it is printed."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in ("", "what", "found", "how to get it"):
        table.add_column(heading, overflow="fold")
    for check in checks:
        table.add_row(_MARKS[check.state], check.name, Text(check.detail), Text(check.remedy))
    return table
