"""Version of the project: where it stands, and how the next one is set and described in the changelog."""

import datetime
import re
from pathlib import Path
from typing import Final

from packaging.version import InvalidVersion, Version

from live.base.errors import PersonError

PLACES: Final = (
    ("pyproject.toml", re.compile(r'(?m)^(version = ")([^"]+)(")$')),
    ("live/__init__.py", re.compile(r'(?m)^(__version__ = ")([^"]+)(")$')),
    ("uv.lock", re.compile(r'(?m)^(name = "choreographics-live"\nversion = ")([^"]+)(")$')),
)
"""Files that name the version, and the lines: what is before it, it, and what is after."""
CHANGELOG: Final = "CHANGELOG.md"
CHANGED: Final = (*(name for name, _ in PLACES), CHANGELOG)
"""Files that a release changes."""

_UNRELEASED: Final = "## [Unreleased]\n"


def read_version(root: Path) -> str:
    """Return the version of a checkout; PersonError unless all places name the same one."""
    found = {}
    for name, pattern in PLACES:
        lines = pattern.findall((root / name).read_text(encoding="utf-8"))
        if len(lines) != 1:
            raise PersonError(f"{name}: {len(lines)} lines name the version", "exactly one line has to")
        found[name] = lines[0][1]
    if len(set(found.values())) > 1:
        told = ", ".join(f"{name} {version}" for name, version in found.items())
        raise PersonError(f"the files name different versions: {told}", "make them the same")
    return str(found["pyproject.toml"])


def check_version(text: str, current: str) -> Version:
    """Return a new version; PersonError unless it is a final or preliminary one in its normal form, and greater."""
    try:
        version = Version(text)
    except InvalidVersion:
        raise PersonError(f"VERSION={text}: not a version", "for instance VERSION=0.2.0, or 0.2.0rc1") from None
    if str(version) != text or version.local or version.epoch:
        raise PersonError(f"VERSION={text}: not in the form of versions", f"write {version.public}")
    if version <= Version(current):
        raise PersonError(f"VERSION={text}: not greater than {current}", "choose a greater one")
    return version


def set_version(root: Path, version: str) -> None:
    """Write the version into all places."""
    for name, pattern in PLACES:
        path = root / name
        path.write_text(pattern.sub(rf"\g<1>{version}\g<3>", path.read_text(encoding="utf-8")), encoding="utf-8")


def unreleased_entries(changelog: str) -> list[str]:
    """Return the entries (lines that begin with `- `) below Unreleased; PersonError if there are none."""
    _, heading, rest = changelog.partition(_UNRELEASED)
    if not heading:
        raise PersonError(f"{CHANGELOG}: no line `{_UNRELEASED.strip()}`", "put it above the newest version")
    entries = [line for line in re.split(r"(?m)^## ", rest, maxsplit=1)[0].splitlines() if line.startswith("- ")]
    if not entries:
        raise PersonError(f"{CHANGELOG}: nothing stands below [Unreleased]", "say what users will notice")
    return entries


def date_changelog(changelog: str, version: str, epoch: int) -> str:
    """Return the changelog in which the unreleased entries belong to the version, dated by seconds since 1970."""
    unreleased_entries(changelog)
    date = datetime.datetime.fromtimestamp(epoch, datetime.UTC).date()
    return changelog.replace(_UNRELEASED, f"{_UNRELEASED}\n## [{version}] - {date}\n", 1)
