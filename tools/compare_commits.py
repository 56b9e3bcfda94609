"""Does this tree dance as an earlier commit did: its journals replayed here, and the same pictures drawn by both.

    .venv/bin/python tools/compare_commits.py COMMIT [--folder out/compare] [--minutes 4] [--soak-minutes 20]

The earlier commit's code, in a git worktree of its own, plays every built-in patch and four longer soak tests in
virtual time and keeps their journals. This tree replays them and compares the state of every measure; both trees draw
ten pictures of each journal, which must be the same bytes. Exit 1 if anything differs. Journals that are there already
are used again, so a later run compares only.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOAKS = {"contemporary": 21, "score": 22, "partner": 23, "samba": 24}
"""Patches of the longer soak tests, with their seeds."""
PICTURES = 10
"""Pictures of each journal."""


def run_live(tree: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run `live` with the code of `tree`."""
    return subprocess.run(
        [sys.executable, "-m", "live", *arguments],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree)},
        capture_output=True,
        text=True,
        check=False,
    )


def make_worktree(commit: str, folder: Path) -> Path:
    """Check the commit out into a worktree, and compile its kernels."""
    tree = folder / "tree"
    if not tree.exists():
        subprocess.run(["git", "worktree", "add", "--detach", str(tree), commit], cwd=ROOT, check=True)
    run_live(tree, "warm")
    return tree


def make_journals(tree: Path, folder: Path, minutes: float, soak_minutes: float) -> list[Path]:
    """Play what is not played yet with the code of `tree`; return all journals."""
    common = ("--virtual", "--no-replay")
    if not (folder / "patches").exists():
        options = ("--seed", "3", "--minutes", f"{minutes}", "--faults", "4", "--players", "12")
        _play(tree, "--all", *options, *common, "--folder", str(folder / "patches"))
    for patch, seed in SOAKS.items():
        if not (folder / patch).exists():
            options = ("--seed", f"{seed}", "--minutes", f"{soak_minutes}", "--faults", "3", "--players", "24")
            _play(tree, patch, *options, *common, "--folder", str(folder / patch))
    return sorted(path for path in folder.rglob("*.jsonl") if tree not in path.parents)


def _play(tree: Path, *arguments: str) -> None:
    done = run_live(tree, "soak", *arguments)
    if done.returncode != 0:
        raise SystemExit(f"live soak {' '.join(arguments)}: exit {done.returncode}\n{done.stdout}{done.stderr}")


def compare(trees: tuple[Path, Path], journal: Path) -> Iterator[str]:
    """Replay a journal with the second tree and draw it with both; yield what differs."""
    done = run_live(trees[1], "replay", str(journal), "--json")
    try:
        facts = json.loads(done.stdout)
    except ValueError:
        yield f"replay: exit {done.returncode}: {done.stderr.strip()}"
        return
    if facts["measures_different"] or not facts["measures"] or not facts["complete"]:
        yield f"replay: {facts['measures_different']} of {facts['measures']} measures differ"
    every = f"{max(1, facts['measures'] // PICTURES)}"
    sheets = []
    for name, tree in zip(("before", "after"), trees, strict=True):
        sheet = journal.with_name(f"{name}.png")
        drawn = run_live(tree, "contact-sheet", str(journal), "--every", every, "--out", str(sheet))
        if drawn.returncode != 0:
            yield f"pictures {name}: exit {drawn.returncode}: {drawn.stderr.strip()}"
            return
        sheets.append(sheet.read_bytes())
    if sheets[0] != sheets[1]:
        yield f"pictures differ: {journal.with_name('before.png')}, {journal.with_name('after.png')}"


def main() -> int:
    """Compare, print a line for each journal, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", help="the earlier commit")
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "compare", help="journals and pictures")
    parser.add_argument("--minutes", type=float, default=4.0, help="length of each patch")
    parser.add_argument("--soak-minutes", type=float, default=20.0, help="length of each longer soak test")
    wanted = parser.parse_args()
    folder = wanted.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    tree = make_worktree(wanted.commit, folder)
    failed = 0
    for journal in make_journals(tree, folder, wanted.minutes, wanted.soak_minutes):
        faults = list(compare((tree, ROOT), journal))
        failed += bool(faults)
        print(f"{'differs' if faults else 'same   '} {journal.relative_to(folder)}", *faults, sep="\n  ", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    raise SystemExit(main())
