"""Commands `live cluster`: how the machines of a show are, and restarts of them during the show."""

import contextlib
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from live.nodes.operator import Operator, SeenCluster

app = typer.Typer(name="cluster", help="Render nodes of a show: their state, and restarts.", no_args_is_help=True)

Leader = Annotated[
    str | None,
    typer.Option("--leader", help="The machine that plays the show. Default: this one.", metavar="HOST[:PORT]"),
]


@app.command()
def status(
    leader: Leader = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """Show all nodes: version, state, offset of the clock, lateness; exit 1 if one does not follow."""
    with _operator(leader) as operator:
        seen = operator.status(operator.leader())
    if as_json:
        print(json.dumps(_as_json(seen)))
    else:
        _print(seen)
    follows = [node.told.state == "follows" and node.age < LATE for node in seen.nodes]
    raise typer.Exit(0 if all(follows) else 1)


@app.command()
def restart(
    names: Annotated[list[str] | None, typer.Argument(help="Nodes. Default: all.", metavar="[NODE]...")] = None,
    leader: Leader = None,
) -> None:
    """Start nodes again, one after another, each once the one before follows: a new version, or changed steps."""
    with _operator(leader) as operator:
        who = operator.leader()
        wanted = names or [seen.told.name for seen in operator.status(who).nodes]
        for name in operator.restart(who, wanted):
            print(f"{name} is back")


LATE = 3.0
"""Seconds of silence after which a node counts as gone."""


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
    return {
        "leader": told.leader, "version": told.version, "epoch": told.epoch, "tick": told.tick, "leads": told.leads,
        "nodes": [{**asdict(node.told), "age_s": node.age} for node in seen.nodes],
    }  # fmt: skip


def _print(seen: "SeenCluster") -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console, told = Console(highlight=False), seen.status
    console.print(f"leader {told.leader}, version {told.version}, epoch {told.epoch}, tick {told.tick}", markup=False)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for heading in (
        "node", "state", "version", "tick", "offset", "rate", "round trip", "late frames", "late by", "clock",
        "outputs", "",
    ):  # fmt: skip
        table.add_column(heading, overflow="fold")
    for node in seen.nodes:
        one = node.told
        state = one.state if node.age < LATE else f"gone for {node.age:.0f} s"
        row = (
            one.name, state, one.version, str(one.tick), f"{one.offset_ms:.2f} ± {one.error_ms:.2f} ms",
            f"{one.rate_ppm:.1f} ppm", f"{one.round_trip_ms:.2f} ms", f"{one.late} of {one.frames}",
            f"{one.late_ms:.1f} ms", one.discipline, one.outputs, one.why,
        )  # fmt: skip
        table.add_row(*(Text(value) for value in row))
    console.print(table)
    if not seen.nodes:
        console.print("no nodes")
