"""`live simulate`: avoidance alone, on anybody's scenario."""

import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from live.base.errors import PersonError

if TYPE_CHECKING:
    from live.agents.scenarios.metrics import Metrics
    from live.agents.scenarios.scenario import Scenario

MOST_NUMBERS = 1 << 25
"""Coordinates that a run may have in all: a quarter of a gigabyte."""


def simulate(
    scenario: Annotated[Path, typer.Argument(help="A scenario (JSON), or the name of one of ours, as circle-50.")],
    out: Annotated[Path | None, typer.Option(help="Write time, position and arrived (npz).")] = None,
    avoidance: Annotated[
        Literal["predictive", "thesis"],
        typer.Option(help="How agents avoid each other: by time to collision, or by the two distances of the thesis."),
    ] = "predictive",
    seed: Annotated[int, typer.Option(help="Seed of all chance.", min=0, max=2**31 - 1)] = 0,
    svg: Annotated[Path | None, typer.Option(help="Draw everybody's way (SVG).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was measured as JSON.")] = False,
) -> None:
    """Let agents go from their places to their goals without bumping into each other."""
    import numpy as np

    from live.agents.scenarios.metrics import measure
    from live.agents.scenarios.run import simulate as run
    from live.agents.scenarios.run import ticks_in
    from live.app.whole_file import write_whole
    from live.cli.pictures.simulate_svg import ways_picture

    wanted = read(scenario, seed)
    samples = ticks_in(wanted.duration) + 1
    if 2 * samples * wanted.agent_count > MOST_NUMBERS:
        what = f"{scenario}: duration: {wanted.agent_count:,} agents at {samples:,} ticks are too much to keep"
        raise PersonError(what, f"give at most {MOST_NUMBERS // (128 * wanted.agent_count)} s, or fewer agents")
    time, position, arrived = run(wanted, avoidance=avoidance, seed=seed)
    if out is not None:
        packed = io.BytesIO()
        np.savez(packed, time=time, position=position, arrived=arrived)
        write_whole(packed.getvalue(), out, "--out")
    if svg is not None:
        write_whole(ways_picture(wanted, time, position).encode(), svg, "--svg")
    show(measure(wanted, time, position), as_json)


def read(path: Path, seed: int = 0) -> "Scenario":
    """The scenario in a file, or the one of ours that is so called; PersonError where there is neither."""
    from live.agents.scenarios.generate import SCENARIOS
    from live.agents.scenarios.reading import MOST_BYTES, read_scenario, unread_fields

    if str(path) in SCENARIOS and not path.exists():
        return SCENARIOS[str(path)](seed)
    try:
        if path.is_file() and path.stat().st_size > MOST_BYTES:
            raise PersonError(f"{path}: larger than {MOST_BYTES:,} bytes", "give a smaller scenario")
        text = path.read_bytes()
    except OSError as error:
        remedy = f"give a scenario (JSON), or one of {', '.join(SCENARIOS)}"
        raise PersonError(f"{path}: cannot be read: {error.strerror}", remedy) from None
    scenario = read_scenario(text, str(path))
    for name in unread_fields(text):
        typer.echo(f"{path}: {name!r} means nothing in a scenario", err=True)
    return scenario


def show(metrics: "Metrics", as_json: bool) -> None:
    """Print the figures of a run."""
    figures = metrics.as_json()
    if as_json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name.replace('_', ' '):28}{'-' if value is None else format(value, '.4g')}")
