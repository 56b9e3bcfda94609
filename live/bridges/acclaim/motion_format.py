"""The Acclaim format: a motion (.amc) is read with the skeleton (.asf) next to it."""

from pathlib import Path
from typing import Final

from live.bridges.acclaim.acclaim_motion import parse_amc
from live.bridges.acclaim.acclaim_skeleton import parse_asf
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFile, MotionFormat
from live.motion.formats.source_motion import SourceMotion


def _read(file: MotionFile) -> SourceMotion:
    if file.path.suffix.lower() == ".asf":
        raise MotionFileError(file.name, None, "a skeleton without motion", "its .amc file expected")
    skeleton = file.skeleton or find_skeleton(file.path)
    return parse_amc(file.data, file.name, parse_asf(file.load(skeleton), str(skeleton)))


def find_skeleton(path: Path) -> Path:
    """Return the .asf file next to an .amc file that is its skeleton: the one with its name or the beginning of it,
    such as 49.asf for 49_10.amc, or the only one. MotionFileError if there is none or several."""
    there = sorted(p for p in path.parent.glob("*") if p.suffix.lower() == ".asf")
    fitting = [p for p in there if path.stem == p.stem] or [p for p in there if path.stem.split("_")[0] == p.stem]
    if len(fitting or there) != 1:
        found = ", ".join(p.name for p in there[:12]) or "no .asf file"
        raise MotionFileError(
            str(path), None, f"its skeleton is not known; next to it: {found}", "give it: --skeleton FILE.asf"
        )
    return (fitting or there)[0]


FORMAT: Final = MotionFormat(
    "ASF/AMC",
    (".amc",),
    _read,
    "the CMU library's recordings, with their skeleton in a file next to them",
    begins=(b":", b"#"),
    companions={".amc": ".asf"},
    skeleton=find_skeleton,
)
