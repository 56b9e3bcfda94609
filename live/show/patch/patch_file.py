"""Reading a patch: from a TOML file, or a folder with show.toml, to a frozen Patch, with errors that name the line."""

import contextlib
from pathlib import Path
from typing import Any, Final

from live.base.custom_pass import NAME
from live.base.errors import PersonError
from live.base.stage_snapshot import PASSES
from live.show.long_patches import validated
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import MAIN_FILE, PATCHES, PatchError, is_file, learned_path
from live.show.patch.toml_file import model_of, parse_model, read_text
from live.show.patch.toml_sources import TomlSources, parse_text

FOLDERS: Final = ("formations", "looks", "score")
"""Folders beside show.toml whose TOML files belong to the patch, in the order in which they are read."""
OWN_PASSES: Final = "passes"
"""The folder beside a patch with its own passes: NAME.glsl."""
MOST_FILES: Final = 256
MOST_BYTES: Final = 16_000_000


def find_beside(name: str, patch_path: Path) -> Path | None:
    """A file or folder that a patch names: in the patch's folder first, then in the project's patches."""
    for folder in (patch_path.parent, PATCHES):
        with contextlib.suppress(OSError, ValueError):  # a name that no file can have
            if (folder / name).exists():
                return folder / name
    return None


def read_patch(path: Path) -> Patch:
    """The patch in `path`; PatchError says what is wrong, where, and what is allowed."""
    return read_sources(path)[0]


def read_sources(path: Path) -> tuple[Patch, TomlSources]:
    """The patch in `path` with, for a folder's show.toml, all that belongs to it; and where each key of it stands."""
    try:
        sources = TomlSources([parse_text(read_text(file, "patch"), str(file), "patch") for file in patch_files(path)])
        _add_own_passes(sources.data, path)
        return model_of(sources, Patch, "patch", validated), sources
    except PersonError as error:
        raise PatchError(error.message, error.remedy, error.place) from None


def own_pass_files(path: Path) -> list[Path]:
    """The files of own passes beside the patch in `path`."""
    try:
        return sorted((path.parent / OWN_PASSES).glob("*.glsl"))[:MOST_FILES]
    except OSError:
        return []


def _add_own_passes(data: dict[str, Any], path: Path) -> None:
    """Put the texts of own passes that a patch names into it; a file that is not there is told of with the name."""
    table = data.get("picture")
    named = table.get("passes") if isinstance(table, dict) else None
    if not isinstance(table, dict) or not isinstance(named, list) or "own" in table:
        return
    found = []
    for name in named:
        if not isinstance(name, str) or name in PASSES or NAME.fullmatch(name) is None:
            continue
        file = path.parent / OWN_PASSES / f"{name}.glsl"
        if is_file(file):
            found.append({"name": name, "source": read_text(file, "pass")})
    if found:
        table["own"] = found


def patch_files(path: Path) -> list[Path]:
    """The files of a patch, the main one first: show.toml, then what was learned, then those of its FOLDERS in the
    order of their names.

    PatchError if they are too many or too large: nothing is read then.
    """
    files = [path, learned_path(path)] if is_file(learned_path(path)) else [path]
    if path.name != MAIN_FILE:
        return files
    for folder in FOLDERS:
        with contextlib.suppress(OSError):  # it has just gone
            more = sorted(file for file in (path.parent / folder).glob("*.toml") if not file.name.startswith("."))
            files += [file for file in more if is_file(file)]
    if len(files) > MOST_FILES:
        raise PatchError(f"{path.parent}: {len(files)} files; a patch has at most {MOST_FILES}")
    size = 0
    for file in files:
        with contextlib.suppress(OSError):
            size += file.stat().st_size
    if size > MOST_BYTES:
        raise PatchError(f"{path.parent}: {size} bytes in {len(files)} files; a patch has at most {MOST_BYTES}")
    return files


def parse_patch(text: str, file: str) -> Patch:
    """The patch written in `text`; `file` is named in errors."""
    try:
        return parse_model(text, file, Patch, "patch")
    except PersonError as error:
        raise PatchError(error.message, error.remedy, error.place) from None
