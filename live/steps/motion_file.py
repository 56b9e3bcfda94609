"""Motion files from disk, whatever their format: BVH, ASF/AMC, glTF, GLB, VRM, AMASS npz."""

from pathlib import Path
from typing import Final

from live.motion.amass import parse_amass
from live.motion.bvh import parse_bvh, source_of_bvh
from live.motion.file_error import MotionFileError
from live.motion.gltf import parse_gltf
from live.motion.source_motion import SourceMotion, UpAxis

MAX_BYTES: Final = 256_000_000
MOTION_ENDINGS: Final = (".bvh", ".amc", ".glb", ".gltf", ".vrm", ".vrma", ".npz")
"""Endings of the files that `read_motion` takes."""
_MARKERS: Final = "solve the markers onto a skeleton in the capture program and export BVH"
_CONVERT: Final = "open it in Blender (File, Import, FBX) and export glTF 2.0 (.glb) with its animation"


def read_motion(path: Path, *, skeleton: Path | None = None, up: UpAxis | None = None) -> SourceMotion:
    """The motion in a file; its first bytes decide the format, then its ending.

    `skeleton` is the .asf file of an .amc file (default: the one beside it that has its name or the name's beginning,
    as 49.asf for 49_10.amc, or the only one there is). `up` is the axis that
    points up, if a person has said so. Raises MotionFileError with file, line, problem and remedy for whatever
    cannot be used, also for what is not there, cannot be read, or is longer than 256 MB.
    """
    data = read_bytes(path)
    match _format_of(data, path):
        case "glTF":
            return parse_gltf(data, str(path), lambda name: read_bytes(path.parent / name))
        case "npz":
            return parse_amass(data, str(path))
        case _:
            return source_of_bvh(parse_bvh(data, str(path)), up)


def read_bytes(path: Path) -> bytes:
    """All bytes of a file of at most 256 MB; raises MotionFileError."""
    try:
        if not path.is_file():
            raise MotionFileError(str(path), None, "there is no such file", f"there are: {_beside(path)}")
        if path.stat().st_size > MAX_BYTES:
            raise MotionFileError(str(path), None, f"more than {MAX_BYTES} bytes", "cut it into pieces")
        return path.read_bytes()
    except OSError as error:
        raise MotionFileError(
            str(path), None, f"cannot be read: {error.strerror}", "a readable file expected"
        ) from None


def _beside(path: Path) -> str:
    try:
        names = sorted(p.name for p in path.parent.glob("*") if p.suffix.lower() in MOTION_ENDINGS)
    except (OSError, ValueError):
        names = []
    return ", ".join(names[:12]) or "no motion files in that folder"


def _format_of(data: bytes, path: Path) -> str:
    ending = path.suffix.lower()
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    if data[:4] == b"glTF" or ending in (".gltf", ".glb", ".vrm", ".vrma"):
        return "glTF"
    if data[:18] == b"Kaydara FBX Binary" or ending == ".fbx":
        raise MotionFileError(str(path), None, "FBX files are not read", _CONVERT)
    if (ending == ".c3d" and start[:9].upper() != b"HIERARCHY") or (data[1:2] == b"\x50" and data[:1] in b"\2\3\4\5"):
        raise MotionFileError(str(path), None, "C3D files hold markers and no skeleton", _MARKERS)
    if data[:4] == b"PK\3\4" or ending == ".npz":
        return "npz"
    return "BVH"
