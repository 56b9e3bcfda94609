"""The table of motion formats. All that lists formats, or chooses one, asks here.

A format that is no part of the program's core is the value `FORMAT` of a module. It is found by an entry point of the
group `live.motion_formats`, or as the module `motion_format` of a bridge. Nothing imports it by name.
"""

import hashlib
import importlib
import importlib.metadata
import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from live.base.errors import PersonError
from live.motion.clip import Clip
from live.motion.formats.amass import AMASS
from live.motion.formats.bvh_reader import BVH
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_reader import GLTF
from live.motion.formats.motion_format import MotionFile, MotionFormat, Reader
from live.motion.formats.source_motion import SourceMotion
from live.motion.formats.ways import WAYS


def _refusal(problem: str, remedy: str) -> Reader:
    def read(file: MotionFile) -> SourceMotion:
        raise MotionFileError(file.name, None, problem, remedy)

    return read


_FBX_REMEDY: Final = "open it in Blender (File, Import, FBX) and export glTF 2.0 (.glb) with its animation"
_MARKER_REMEDY: Final = "solve the markers onto a skeleton in the capture program and export BVH"
_REFUSED: Final = (
    MotionFormat(
        "FBX",
        (".fbx",),
        _refusal("FBX files are not read", _FBX_REMEDY),
        "refused; Blender makes glTF of it",
        begins=(b"Kaydara FBX Binary",),
        readable=False,
    ),
    MotionFormat(
        "C3D",
        (".c3d",),
        _refusal("C3D files hold markers and no skeleton", _MARKER_REMEDY),
        "refused: it holds markers and no skeleton",
        begins=(b"\2\x50", b"\3\x50", b"\4\x50", b"\5\x50"),
        readable=False,
    ),
)
GROUP: Final = "live.motion_formats"
"""Group of the entry points."""
BRIDGES: Final = "live.bridges"
"""Package whose packages may have a module `motion_format`."""
_HEAD: Final = 64
"""Bytes of a file in which its beginning is looked for."""


@dataclass(frozen=True, slots=True)
class InstalledFormats:
    """The formats of this program: those of its core, then the others in the order of their modules' names."""

    formats: tuple[MotionFormat, ...]
    left_out: Mapping[str, str]
    """By a module's name, why it was left out."""
    code: bytes
    """Digest of the code of the formats outside the core, for caches of what they read."""


@cache
def installed_formats() -> InstalledFormats:
    """Find and import the formats. A module that is gone, or fails, is left out."""
    formats, left_out, code = [BVH, GLTF, AMASS, WAYS, *_REFUSED], {}, hashlib.sha256()
    for name in _modules():
        try:
            module = importlib.import_module(name)
            if not isinstance(module.FORMAT, MotionFormat):
                raise TypeError("FORMAT is no motion format")
        except Exception as error:  # of another author's module
            left_out[name] = f"{type(error).__name__}: {error}"
        else:
            formats.append(module.FORMAT)
            for source in sorted(Path(str(module.__file__)).parent.glob("*.py")):
                code.update(source.read_bytes())
    return InstalledFormats(tuple(formats), left_out, code.digest())


def _modules() -> list[str]:
    """Return the names of the modules with a format."""
    bridges = importlib.util.find_spec(BRIDGES)
    folders = [] if bridges is None else bridges.submodule_search_locations or []
    own = [path.parent.name for folder in folders for path in Path(folder).glob("*/motion_format.py")]
    others = importlib.metadata.entry_points(group=GROUP)
    return sorted({f"{BRIDGES}.{name}.motion_format" for name in own} | {each.module for each in others})


def format_of(path: Path, data: bytes) -> MotionFormat:
    """Return the format of a file, by its first bytes, then by its suffix; MotionFileError if it is none of them."""
    start = data[:_HEAD].lstrip(b"\xef\xbb\xbf \t\r\n").upper()
    suffix, formats = path.suffix.lower(), installed_formats().formats
    found = [one for one in formats if start.startswith(tuple(begin.upper() for begin in one.begins))]
    found += [one for one in formats if suffix in one.suffixes or suffix in one.companions.values()]
    if not found:
        problem = f"no reader for {f'{suffix} files' if suffix else 'such a file'} is installed"
        raise MotionFileError(str(path), None, problem, f"there are {_readers_text()}")
    return found[0]


def _readers_text() -> str:
    """Return the formats with a reader and their suffixes, and what was left out."""
    installed = installed_formats()
    words = [f"{one.name} ({', '.join(one.suffixes)})" for one in installed.formats if one.readable]
    return ", ".join(words + [f"but not {name} ({why})" for name, why in installed.left_out.items()])


def format_by_suffix(path: Path) -> MotionFormat | None:
    """Return the format that a file's suffix names; None if there is none."""
    return next((one for one in installed_formats().formats if path.suffix.lower() in one.suffixes), None)


def companion_suffix(path: Path) -> str | None:
    """Return the suffix of the files in the same folder that the file may be read with; None if it stands alone."""
    named = format_by_suffix(path)
    return None if named is None else named.companions.get(path.suffix.lower())


def readable_suffixes() -> tuple[str, ...]:
    """Return the suffixes of all files that can be read."""
    return tuple(suffix for one in installed_formats().formats if one.readable for suffix in one.suffixes)


def is_readable_name(path: Path) -> bool:
    """Whether a file's suffix is that of a format with a reader."""
    return path.suffix.lower() in readable_suffixes()


def check_written_name(path: Path, option: str, example: str) -> None:
    """Raise PersonError unless the suffix of a file to be written is that of a format with a writer.

    `option`: its option on the command line; `example`: a suffix for the remedy.
    """
    suffixes = [suffix for one in installed_formats().formats for suffix in one.written]
    if path.suffix.lower() not in suffixes:
        words = f"{option} {path}: a name that ends in {', '.join(suffixes)} expected"
        raise PersonError(words, f"{option} {path.stem}{example}")


def stage_suffixes() -> tuple[str, ...]:
    """Return the suffixes of files that hold the motion of all dancers of a show."""
    return tuple(suffix for one in installed_formats().formats for suffix in one.stage_suffixes)


def stage_format(suffix: str) -> MotionFormat | None:
    """Return the format that writes all dancers of a show into files with this suffix; None if there is none."""
    return next((one for one in installed_formats().formats if suffix.lower() in one.stage_suffixes), None)


def encode_motion(clip: Clip, path: Path) -> bytes:
    """Return the contents of the file `path` with this clip; its name is checked already."""
    formats, suffix = installed_formats().formats, path.suffix.lower()
    return next(one.write(clip) for one in formats if one.write is not None and suffix in one.written)
