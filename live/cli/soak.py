"""`live soak`: hours of a show with a made-up band, players and faults; in virtual time, or minutes of it for real."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from live.rehearse.soak_report import Plan, Report


def soak(
    patch: Annotated[str | None, typer.Argument(help="A patch. Default: the first show.")] = None,
    virtual: Annotated[
        bool, typer.Option("--virtual/--real", help="As fast as the machine can, or in real time without a window.")
    ] = True,
    hours: Annotated[float | None, typer.Option(help="How long the show is. Default: 1 hour.")] = None,
    minutes: Annotated[float | None, typer.Option(help="The same in minutes.")] = None,
    seed: Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Seed of band, players, faults and show.")] = 0,
    players: Annotated[int, typer.Option(min=0, max=1000, help="People with phones.")] = 8,
    faults: Annotated[float, typer.Option(help="How often things go wrong; 1: about once a minute, 0: never.")] = 1.0,
    fps: Annotated[float | None, typer.Option(help="Frames per second. Default: 16, in real time 60.")] = None,
    replay: Annotated[bool, typer.Option("--replay/--no-replay", help="Replay its journal and compare.")] = True,
    folder: Annotated[
        Path | None, typer.Option(help="Keep the journal and the edited patch here.", file_okay=False, metavar="DIR")
    ] = None,
    report: Annotated[Path | None, typer.Option(help="Write the report here, as JSON.", metavar="FILE.json")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
) -> None:
    """Let a show run through everything that may happen to it, and say what went wrong; exit 1 if anything did.

    Sources lost, floods of messages, edits of the patch good and bad, devices that go, tempi that jump. What must
    not happen: an exception, a value that is no number, a measure missed or danced twice, memory that grows, a
    journal that replays otherwise.
    """
    import json
    import tempfile

    from rich.console import Console

    from live.base.errors import PersonError
    from live.cli.options import parse_number, writable_file
    from live.cli.warm import warm_kernels
    from live.rehearse.soak_report import Plan
    from live.show.patch_places import find_patch

    parse_number(hours, "--hours", 0.001, 1000.0)
    parse_number(minutes, "--minutes", 0.05, 60000.0)
    parse_number(faults, "--faults", 0.0, 100.0)
    parse_number(fps, "--fps", 1.0, 480.0)
    writable_file(report, "--report")
    if hours is not None and minutes is not None:
        raise PersonError("--hours and --minutes say the same", "give one of them")
    length = hours if hours is not None else 1.0 if minutes is None else minutes / 60.0
    console = Console(stderr=True, highlight=False)
    warm_kernels(console)
    plan = Plan(
        find_patch(patch),
        seed=seed,
        hours=length,
        fps=fps or (16.0 if virtual else 60.0),
        players=players,
        faults=faults,
    )
    if folder is not None:
        facts = _run(plan, folder, console, virtual=virtual, replay=replay)
    else:
        with tempfile.TemporaryDirectory(prefix="live-soak-") as there:
            facts = _run(plan, Path(there), console, virtual=virtual, replay=replay)
    text = json.dumps(facts, indent=1)
    if report is not None:
        report.write_text(text + "\n", encoding="utf-8")
    if as_json:
        print(text)
    else:
        _tell(facts)
    if not facts["ok"]:
        raise typer.Exit(1)


def _run(plan: "Plan", folder: Path, console: Any, *, virtual: bool, replay: bool) -> dict[str, Any]:
    from live.rehearse.proving import prove
    from live.rehearse.soak import Soak

    def progress(time: float, report: "Report") -> None:
        speed = time / report.took if report.took else 0.0
        words = f"{time / 60.0:.0f} min, {speed:.1f} times as fast as life, {report.memory[-1][1]:.0f} MB"
        console.print(words, style="dim")

    if virtual:
        running = Soak(plan, folder)
        report, journal = running.run(progress), running.journal_path
    else:
        from live.cli.soak_real import soak_real

        report, journal = soak_real(plan, folder, console)
    if replay:
        console.print("replaying its journal ...", style="dim")
        report.replay = prove(journal, seed=plan.seed)
    return report.as_json()


def _tell(facts: dict[str, Any]) -> None:
    from rich.console import Console

    console = Console(highlight=False)
    grown, replay = facts["memory_growth_mb"], facts["replay"]
    lines = [
        f"{facts['seconds'] / 3600.0:.2f} h of the show, {facts['measures']} measures, {sum(facts['events'].values())} "
        f"events, {sum(facts['faults'].values())} faults; {facts['skipped']} ticks left out in stalls",
        "memory: " + ("not long enough to say" if grown is None else f"within {grown:.1f} MB after the beginning"),
    ]
    if replay:
        lines.append(
            f"replay: {replay['measures']} measures compared, {replay['different']} differ (the whole of it, and "
            f"{replay['stretches']} stretches from snapshots)"
        )
        lines += replay["problems"][:5]
    for words in lines:
        console.print(words, soft_wrap=True, markup=False)
    for problem in facts["problems"][:20]:
        console.print(problem, style="red", soft_wrap=True, markup=False)
    if facts["count"] > 20:
        console.print(f"and {facts['count'] - 20} more", style="red")
    console.print("[green]nothing went wrong[/]" if facts["ok"] else "[red]this must not happen[/]")
