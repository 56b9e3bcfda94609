"""Command `live bench`: runs the benchmarks in the repository's folder bench/.

A benchmark is a file with a docstring (its first line is the title) and `run(full, shared) -> list[Row]`.
"""

import importlib.util
import inspect
import json
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from live.base.errors import PersonError
from live.base.system.process_control import processor_count, processor_name

if TYPE_CHECKING:
    from rich.table import Table

BENCH_FOLDER = Path(__file__).resolve().parent.parent.parent / "bench"
BenchFunction = Callable[[bool, Path | None], "list[Row]"]


@dataclass(frozen=True, slots=True)
class Row:
    """One figure: `value` in `unit` (None: not measured, for example because data is missing), and its limit `bar`.

    `sense`: whether the limit is a minimum or maximum. `peers`: other values measured in the same run, by name; a
    ratio to a peer is comparable between machines, an absolute time is not.
    """

    name: str
    value: float | None
    unit: str
    bar: float | None = None
    sense: Literal["at least", "at most"] = "at most"
    peers: Mapping[str, float] = field(default_factory=dict)
    note: str = ""
    """Why there is no value, or no peer, and what to do about it."""

    @property
    def ok(self) -> bool | None:
        """Whether the value meets the limit; None without a limit or value."""
        if self.value is None or self.bar is None:
            return None
        return self.value >= self.bar if self.sense == "at least" else self.value <= self.bar

    def as_json(self) -> dict[str, Any]:
        """Return the row as printed by `--json`."""
        return {
            "name": self.name,
            "value": self.value,
            "unit": self.unit,
            "bar": self.bar,
            "sense": self.sense,
            "ok": self.ok,
            "peers": dict(self.peers),
            "note": self.note,
        }


def bench_names(folder: Path = BENCH_FOLDER) -> list[str]:
    """Return the sorted benchmark names in `folder`: motion_quality.py is "motion-quality"; _*.py are helpers."""
    return sorted(path.stem.replace("_", "-") for path in folder.glob("*.py") if not path.stem.startswith("_"))


def bench_title(name: str, folder: Path = BENCH_FOLDER) -> str:
    """Return the first line of the benchmark's docstring, read without running it."""
    import ast

    docstring = ast.get_docstring(ast.parse(_bench_file(name, folder).read_text(encoding="utf-8")))
    return (docstring or "").partition("\n")[0]


def _bench_file(name: str, folder: Path) -> Path:
    return folder / f"{name.replace('-', '_')}.py"


def load_bench(name: str, folder: Path = BENCH_FOLDER) -> BenchFunction:
    """Return the `run` of one benchmark file; raise PersonError with the known names if there is none."""
    names = bench_names(folder)
    if not names:
        raise PersonError(
            f"there are no benchmarks in {folder}", "benchmarks are part of the source: run this in a checkout"
        )
    path = _bench_file(name, folder)
    if name.replace("_", "-") not in names:
        raise PersonError(f"no benchmark is called {name!r}; there are: {', '.join(names)}")
    specification = importlib.util.spec_from_file_location(f"bench.{path.stem}", path)
    assert specification is not None  # always set for a .py file
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # dataclasses look up their module here
    specification.loader.exec_module(module)
    run: BenchFunction = module.run
    return run


def with_steps(name: str, run: BenchFunction, steps: Path) -> BenchFunction:
    """Return a benchmark that measures a folder of steps; raise PersonError for one that takes none."""
    if "steps" not in inspect.signature(run).parameters:
        raise PersonError(
            f"--steps: the benchmark {name!r} measures no folder of steps", "live bench locomotion --steps DIR"
        )
    measured: Callable[..., list[Row]] = run
    return partial(measured, steps=steps)


def machine_info() -> dict[str, Any]:
    """Return this machine's {cpu, cores, python, gl}; gl is null without OpenGL."""
    from live.app.machine.machine_check import probe_opengl

    return {
        "cpu": processor_name(),
        "cores": processor_count(),
        "python": platform.python_version(),
        "gl": probe_opengl().renderer,
    }


def _table(title: str, rows: list[Row]) -> "Table":
    from rich.table import Table

    table = Table(title=title, title_justify="left", title_style="bold")
    for heading in ("figure", "value", "unit", "bar", "", "peers"):
        table.add_column(heading, justify="right" if heading in ("value", "bar") else "left")
    marks = {True: "[green]ok[/]", False: "[red]missed[/]", None: ""}
    for row in rows:
        value = "no data" if row.value is None else f"{row.value:,.4g}"
        bar = "" if row.bar is None else f"{row.sense} {row.bar:,.4g}"
        peers = ", ".join([*(f"{name} {peer:,.4g}" for name, peer in row.peers.items()), *filter(None, [row.note])])
        table.add_row(row.name, value, row.unit, bar, marks[row.ok], peers)
    return table


def bench(
    name: Annotated[str | None, typer.Argument(help="The benchmark. Default: all.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead: one object per benchmark.")] = False,
    full: Annotated[bool, typer.Option("--full", help="Measure everything. Default: at most a minute.")] = False,
    shared: Annotated[Path | None, typer.Option(help="Folder with test data.", exists=True, file_okay=False)] = None,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="A folder of steps to measure, for the benchmarks that take one.", exists=True, file_okay=False
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the benchmarks without running them.")] = False,
) -> None:
    """Measure the speed and quality of a show's computations on this machine."""
    from rich.console import Console

    console = Console()
    if list_:
        for each in bench_names():
            console.print(f"[bold]{each}[/]  {bench_title(each)}", highlight=False, soft_wrap=True)
        return
    runs = {each: load_bench(each) for each in ([name] if name is not None else bench_names())}
    if steps is not None:
        runs = {each: with_steps(each, run, steps) for each, run in runs.items()}
    this_machine = machine_info()
    if not as_json:
        console.print(" · ".join(f"{key} {value}" for key, value in this_machine.items()), highlight=False)
    reports = []
    for each, run in runs.items():
        rows = run(full, shared)
        reports.append({"bench": each, "machine": this_machine, "rows": [row.as_json() for row in rows]})
        if not as_json:
            console.print(_table(f"{each}: {bench_title(each)}", rows))
    if as_json:
        print(json.dumps(reports[0] if name is not None else reports))
