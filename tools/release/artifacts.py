"""Files of a release: what has to be in them, their checksums, and the list of parts (SBOM, CycloneDX)."""

import datetime
import hashlib
import json
import re
import tarfile
import uuid
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from packaging.metadata import Metadata

from live.base.errors import PersonError

WHEEL_LIMIT: Final = 60_000_000
"""Bytes of a wheel at most, well below the 100 MB of the package index."""
SUMS: Final = "SHA256SUMS"

_LEFT_OUT: Final = re.compile(r"live/bridges/(.+/)?test_[^/]*\.py")
"""Files of `live/` that the wheel leaves out, as in pyproject.toml."""
_MADE: Final = ("live/site/",)
"""Folders that are built for a release and that git does not track."""
SITE: Final = frozenset(f"live/site/{name}" for name in ("index.html", "search.html", "searchindex.js"))
"""Files of the documentation that have to be there."""


def wheel_files(tracked: Iterable[str]) -> set[str]:
    """Return what the wheel has to hold of the files that git tracks, under its own paths."""
    kept = {name for name in tracked if name.startswith("live/") and not _LEFT_OUT.fullmatch(name)}
    return kept | {f"live/{name}" for name in tracked if name.startswith("patches/")}


def list_wheel(path: Path) -> set[str]:
    """Return the files of a wheel without its metadata folder."""
    with zipfile.ZipFile(path) as wheel:
        return {name for name in wheel.namelist() if not name.partition("/")[0].endswith(".dist-info")}


def list_sdist(path: Path) -> set[str]:
    """Return the files of an sdist without the folder that they are in, and without its metadata."""
    with tarfile.open(path) as sdist:
        return {name.partition("/")[2] for name in sdist.getnames()} - {"PKG-INFO", ""}


def check_files(path: Path, wanted: set[str], found: set[str]) -> None:
    """PersonError if files, or those of the documentation, are missing, or some are foreign."""
    wanted = wanted | SITE
    found = {name for name in found if name in wanted or not name.startswith(_MADE)}
    for what, names in (("lacks", wanted - found), ("has foreign files", found - wanted)):
        if names:
            shown = ", ".join(sorted(names)[:5])
            raise PersonError(
                f"{path.name} {what}: {shown}{f' and {len(names) - 5} more' if len(names) > 5 else ''}",
                "look at [tool.hatch.build] in pyproject.toml and at .gitignore",
            )


def check_metadata(path: Path, version: str) -> None:
    """PersonError if the metadata of a wheel or sdist breaks the rules of the index, or names another version."""
    if path.suffix == ".whl":
        with zipfile.ZipFile(path) as wheel:
            (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
            data = wheel.read(name)
    else:
        with tarfile.open(path) as sdist:
            member = sdist.extractfile(f"{path.name.removesuffix('.tar.gz')}/PKG-INFO")
            data = b"" if member is None else member.read()
    try:
        metadata = Metadata.from_email(data, validate=True)
    except ExceptionGroup as group:
        faults = "; ".join(str(error) for error in group.exceptions)
        raise PersonError(f"{path.name}: {faults}", "look at [project] in pyproject.toml") from None
    if str(metadata.version) != version:
        raise PersonError(f"{path.name}: its metadata is of version {metadata.version}, not {version}")


def check_wheel_size(path: Path) -> None:
    """PersonError if a wheel is too large."""
    size = path.stat().st_size
    if size > WHEEL_LIMIT:
        raise PersonError(f"{path.name}: {size / 1e6:.1f} MB", f"a wheel has {WHEEL_LIMIT / 1e6:.0f} MB at most")


def write_sums(folder: Path) -> Path:
    """Write the checksums of all files of a folder in the form of `sha256sum`; return the file."""
    sums = folder / SUMS
    paths = sorted(path for path in folder.iterdir() if path.is_file() and path != sums and path.name[0] != ".")
    lines = []
    for path in paths:
        with path.open("rb") as file:
            lines.append(f"{hashlib.file_digest(file, 'sha256').hexdigest()}  {path.name}\n")
    sums.write_text("".join(lines), encoding="ascii")
    return sums


def steady_sbom(text: str, epoch: int) -> dict[str, Any]:
    """Return a CycloneDX document as uv writes it, with a serial number and a time that are the same each time."""
    sbom: dict[str, Any] = json.loads(text)
    if sbom.get("bomFormat") != "CycloneDX" or not sbom.get("components"):
        raise PersonError("uv export wrote no list of parts (CycloneDX)", "is it the uv of tools/uv-requirements.txt?")
    sbom["serialNumber"] = ""
    sbom["metadata"]["timestamp"] = datetime.datetime.fromtimestamp(epoch, datetime.UTC).isoformat()
    content = json.dumps(sbom, sort_keys=True)
    sbom["serialNumber"] = uuid.uuid5(uuid.NAMESPACE_URL, content).urn
    return sbom


def sbom_packages(sbom: dict[str, Any]) -> dict[str, str]:
    """Return name and version of all packages of a list of parts; of several versions the first."""
    found: dict[str, str] = {}
    for component in sbom["components"]:
        found.setdefault(str(component["name"]), str(component["version"]))
    return found
