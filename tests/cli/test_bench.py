"""`live bench`: format of rows and reports, and unknown benchmarks."""

import ast
import importlib
import json
import os
import re
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from live.base.errors import PersonError
from live.cli import bench as bench_module
from live.cli.bench import Row, bench_names, bench_title, load_bench
from live.cli.main import app
from tests.cli.command import run_live

ROOT = Path(__file__).resolve().parents[2]
SOURCE = '''"""Claps: hands per second.

More about it.
"""

from dataclasses import dataclass
from live.cli.bench import Row

@dataclass
class Clap:
    hands: float

def run(full, shared):
    return [
        Row("claps", Clap(2.0).hands, "hands/s", bar=1.5, sense="at least", peers={"a seal": 1.0}),
        Row("snaps", None, "1/s", bar=3.0, note="no fingers: make hands"),
        Row("full" if full else "quick", 4.0, "ms", bar=3.0),
        Row(str(shared), 1e6, "rows"),
    ]
'''


@pytest.fixture
def bench_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "claps.py").write_text(SOURCE)
    (tmp_path / "_helper.py").write_text("raise SystemExit")
    (tmp_path / "__init__.py").write_text("")
    for function in (bench_names, bench_title, load_bench):  # the commands use the default folder
        monkeypatch.setattr(function, "__defaults__", (tmp_path,))
    return tmp_path


@pytest.mark.parametrize(
    ("value", "bar", "sense", "ok"),
    [
        (2.0, 2.0, "at most", True),
        (2.1, 2.0, "at most", False),
        (2.0, 2.0, "at least", True),
        (1.9, 2.0, "at least", False),
        (None, 2.0, "at most", None),
        (2.0, None, "at most", None),
        (float("nan"), 2.0, "at most", False),
    ],
)
def test_row_is_ok_on_right_side_of_bar(value: float | None, bar: float | None, sense: str, ok: bool | None) -> None:
    assert Row("x", value, "ms", bar, sense).ok is ok  # type: ignore[arg-type]


def test_report_has_specified_format(bench_folder: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["bench", "claps", "--json", "--full", "--shared", str(tmp_path)])
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert list(report) == ["bench", "machine", "rows"]
    assert report["bench"] == "claps"
    assert list(report["machine"]) == ["cpu", "cores", "python", "gl"]
    assert 1 <= report["machine"]["cores"] <= (os.cpu_count() or 1)
    claps, snaps, full, shared = report["rows"]
    assert claps == {
        "name": "claps",
        "value": 2.0,
        "unit": "hands/s",
        "bar": 1.5,
        "sense": "at least",
        "ok": True,
        "peers": {"a seal": 1.0},
        "note": "",
    }
    assert (snaps["value"], snaps["ok"]) == (None, None)
    assert (full["name"], full["ok"]) == ("full", False)
    assert shared["name"] == str(tmp_path)


def test_all_benches_run_without_name(bench_folder: Path) -> None:
    (bench_folder / "bows.py").write_text(SOURCE.replace("Claps", "Bows"))
    done = CliRunner().invoke(app, ["bench", "--json"])
    reports = json.loads(done.stdout)
    assert [report["bench"] for report in reports] == ["bows", "claps"]
    assert reports[0]["rows"][2]["name"] == "quick"


@pytest.mark.long
def test_table_shows_bars_and_peers(bench_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    done = CliRunner().invoke(app, ["bench", "claps"])
    assert "claps: Claps: hands per second." in done.stdout
    row = next(line for line in done.stdout.splitlines() if "hands/s" in line)
    assert "at least 1.5" in row
    assert "ok" in row
    assert "a seal 1" in row
    assert "no data" in done.stdout
    assert "missed" in done.stdout


def test_list_runs_no_bench(bench_folder: Path) -> None:
    (bench_folder / "breaks.py").write_text('"""Breaks when run."""\nraise RuntimeError\n')
    done = CliRunner().invoke(app, ["bench", "--list"])
    assert done.stdout.splitlines() == ["breaks  Breaks when run.", "claps  Claps: hands per second."]


def test_unknown_bench_is_refused_with_known_names(bench_folder: Path) -> None:
    with pytest.raises(PersonError, match="no benchmark is called 'clasp'; there are: claps"):
        load_bench("clasp")


def test_path_is_refused_as_bench_name(bench_folder: Path) -> None:
    with pytest.raises(PersonError):
        load_bench("../cli/claps")
    with pytest.raises(PersonError):
        load_bench("_helper")


@pytest.mark.parametrize("name", ["high-fives", "high_fives"])
def test_bench_name_accepts_hyphens_or_underscores(bench_folder: Path, name: str) -> None:
    (bench_folder / "high_fives.py").write_text(SOURCE)
    assert bench_names() == ["claps", "high-fives"]
    assert bench_title(name) == "Claps: hands per second."
    assert load_bench(name)(False, None)[0].value == 2.0


def test_project_benches_are_documented() -> None:
    assert bench_module.BENCH_FOLDER.is_dir()
    done = run_live("bench", "--list")
    assert done.returncode == 0, done.stderr
    for line in done.stdout.splitlines():
        name, _, title = line.partition("  ")
        assert name in bench_names()
        assert title, f"bench/{name}.py has no docstring"


@pytest.mark.long
def test_absent_peer_says_so_in_its_row_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    """The reading bench, its clock stopped, with and without its peer: in the same rows."""
    run = load_bench("reading")
    monkeypatch.setitem(run.__globals__, "_best", lambda work, repeats: 1.0)
    there = run(False, None)
    monkeypatch.setitem(importlib.import_module("bench._peers").PACKAGES, "pybvh", "a package that nobody has")
    absent = run(False, None)
    assert [row.name for row in absent] == [row.name for row in there]
    compared = [row for row in absent if "pybvh" in row.note]
    assert len(compared) == 2
    for row in compared:
        assert row.value is None
        assert row.as_json()["note"] == "pybvh is not installed: make bench"


def test_bench_extra_has_all_that_benches_import() -> None:
    """Whatever benches import is a package of the project, of its extra `bench`, or of the tests."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    peers = importlib.import_module("bench._peers").PACKAGES
    assert {re.split("[>=;]", one)[0] for one in extras["bench"]} == set(peers)
    tests = [one for one in project["dependency-groups"]["dev"] if isinstance(one, str)]  # not groups within it
    declared = [*project["project"]["dependencies"], *extras["fast"], *tests]
    known = {re.split("[>=;]", one)[0].replace("-", "") for one in declared} | set(peers.values())
    known |= {"PIL"}  # the module of pillow
    imported = set()
    for file in (ROOT / "bench").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
            imported |= {name.partition(".")[0] for name in names}
    assert imported - set(sys.stdlib_module_names) - {"live", "bench", "tests"} <= known
