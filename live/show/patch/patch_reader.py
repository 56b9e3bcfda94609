"""Reader for patches: from a TOML file, or a folder with show.toml, to a frozen Patch.

Tables of several files are merged. Errors name file, line, field and the allowed values.
"""

import contextlib
from pathlib import Path
from typing import Any, Final

from live.base.custom_pass import NAME, PASSES
from live.base.errors import PersonError
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import MAIN_FILE, PatchError, gestures_path, is_file, learned_path
from live.show.patch.toml_model import (
    BridgeTables,
    TomlSources,
    key_text,
    parse_model,
    parse_text,
    read_text,
    validate_sources,
)
from live.show.patch_checks.patch_check import PATCH_CHECKS

FOLDERS: Final = ("formations", "looks", "score")
"""Folders next to show.toml with further TOML files of the patch, in reading order."""
CUSTOM_PASS_FOLDER: Final = "passes"
"""The folder next to a patch with its custom passes: NAME.glsl."""
MAX_FILES: Final = 256
MAX_PATCH_BYTES: Final = 16_000_000


def read_patch(path: Path, tables: BridgeTables = ()) -> Patch:
    """Read the patch in `path`; PatchError with file, line, field and what is allowed."""
    return read_sources(path, tables)[0]


def read_sources(path: Path, tables: BridgeTables = ()) -> tuple[Patch, TomlSources]:
    """Read the patch in `path`, for show.toml with its folders; return also the source of each key."""
    try:
        sources = TomlSources([parse_text(read_text(file, "patch"), str(file), "patch") for file in patch_files(path)])
        add_custom_passes(sources.data, path)
        add_gesture_files(sources, path)
        return validate_sources(sources, Patch, "patch", PATCH_CHECKS, tables), sources
    except PersonError as error:
        raise PatchError(error.message, error.remedy, error.key_path, error.faults) from None


def add_gesture_files(sources: TomlSources, path: Path) -> None:
    """Insert the poses of the files of gestures that a patch names; PatchError with file, line and field."""
    if not isinstance(sources.data.get("gesture"), list):
        return
    from live.show.patch.gesture_files import add_gesture_poses  # few patches need it

    try:
        add_gesture_poses(sources.data, path)
    except PersonError as error:
        where = f"{sources.location_text(error.key_path)}: {key_text(error.key_path)}"
        raise PatchError(f"{where}: {error.message}", error.remedy, error.key_path) from None


def custom_pass_files(path: Path) -> list[Path]:
    """Return the custom pass files next to the patch in `path`."""
    try:
        return sorted((path.parent / CUSTOM_PASS_FOLDER).glob("*.glsl"))[:MAX_FILES]
    except OSError:
        return []


def add_custom_passes(data: dict[str, Any], path: Path) -> None:
    """Insert the sources of the custom passes that a patch names; a missing file is reported later, with the name."""
    table = data.get("picture")
    named = table.get("passes") if isinstance(table, dict) else None
    if not isinstance(table, dict) or not isinstance(named, list) or "own" in table:
        return
    found = []
    for name in named:
        if not isinstance(name, str) or name in PASSES or NAME.fullmatch(name) is None:
            continue
        file = path.parent / CUSTOM_PASS_FOLDER / f"{name}.glsl"
        if is_file(file):
            found.append({"name": name, "source": read_text(file, "pass")})
    if found:
        table["own"] = found


def patch_files(path: Path) -> list[Path]:
    """Return the files of a patch: the main one, learned MIDI and gestures, then for show.toml those of FOLDERS,
    sorted by name.

    PatchError, before anything is read, if they are too many or too large.
    """
    files = [path, *(file for file in (learned_path(path), gestures_path(path)) if is_file(file))]
    if path.name != MAIN_FILE:
        return files
    for folder in FOLDERS:
        with contextlib.suppress(OSError):  # it may have been removed meanwhile
            more = sorted(file for file in (path.parent / folder).glob("*.toml") if not file.name.startswith("."))
            files += [file for file in more if is_file(file)]
    if len(files) > MAX_FILES:
        raise PatchError(f"{path.parent}: {len(files)} files; a patch has at most {MAX_FILES}")
    size = 0
    for file in files:
        with contextlib.suppress(OSError):
            size += file.stat().st_size
    if size > MAX_PATCH_BYTES:
        raise PatchError(f"{path.parent}: {size} bytes in {len(files)} files; a patch has at most {MAX_PATCH_BYTES}")
    return files


def parse_patch(text: str, file: str, tables: BridgeTables = ()) -> Patch:
    """Parse the patch in `text`; `file` is its name in errors."""
    try:
        return parse_model(text, file, Patch, "patch", PATCH_CHECKS, tables)
    except PersonError as error:
        raise PatchError(error.message, error.remedy, error.key_path, error.faults) from None
