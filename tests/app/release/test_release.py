"""A release of a small checkout of its own, with a uv that builds nothing."""

import shutil
import subprocess

import pytest

from tests.places import ROOT
from tools.release import version

release = pytest.importorskip("tools.release.__main__", reason="license-expression comes with `make test`")

CHANGELOG = "# Changelog\n\n## [Unreleased]\n\n### Added\n- One.\n"
UV = '#!/bin/sh\necho "$*" >>"$0.log"\n[ "$1" = lock ] || { echo "no network" >&2; exit 1; }\n'
"""Its lock is right, and it cannot build."""


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout on the branch main with one commit of 2 January 1970; `git` runs there."""
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    root = tmp_path / "checkout"
    for name in (*version.CHANGED, "Makefile"):
        (root / name).parent.mkdir(exist_ok=True, parents=True)
        shutil.copy(ROOT / name, root / name)
    (root / "CHANGELOG.md").write_text(CHANGELOG)
    (root / "Makefile").write_text("play:\n")
    uv = tmp_path / "uv"
    uv.write_text(UV)
    uv.chmod(0o755)
    monkeypatch.setattr(release, "ROOT", root)
    monkeypatch.setattr(release, "uv", lambda: str(uv))
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "Tester")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "tester@localhost")
        monkeypatch.setenv(f"GIT_{name}_DATE", "@86400 +0000")
    for name in ("GIT_CONFIG_GLOBAL", "GIT_CONFIG_SYSTEM"):
        monkeypatch.setenv(name, "/dev/null")
    for name in ("GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE"):
        monkeypatch.delenv(name, raising=False)
    for command in (["init", "-q", "-b", "main"], ["add", "."], ["commit", "-q", "-m", "first"]):
        git(root, *command)
    return root


def git(root, *command):
    return subprocess.run(["git", *command], cwd=root, capture_output=True, text=True, check=True).stdout


def run(monkeypatch, *arguments):
    monkeypatch.setattr("sys.argv", ["release", *arguments])
    return release.main()


def test_dry_run_says_the_steps_and_changes_nothing(checkout, monkeypatch, capsys):
    assert run(monkeypatch, "99.0.0", "--dry-run") == 0
    told = capsys.readouterr().out
    assert [line[:2] for line in told.splitlines()[:-1]] == [f"{number}." for number in range(1, 6)]
    assert told.endswith("Nothing was changed.\n")
    assert git(checkout, "status", "--porcelain") == ""


@pytest.mark.parametrize(
    ("change", "arguments", "fault"),
    [
        (["checkout", "-q", "-b", "other"], ["99.0.0"], "on branch other, not main"),
        (["tag", "v99.0.0"], ["99.0.0", "--tag"], "the tag v99.0.0 is there already"),
        (["rm", "-q", "--cached", "Makefile"], ["99.0.0"], "2 files are not committed, Makefile among them"),
        (["status"], ["0.0.1"], "not greater"),
    ],
)
def test_release_does_not_begin_where_it_may_not(checkout, monkeypatch, capsys, change, arguments, fault):
    git(checkout, *change)
    assert run(monkeypatch, *arguments) == 2
    assert fault in capsys.readouterr().err


def test_other_branch_releases_when_told(checkout, monkeypatch):
    git(checkout, "checkout", "-q", "-b", "other")
    assert run(monkeypatch, "99.0.0", "--dry-run", "--anyway") == 0


def test_failed_build_restores_the_files(checkout, monkeypatch, capsys):
    assert run(monkeypatch, "99.0.0") == 2
    assert "make docs failed" in capsys.readouterr().err
    assert git(checkout, "status", "--porcelain") == ""
    assert (checkout.parent / "uv.log").read_text().splitlines()[:2] == ["lock --check", "lock --check"]


@pytest.mark.parametrize("tag", [False, True])
def test_release_commits_and_tags_only_when_asked(checkout, monkeypatch, tag):
    kept = [step for step in release.STEPS if step[1] in (release.set_version, release.commit)]
    monkeypatch.setattr(release, "STEPS", kept)
    assert run(monkeypatch, "99.0.0", *["--tag"][: int(tag)]) == 0
    assert version.read_version(checkout) == "99.0.0"
    assert "## [99.0.0] - 1970-01-02\n" in (checkout / "CHANGELOG.md").read_text()
    assert git(checkout, "tag") == ("v99.0.0\n" if tag else "")
    assert len(git(checkout, "log", "--format=%s").splitlines()) == 1 + tag
    assert len(git(checkout, "status", "--porcelain").splitlines()) == (0 if tag else len(version.CHANGED))


def test_date_is_that_of_the_environment_first(checkout, monkeypatch):
    assert release.source_date() == 86400
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "5")
    assert release.source_date() == 5
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "soon")
    with pytest.raises(Exception, match="not a number of seconds"):
        release.source_date()
