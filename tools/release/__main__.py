"""Make a release into dist/: `make release VERSION=0.2.0`, with ARGS of these.

Without --tag the files that name the version stay changed and nothing is committed. Nothing is ever pushed. Dates are
those of SOURCE_DATE_EPOCH, else of the last commit, so that the same commit gives the same files, compiled kernels
excepted.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from live.base.errors import PersonError  # noqa: E402
from tools.release import artifacts, licences, version  # noqa: E402

EXTRAS: Final = ("--extra=link", "--extra=fast", "--extra=nodes", "--extra=usd")
"""Extras of a show, whose packages are listed with those that it always has."""
NAME: Final = "choreographics_live"


def ask(*command: str) -> str:
    """Return what a command of the checkout prints; PersonError with its message if it fails."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise PersonError(f"{' '.join(command)}: {done.stderr.strip() or done.stdout.strip() or done.returncode}")
    return done.stdout


def uv() -> str:
    """Return the uv that tools/setup.sh installed."""
    return str(Path(sys.executable).with_name("uv"))


def source_date() -> int:
    """Return seconds since 1970 of this release."""
    told = os.environ.get("SOURCE_DATE_EPOCH") or ask("git", "log", "-1", "--format=%ct").strip()
    if not told.isdecimal():
        raise PersonError(f"SOURCE_DATE_EPOCH={told}: not a number of seconds", "for instance $(date +%s)")
    return int(told)


def check_start(asked: argparse.Namespace) -> None:
    """PersonError unless a release may begin."""
    version.check_version(asked.version, version.read_version(ROOT))
    version.unreleased_entries((ROOT / version.CHANGELOG).read_text(encoding="utf-8"))
    changed = ask("git", "status", "--porcelain").splitlines()
    if changed:
        raise PersonError(
            f"{len(changed)} files are not committed, {changed[0][3:]} among them", "commit or restore them"
        )
    branch = ask("git", "branch", "--show-current").strip()
    if branch != "main" and not asked.anyway:
        raise PersonError(f"on branch {branch or '(none)'}, not main", 'ARGS="--anyway" releases from here')
    if asked.tag and ask("git", "tag", "--list", f"v{asked.version}"):
        raise PersonError(f"the tag v{asked.version} is there already", "choose another version")
    ask(uv(), "lock", "--check")


def set_version(asked: argparse.Namespace) -> None:
    """Write the version and the dated changelog."""
    version.set_version(ROOT, asked.version)
    path = ROOT / version.CHANGELOG
    dated = version.date_changelog(path.read_text(encoding="utf-8"), asked.version, source_date())
    path.write_text(dated, encoding="utf-8")
    ask(uv(), "lock", "--check")


def build(asked: argparse.Namespace) -> None:
    """Build the documentation, the sdist, the wheel and the wheel of kernels."""
    dist = ROOT / "dist"
    for old in dist.glob("choreographics*"):
        old.unlink()
    environment = {**os.environ, "SOURCE_DATE_EPOCH": str(source_date())}
    packages = [uv(), "build", "--out-dir", str(dist)]
    for command in (["make", "docs"], packages, [sys.executable, "tools/build_kernel_wheel.py"]):
        if subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode:
            raise PersonError(f"{' '.join(command)} failed; its messages above say why")


def check(asked: argparse.Namespace) -> None:
    """PersonError if a built file is incomplete, foreign, too large, or wrongly described."""
    dist, tracked = ROOT / "dist", ask("git", "ls-files").splitlines()
    wheel, sdist = dist / f"{NAME}-{asked.version}-py3-none-any.whl", dist / f"{NAME}-{asked.version}.tar.gz"
    (kernels,) = dist.glob(f"{NAME}_kernels-{asked.version}-*.whl")
    artifacts.check_files(wheel, artifacts.wheel_files(tracked), artifacts.list_wheel(wheel))
    artifacts.check_files(sdist, set(tracked), artifacts.list_sdist(sdist))
    for path in (wheel, sdist, kernels):
        artifacts.check_metadata(path, asked.version)
    for path in (wheel, kernels):
        artifacts.check_wheel_size(path)


def write_lists(asked: argparse.Namespace) -> None:
    """Write the list of parts, the licences, and last the checksums."""
    dist = ROOT / "dist"
    exported = ask(uv(), "export", "-q", "--frozen", "--no-dev", *EXTRAS, "--format", "cyclonedx1.5")
    sbom = artifacts.steady_sbom(exported, source_date())
    found = licences.find_licences(artifacts.sbom_packages(sbom), licences.ask_pip_licenses(Path(sys.executable)))
    stem = f"choreographics-live-{asked.version}"
    (dist / f"{stem}.cdx.json").write_text(json.dumps(sbom, indent=1) + "\n", encoding="utf-8")
    (dist / f"{stem}-licences.md").write_text(licences.licence_report(asked.version, found), encoding="utf-8")
    artifacts.write_sums(dist)


def commit(asked: argparse.Namespace) -> None:
    """Commit the changed files and tag the commit, if that was asked for."""
    if asked.tag:
        ask("git", "commit", "--quiet", "-m", f"Version {asked.version}", "--", *version.CHANGED)
        ask("git", "tag", "--annotate", f"v{asked.version}", "-m", f"ChoreoGraphics Live {asked.version}")


Step = Callable[[argparse.Namespace], None]
STEPS: Final[tuple[tuple[str, Step], ...]] = (
    (f"set the version in {', '.join(version.CHANGED)}", set_version),
    ("build documentation, sdist, wheel and the wheel of kernels into dist/", build),
    (f"check them: all files and no others, metadata, {artifacts.WHEEL_LIMIT // 1_000_000} MB a wheel at most", check),
    (f"write the list of parts (CycloneDX), the licences and {artifacts.SUMS}", write_lists),
    ("with --tag: commit and tag", commit),
)


def release(asked: argparse.Namespace) -> None:
    """Do or print the steps; what was changed in the checkout is restored if one fails."""
    check_start(asked)
    for number, (words, step) in enumerate(STEPS, 1):
        print(f"{number}. {words}", flush=True)
        if asked.dry_run:
            continue
        try:
            step(asked)
        except BaseException:
            ask("git", "checkout", "--quiet", "HEAD", "--", *version.CHANGED)
            raise
    if asked.dry_run:
        print("Nothing was changed.")
    elif asked.tag:
        print(f"Version {asked.version} is in dist/, committed and tagged. Publish: git push --follow-tags")
    else:
        print(f"Version {asked.version} is in dist/; {', '.join(version.CHANGED)} are changed, not committed.")


def main() -> int:
    """Release; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="make release", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("version", help="the new version: VERSION=0.2.0")
    parser.add_argument("--dry-run", action="store_true", help="check, say what would be done, and change nothing")
    parser.add_argument("--anyway", action="store_true", help="also from a branch that is not main")
    parser.add_argument("--tag", action="store_true", help="commit and tag at the end")
    try:
        release(parser.parse_args())
    except PersonError as error:
        print(f"release: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
