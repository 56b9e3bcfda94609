"""Commands `live cluster`: how the parts of a show are, and restarts of them during the show."""

import contextlib
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from live.nodes.operator import Operator, SeenCluster

app = typer.Typer(
    name="cluster", help="Render nodes, gateways and standby machines of a show: their state, and restarts.",
    no_args_is_help=True,
)  # fmt: skip

Leader = Annotated[
    str | None,
    typer.Option("--leader", help="The machine that plays the show. Default: this one.", metavar="HOST[:PORT]"),
]


@app.command()
def status(
    leader: Leader = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Show all parts of a show: version, state, offset of the clock, lateness; exit 1 if one does not do its work."""
    with _operator(leader) as operator:
        seen = operator.status(operator.leader())
    if as_json:
        print(json.dumps(_as_json(seen)))
    else:
        _print(seen)
    raise typer.Exit(0 if seen.works else 1)


@app.command()
def restart(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            help="Nodes, gateways, standby machines, or reducer, by the names of live cluster status. Default: all.",
            metavar="[NAME]...",
        ),
    ] = None,
    leader: Leader = None,
) -> None:
    """Start parts of a show again, one after another, each once the one before works: a new version, or changed steps.

    A gateway's phones come back at the others. The machine that leads is left alone.
    """
    with _operator(leader) as operator:
        for part in operator.restart(operator.leader(), names or []):
            print(f"{part.name} is back", flush=True)


@contextlib.contextmanager
def _operator(leader: str | None) -> Iterator["Operator"]:
    """The bus of a leader, for a moment."""
    from live.app.processes.node_main import parse_leaders
    from live.nodes.bus import ZenohBus
    from live.nodes.operator import Operator
    from live.nodes.signed_bus import SignedBus
    from live.supervisor.network.identity import Pairings, load_identity

    identity, pairings = load_identity(), Pairings()
    transport = ZenohBus(identity, pairings, connect=parse_leaders([leader or "127.0.0.1"]))
    bus = SignedBus(transport, identity, pairings)
    try:
        yield Operator(bus)
    finally:
        bus.close()


def _as_json(seen: "SeenCluster") -> dict[str, object]:
    from dataclasses import asdict

    told = seen.status
    found: dict[str, list[dict[str, object]]] = {"standby": [], "gateway": [], "reducer": []}
    for member in seen.members:
        row = asdict(member)
        found[row.pop("kind")].append(row)
    return {
        "leader": told.leader, "version": told.version, "epoch": told.epoch, "tick": told.tick, "leads": told.leads,
        "refused": told.refused, "strangers": told.strangers,
        "nodes": [{**asdict(node.told), "age_s": node.age} for node in seen.nodes],
        "standbys": found["standby"], "gateways": found["gateway"], "reducer": next(iter(found["reducer"]), None),
    }  # fmt: skip


def _print(seen: "SeenCluster") -> None:
    from rich.console import Console

    console, told = Console(highlight=False), seen.status
    console.print(f"leader {told.leader}, version {told.version}, epoch {told.epoch}, tick {told.tick}", markup=False)
    if told.refused or told.strangers:
        console.print(f"refused: {told.refused} invalid messages, {told.strangers} of strangers", markup=False)
    rows: list[tuple[str, ...]] = []
    for node in seen.nodes:
        one = node.told
        state = one.state if node.state == one.state else f"gone for {node.age:.0f} s"
        rows.append((
            one.name, state, one.version, str(one.tick), f"{one.offset_ms:.2f} ± {one.error_ms:.2f} ms",
            f"{one.rate_ppm:.1f} ppm", f"{one.round_trip_ms:.2f} ms", f"{one.late} of {one.frames}",
            f"{one.late_ms:.1f} ms", one.discipline, one.outputs, one.why,
        ))  # fmt: skip
    if rows:
        _print_table(console, (
            "node", "state", "version", "tick", "offset", "rate", "round trip", "late frames", "late by", "clock",
            "outputs", "",
        ), rows)  # fmt: skip
    rows = [
        (part.kind, part.name, part.state, part.version, part.machine or "here", f"{part.offset_ms:.2f} ms",
         f"{part.late_ms:.1f} ms", f"{part.silent_ms:.0f} ms", part.load, part.why)
        for part in seen.members
    ]  # fmt: skip
    if rows:
        headings = ("part", "name", "state", "version", "machine", "offset", "late by", "silent for", "load", "")
        _print_table(console, headings, rows)
    if not seen.parts:
        console.print("no nodes, gateways or standby machines")


def _print_table(console: "Console", headings: tuple[str, ...], rows: "list[tuple[str, ...]]") -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for row in rows:
        table.add_row(*(Text(value) for value in row))
    console.print(table)
