"""Test campaign: many runs in sequence, each of a patch and a seed; resumable.

A state file in the folder of the campaign holds the result of each run. It is replaced atomically after each run. An
exception of the test harness counts as a failed run, with the exception in its report; the campaign then continues.
"""

import json
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from live.base.errors import PersonError
from live.rehearse.failure import Failure

STATE_FILE: Final = "campaign.json"
"""The state file, in the campaign's folder."""
MAX_LISTED_PROBLEMS: Final = 8
"""Maximum number of problems listed for one run; the JSON report has all that were kept."""

Facts = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Job:
    """One run of a campaign."""

    name: str
    """Patch and seed, usable as a folder name."""
    run: Callable[[Path], Facts]
    """Runs the job with its files in that folder; the facts have "ok", "problems" and "summary" (lines for people)."""


class Campaign:
    """Runs jobs. Thread: one."""

    def __init__(self, folder: Path, plan: Facts, report_progress: Callable[[str], None] = lambda words: None) -> None:
        """`plan`: the options, in plain values. Raises PersonError if `folder` holds the state of another plan."""
        self._folder, self._plan, self._report_progress = folder, plan, report_progress
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / STATE_FILE
        self.done: dict[str, Facts] = self._read()
        """Results of the completed runs, by name."""

    def run(self, jobs: Sequence[Job]) -> Facts:
        """Run the jobs that are not done yet; return the report of all."""
        for number, job in enumerate(jobs, 1):
            if job.name in self.done:
                self._report_progress(f"{job.name}: already done")
                continue
            self._report_progress(f"{job.name} ({number} of {len(jobs)})")
            self.done[job.name] = run_safely(job, self._folder / job.name)
            self._write()
        return self.report([job.name for job in jobs])

    def report(self, names: Sequence[str]) -> Facts:
        """Return the report of these runs, as far as they are done."""
        runs = {name: self.done[name] for name in names if name in self.done}
        missing = [name for name in names if name not in runs]
        ok = not missing and all(facts.get("ok") for facts in runs.values())
        return {"ok": ok, "plan": self._plan, "runs": runs, "not_run": missing}

    def _read(self) -> dict[str, Facts]:
        try:
            state = json.loads(self._path.read_text(encoding="utf-8"))
            done = dict(state["done"])
            plan = state["plan"]
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, KeyError, TypeError):
            raise PersonError(f"{self._path} is not a campaign state file", "give another --folder") from None
        if plan != json.loads(json.dumps(self._plan)):
            raise PersonError(f"{self._path} belongs to a campaign with other options", "give another --folder")
        return done

    def _write(self) -> None:
        beside = self._path.with_suffix(".new")
        beside.write_text(json.dumps({"plan": self._plan, "done": self.done}, indent=1) + "\n", encoding="utf-8")
        os.replace(beside, self._path)


def run_safely(job: Job, folder: Path) -> Facts:
    """Run a job and return its result. An exception of the test harness becomes a problem in the result."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return job.run(folder)
    except PersonError:
        raise
    except Exception as error:
        failure = Failure.from_exception(error)
        words = f"the harness itself failed: {failure}"
        return {"ok": False, "problems": [words], "count": 1, "failures": [failure.facts()], "summary": []}


def report_lines(report: Facts) -> Iterator[str]:
    """Yield a campaign's report for people: a line for each run, followed by its problems."""
    runs = report["runs"]
    for name, facts in runs.items():
        summary = "; ".join(facts.get("summary", ()))
        yield f"{'ok  ' if facts.get('ok') else 'FAIL'} {name}" + (f": {summary}" if summary else "")
        yield from problem_lines(facts)
    if report["not_run"]:
        yield f"not run: {', '.join(report['not_run'])}"
    good = sum(bool(facts.get("ok")) for facts in runs.values())
    yield f"{good} of {len(runs) + len(report['not_run'])} runs went well"


def problem_lines(facts: Facts, indent: str = "     ") -> Iterator[str]:
    """Yield the first problems of one run, one line each."""
    problems = [" ".join(str(problem).split()) for problem in facts.get("problems", ())]
    problems += [" ".join(str(problem).split()) for problem in facts.get("replay", {}).get("problems", ())]
    for problem in problems[:MAX_LISTED_PROBLEMS]:
        yield indent + problem
    if len(problems) > MAX_LISTED_PROBLEMS:
        yield f"{indent}and {len(problems) - MAX_LISTED_PROBLEMS} more"
