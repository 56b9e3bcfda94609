"""Search path for patches, and for the files they name: next to the patch, or the project's own. Cheap to import."""

import contextlib
import difflib
import os
from pathlib import Path
from typing import Final

import platformdirs

import live
from live.base.errors import PersonError

_PACKAGE: Final = Path(live.__file__).resolve().parent
PATCHES: Final = next(
    (folder for folder in (_PACKAGE.parent / "patches", _PACKAGE / "patches") if folder.is_dir()),
    Path("patches"),
)
"""The project's own patches: next to the package in a checkout, inside it when installed."""

MAIN_FILE: Final = "show.toml"
LEARNED_SUFFIX: Final = ".midi"
"""Suffix of the file of learned MIDI mappings: NAME.midi.toml next to NAME.toml."""
GESTURES_SUFFIX: Final = ".gestures"
"""Suffix of the file of learned gestures: NAME.gestures.toml next to NAME.toml."""

DEFAULT_PATCH: Final = PATCHES / "first_show.toml"


class PatchError(PersonError):
    """A patch that cannot be used: for each problem file, line, field, the value and what is allowed."""


def user_settings_folder() -> Path:
    """Return the user's settings folder; `LIVE_CONFIG_DIR` overrides it."""
    return Path(os.environ.get("LIVE_CONFIG_DIR") or platformdirs.user_config_dir("choreographics-live"))


def show_stem(patch: str | None) -> str:
    """Return the name of files that are made from a show: that of its file, or of its folder."""
    if patch is None:
        return "first-show"
    path = Path(patch)
    return path.resolve().parent.name if path.name == MAIN_FILE else path.name.removesuffix(".toml")


def find_patch(name: str | None) -> Path:
    """Return the file of a patch given as a path, a folder with show.toml, or the name of one of the project's own."""
    if name is None:
        return DEFAULT_PATCH
    given = Path(name)
    for path in (given, given / MAIN_FILE, PATCHES / name, PATCHES / name / MAIN_FILE, PATCHES / f"{name}.toml"):
        if is_file(path):
            return path
    if os.path.isdir(name):
        raise PatchError(f"the folder {name!r} holds no show.toml", "put one there, or name a TOML file")
    folders = (path.parent.name for path in PATCHES.glob("*/show.toml"))
    files = (path.stem for path in PATCHES.glob("*.toml") if not path.stem.endswith((LEARNED_SUFFIX, GESTURES_SUFFIX)))
    known = sorted([*files, *folders])
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"{near[0]}, or " if near else ""
    raise PatchError(
        f"there is no patch {name[:200]!r}",
        f"{hint}a TOML file, a folder with show.toml, or one of the project's: {', '.join(known) or 'none'}",
    )


def is_file(path: Path) -> bool:
    """Whether the file exists; False for an invalid name (too long, a zero byte)."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def learned_path(path: Path) -> Path:
    """Return the file of learned MIDI mappings next to the patch in `path`."""
    return path.with_name(f"{path.stem}{LEARNED_SUFFIX}.toml")


def gestures_path(path: Path) -> Path:
    """Return the file of learned gestures next to the patch in `path`."""
    return path.with_name(f"{path.stem}{GESTURES_SUFFIX}.toml")


def find_resource(name: str, patch_path: Path) -> Path | None:
    """Find a file or folder that a patch names: in the patch's folder first, then in the project's patches."""
    for folder in (patch_path.parent, PATCHES):
        with contextlib.suppress(OSError, ValueError):  # invalid file name
            if (folder / name).exists():
                return folder / name
    return None
