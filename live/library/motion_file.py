"""Reader for motion files of all formats in the table, and safe reading of files of bounded size."""

from pathlib import Path
from typing import Final

from live.library.motion_formats import format_of, is_readable_name
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFile
from live.motion.formats.source_motion import SourceMotion, UpAxis

MAX_BYTES: Final = 256_000_000


def read_motion(path: Path, *, skeleton: Path | None = None, up: UpAxis | None = None) -> SourceMotion:
    """Read the motion in a file; the format follows from its first bytes, then from its suffix.

    `skeleton` is the file with its skeleton, for formats that have one (default: one next to it with a fitting name).
    `up` is the axis that points up, if it was given. MotionFileError with file, line, problem and remedy if the file
    cannot be used, is missing, is longer than 256 MB, or has a format without a reader.
    """
    file = MotionFile(path, read_bytes(path), read_bytes, skeleton, up)
    return format_of(path, file.data).read(file)


def read_bytes(path: Path) -> bytes:
    """Return all bytes of a file of at most 256 MB; MotionFileError if that fails."""
    try:
        if path.is_dir():
            raise MotionFileError(str(path), None, "that is a folder", f"name a file in it: {_motion_file_names(path)}")
        if path.exists() and not path.is_file():
            raise MotionFileError(str(path), None, "that is a device or a pipe, not a file", "name a motion file")
        if not path.is_file():
            raise MotionFileError(
                str(path), None, "there is no such file", f"there are: {_motion_file_names(path.parent)}"
            )
        if path.stat().st_size > MAX_BYTES:
            raise MotionFileError(str(path), None, f"more than {MAX_BYTES} bytes", "cut it into pieces")
        data = path.read_bytes()
    except OSError as error:
        raise MotionFileError(
            str(path), None, f"cannot be read: {error.strerror}", "a readable file expected"
        ) from None
    if not data:
        raise MotionFileError(str(path), None, "the file is empty", "copy it or export it again")
    return data


def _motion_file_names(folder: Path) -> str:
    try:
        names = sorted(p.name for p in folder.glob("*") if is_readable_name(p))
    except (OSError, ValueError):
        names = []
    return ", ".join(names[:12]) or "no motion files in that folder"
