"""Command `live soak`: soak test of a show with a simulated band, phones and faults, in virtual or real time."""

from pathlib import Path
from typing import Annotated, Any

import typer


def soak(
    patch: Annotated[list[str] | None, typer.Argument(help="Patches. Default: the first show.")] = None,
    virtual: Annotated[
        bool | None,
        typer.Option(
            "--virtual/--real",
            help="As fast as possible, or in real time without a window (default with --chaos).",
            show_default=False,
        ),
    ] = None,
    chaos: Annotated[
        bool,
        typer.Option(
            "--chaos", help="Inject faults into the program: exceptions in ticks, killed processes, full disks ..."
        ),
    ] = False,
    every: Annotated[bool, typer.Option("--all", help="All built-in patches.")] = False,
    hours: Annotated[float | None, typer.Option(help="Length of the show. Default: 1 hour.")] = None,
    minutes: Annotated[float | None, typer.Option(help="The same in minutes.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Random seed of band, phones, faults and show.")] = 0,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Number of consecutive seeds, from --seed.")] = 1,
    players: Annotated[int, typer.Option(min=0, max=1000, help="Number of phones.")] = 8,
    faults: Annotated[float, typer.Option(help="Frequency of faults; 1: about once a minute, 0: never.")] = 1.0,
    sites: Annotated[
        int, typer.Option(min=0, help="With --chaos --virtual: number of random call sites of the tick. Default: all.")
    ] = 0,
    fps: Annotated[float | None, typer.Option(help="Frames per second. Default: 16; in real time 60.")] = None,
    replay: Annotated[bool, typer.Option("--replay/--no-replay", help="Replay the journal and compare.")] = True,
    minimise: Annotated[
        Path | None,
        typer.Option(help="Only shorten a journal that fails.", metavar="JOURNAL"),
    ] = None,
    to: Annotated[
        Path | None, typer.Option(help="Write the short journal here.", dir_okay=False, metavar="FILE.jsonl")
    ] = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            help="Keep journals here; an interrupted campaign resumes from it.", file_okay=False, metavar="DIR"
        ),
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write the report here, as JSON.", metavar="FILE.json")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Run a show under simulated faults and report what failed; exit 1 if anything did.

    Faults: lost sources, message floods, valid and invalid patch edits, lost devices, tempo jumps. Failures: an
    exception, a NaN or infinite value, a missed or repeated measure, growing memory, a journal whose replay differs.
    With --chaos, the program's processes, disk and code fail as well.
    """
    from rich.console import Console

    from live.app.machine.kernel_warmup import warm_kernels
    from live.app.offline.soak_run import (
        RunOptions,
        minimise_journal,
        patches_of,
        print_campaign,
        print_run,
        print_summary,
        run_all,
        run_one,
    )
    from live.app.option_values import check_range, check_writable
    from live.base.errors import PersonError
    from live.rehearse.soak_test import SoakOptions

    check_range(hours, "--hours", 0.001, 1000.0)
    check_range(minutes, "--minutes", 0.05, 60000.0)
    check_range(faults, "--faults", 0.0, 100.0)
    check_range(fps, "--fps", 1.0, 480.0)
    check_writable(report, "--report")
    if hours is not None and minutes is not None:
        raise PersonError("--hours and --minutes exclude each other", "give one of them")
    length = hours if hours is not None else 1.0 if minutes is None else minutes / 60.0
    console = Console(stderr=True, highlight=False)
    paths = patches_of(patch, every=every)
    warm_kernels(console)
    if minimise is not None:
        facts = minimise_journal(minimise, to, length * 3600.0, console)
        _finish(facts, report, as_json, print_summary)
        return
    rate = fps or (16.0 if virtual or not (chaos or virtual is False) else 60.0)
    plans: list[SoakOptions] = [
        SoakOptions(path, seed=number, hours=length, fps=rate, players=players, faults=faults)
        for path in paths
        for number in range(seed, seed + seeds)
    ]
    wanted = RunOptions(chaos=chaos, virtual=not chaos if virtual is None else virtual, replay=replay, sites=sites)
    if len(plans) == 1 and not chaos:
        facts = run_one(plans[0], folder, console, wanted)
        _finish(facts, report, as_json, print_run)
    else:
        facts = run_all(plans, folder, console, wanted)
        _finish(facts, report, as_json, print_campaign)


def _finish(facts: dict[str, Any], report: Path | None, as_json: bool, print_report: Any) -> None:
    """Write and print the report; exit 1 if the run failed."""
    import json

    text = json.dumps(facts, indent=1)
    if report is not None:
        report.write_text(text + "\n", encoding="utf-8")
    if as_json:
        print(text)
    else:
        print_report(facts)
    if not facts["ok"]:
        raise typer.Exit(1)
