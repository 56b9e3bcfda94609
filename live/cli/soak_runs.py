"""The runs of `live soak`: one, or a campaign of many; what is told of them."""

import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from live.base.errors import PersonError
from live.rehearse.campaign import Campaign, Facts, Job, guarded, lines_of, problem_lines
from live.rehearse.failure import Failure
from live.rehearse.proving import prove
from live.rehearse.soak import Soak
from live.rehearse.soak_report import Plan, Report
from live.show.patch.patch_search_path import MAIN_FILE, PATCHES, find_patch


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a run does beside its plan."""

    chaos: bool = False
    virtual: bool = True
    replay: bool = True
    sites: int = 0
    """Call sites of the tick that fail, drawn; 0: all."""


def patches_of(names: list[str] | None, *, every: bool) -> list[Path]:
    """The patches that are meant; PersonError for one that is not there."""
    if every:
        folders = sorted(PATCHES.glob(f"*/{MAIN_FILE}"))
        return [*folders, *(path for path in sorted(PATCHES.glob("*.toml")) if not path.stem.endswith(".midi"))]
    return [find_patch(name) for name in names or [None]]  # type: ignore[list-item]


def run_one(plan: Plan, folder: Path | None, console: Console, wanted: Wanted) -> Facts:
    """One run; without a folder its files are kept only if it went wrong."""
    there = folder or Path(tempfile.mkdtemp(prefix="live-soak-"))
    there.mkdir(parents=True, exist_ok=True)
    facts = guarded(Job("", lambda into: run(plan, into, console, wanted)), there)
    return _kept(facts, there, folder)


def run_all(plans: list[Plan], folder: Path | None, console: Console, wanted: Wanted) -> Facts:
    """All of them, those that `folder` knows left out."""
    there = folder or Path(tempfile.mkdtemp(prefix="live-soak-"))
    first = plans[0]
    what = {"hours": first.hours, "fps": first.fps, "players": first.players, "faults": first.faults, **asdict(wanted)}

    def tell(words: str) -> None:
        console.print(words, soft_wrap=True, markup=False)

    campaign = Campaign(there, what, tell)
    jobs = [Job(name_of(plan), lambda into, plan=plan: run(plan, into, console, wanted)) for plan in plans]  # type: ignore[misc]
    try:
        facts = campaign.run(jobs)
    except (KeyboardInterrupt, SystemExit):
        facts = campaign.report([job.name for job in jobs])
    return _kept(facts, there, folder)


def _kept(facts: Facts, there: Path, folder: Path | None) -> Facts:
    if folder is None and facts["ok"]:
        shutil.rmtree(there, ignore_errors=True)
    else:
        facts["folder"] = str(there)
    return facts


def name_of(plan: Plan) -> str:
    """The name of a run: its patch and seed."""
    patch = plan.patch.parent.name if plan.patch.name == MAIN_FILE else plan.patch.stem
    return f"{patch}-{plan.seed}"


def run(plan: Plan, folder: Path, console: Console, wanted: Wanted) -> Facts:
    """One run with its files in `folder`: the facts of its report."""
    if wanted.chaos and wanted.virtual:
        from live.rehearse.chaos.virtual_run import virtual_chaos

        return virtual_chaos(plan, folder, sites=wanted.sites, tell=lambda words: console.print(words, style="dim"))
    if wanted.chaos:
        from live.rehearse.chaos.real_run import real_chaos

        return real_chaos(plan, folder, lambda words: console.print(words, style="dim", soft_wrap=True, markup=False))

    def progress(time: float, report: Report) -> None:
        speed = time / report.took if report.took else 0.0
        words = f"{time / 60.0:.0f} min, {speed:.1f} times as fast as life, {report.memory[-1][1]:.0f} MB"
        console.print(words, style="dim")

    report = Report(plan)
    try:
        if wanted.virtual:
            running = Soak(plan, folder)
            report, journal = running.report, running.journal_path
            running.run(progress)
        else:
            from live.cli.soak_real import soak_real

            report, journal = soak_real(plan, folder, console)
        if wanted.replay:
            console.print("replaying its journal ...", style="dim")
            report.replay = prove(journal, seed=plan.seed)
    except PersonError:
        raise
    except (KeyboardInterrupt, SystemExit):  # Ctrl-C, or `kill`
        report.count += 1
        report.problems.append("interrupted")
    except Exception as error:
        report.fail(Failure.of(error), "the harness itself failed: ")
    return {**report.as_json(), "summary": summary(report)}


def summary(report: Report) -> list[str]:
    """A run in some words."""
    replayed = report.replay
    words = [f"{report.seconds / 60.0:.1f} min, {report.measures} measures, {sum(report.faults.values())} faults"]
    if replayed:
        words.append(f"{replayed['measures']} measures replayed, {replayed['different']} differ")
    return words


def tell_lines(facts: Facts) -> None:
    """Its summary."""
    console = Console(highlight=False)
    for words in facts["summary"]:
        console.print(words, soft_wrap=True, markup=False)


def tell_campaign(facts: Facts) -> None:
    """All runs, a line each, and what went wrong."""
    console = Console(highlight=False)
    for words in lines_of(facts):
        console.print(words, soft_wrap=True, markup=False)
    _tell_end(facts, console)


def tell_run(facts: Facts) -> None:
    """One run, a little longer."""
    console = Console(highlight=False)
    lines = []
    if "seconds" in facts:
        grown, replay = facts["memory_growth_mb"], facts["replay"]
        lines += [
            f"{facts['seconds'] / 3600.0:.2f} h of the show, {facts['measures']} measures, "
            f"{sum(facts['events'].values())} events, {sum(facts['faults'].values())} faults; {facts['skipped']} ticks "
            "left out in stalls",
            "memory: " + ("not long enough to say" if grown is None else f"within {grown:.1f} MB after the beginning"),
        ]
        if replay:
            lines.append(
                f"replay: {replay['measures']} measures compared, {replay['different']} differ (the whole of it, and "
                f"{replay['stretches']} stretches from snapshots)"
            )
    for words in lines:
        console.print(words, soft_wrap=True, markup=False)
    for words in problem_lines(facts, ""):
        console.print(words, style="red", soft_wrap=True, markup=False)
    _tell_end(facts, console)


def _tell_end(facts: dict[str, Any], console: Console) -> None:
    if "folder" in facts:
        console.print(f"journals: {facts['folder']}", soft_wrap=True, markup=False)
    console.print("[green]nothing went wrong[/]" if facts["ok"] else "[red]this must not happen[/]")
