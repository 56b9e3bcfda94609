"""Reader for motion files of all supported formats: BVH, ASF/AMC, glTF, GLB, VRM, AMASS npz."""

from pathlib import Path
from typing import Final

from live.motion.formats.acclaim_motion import parse_amc
from live.motion.formats.acclaim_skeleton import parse_asf
from live.motion.formats.amass import parse_amass
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.gltf_reader import parse_gltf
from live.motion.formats.source_motion import SourceMotion, UpAxis

MAX_BYTES: Final = 256_000_000
MOTION_SUFFIXES: Final = (".bvh", ".amc", ".glb", ".gltf", ".vrm", ".vrma", ".npz")
"""Suffixes of the files that `read_motion` reads."""
_MARKER_REMEDY: Final = "solve the markers onto a skeleton in the capture program and export BVH"
_FBX_REMEDY: Final = "open it in Blender (File, Import, FBX) and export glTF 2.0 (.glb) with its animation"


def read_motion(path: Path, *, skeleton: Path | None = None, up: UpAxis | None = None) -> SourceMotion:
    """Read the motion in a file; the format follows from its first bytes, then from its suffix.

    `skeleton` is the .asf file of an .amc file (default: the one next to it with its name or the beginning of it, such
    as 49.asf for 49_10.amc, or the only one). `up` is the axis that points up, if it was given. MotionFileError with
    file, line, problem and remedy if the file cannot be used, is missing, or is longer than 256 MB.
    """
    data = read_bytes(path)
    match _format_of(data, path):
        case "glTF":
            return parse_gltf(data, str(path), lambda name: read_bytes(path.parent / name))
        case "npz":
            return parse_amass(data, str(path))
        case "AMC":
            asf = skeleton or find_skeleton(path)
            return parse_amc(data, str(path), parse_asf(read_bytes(asf), str(asf)))
        case _:
            return bvh_to_source_motion(parse_bvh(data, str(path)), up)


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
        names = sorted(p.name for p in folder.glob("*") if p.suffix.lower() in MOTION_SUFFIXES)
    except (OSError, ValueError):
        names = []
    return ", ".join(names[:12]) or "no motion files in that folder"


def _format_of(data: bytes, path: Path) -> str:
    ending = path.suffix.lower()
    start = data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    if data[:4] == b"glTF" or ending in (".gltf", ".glb", ".vrm", ".vrma"):
        return "glTF"
    if data[:18] == b"Kaydara FBX Binary" or ending == ".fbx":
        raise MotionFileError(str(path), None, "FBX files are not read", _FBX_REMEDY)
    if (ending == ".c3d" and start[:9].upper() != b"HIERARCHY") or (data[1:2] == b"\x50" and data[:1] in b"\2\3\4\5"):
        raise MotionFileError(str(path), None, "C3D files hold markers and no skeleton", _MARKER_REMEDY)
    if data[:4] == b"PK\3\4" or ending == ".npz":
        return "npz"
    if ending == ".asf":
        raise MotionFileError(str(path), None, "a skeleton without motion", "its .amc file expected")
    if start[:9].upper() != b"HIERARCHY" and (ending == ".amc" or start[:1] in (b":", b"#")):
        return "AMC"
    return "BVH"


def find_skeleton(path: Path) -> Path:
    """Return the .asf file next to an .amc file that is its skeleton; MotionFileError if there is none or several."""
    there = sorted(p for p in path.parent.glob("*") if p.suffix.lower() == ".asf")
    fitting = [p for p in there if path.stem == p.stem] or [p for p in there if path.stem.split("_")[0] == p.stem]
    if len(fitting or there) != 1:
        found = ", ".join(p.name for p in there[:12]) or "no .asf file"
        raise MotionFileError(
            str(path), None, f"its skeleton is not known; next to it: {found}", "give it: --skeleton FILE.asf"
        )
    return (fitting or there)[0]
