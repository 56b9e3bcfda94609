"""The declaration of a motion format: its names, how its files are recognised, its reader and its writer.

A format is one `MotionFormat`. `live.library.motion_formats` joins all of them to one table; it reads no file and knows
no format itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from live.motion.clip import Clip
from live.motion.formats.source_motion import SourceMotion, UpAxis
from live.motion.formats.stage_motion import StageFiles, StageMotion


@dataclass(frozen=True, slots=True, eq=False)
class MotionFile:
    """A file as a reader gets it."""

    path: Path
    data: bytes
    """Its contents, not empty."""
    load: Callable[[Path], bytes]
    """Returns the contents of another file; MotionFileError if it cannot be read or is too long."""
    skeleton: Path | None = None
    """The file that holds the skeleton, if a person named one."""
    up: UpAxis | None = None
    """The axis that points up, if a person gave it."""

    @property
    def name(self) -> str:
        """Its path, for messages."""
        return str(self.path)


Reader = Callable[[MotionFile], SourceMotion]
Writer = Callable[[Clip], bytes]
StageWriter = Callable[[StageMotion, str], StageFiles]


@dataclass(frozen=True, slots=True, eq=False)
class MotionFormat:
    """One format."""

    name: str
    suffixes: tuple[str, ...]
    """Suffixes of its files in lower case, as in ".bvh"."""
    read: Reader
    """Returns the motion in a file. It raises MotionFileError only, whatever the content, and its memory is bounded by
    64 MB and 20 times the data."""
    text: str
    """What it is, in a line for documents."""
    begins: tuple[bytes, ...] = ()
    """First bytes of its files, in any case and after white space; they count more than the suffix."""
    readable: bool = True
    """False: `read` only says what to do instead."""
    write: Writer | None = None
    """Returns a file with the clip on the engine's skeleton, one frame for each sample."""
    written: tuple[str, ...] = ()
    """The suffixes under which it is written."""
    write_stage: StageWriter | None = None
    """Returns the files with all dancers of a show, for a suffix; PersonError if it cannot hold them."""
    stage_suffixes: tuple[str, ...] = ()
    """The suffixes of these files."""
    companions: Mapping[str, str] = field(default_factory=dict)
    """For a suffix, the suffix of the files in the same folder that such a file is read with."""
    skeleton: Callable[[Path], Path] | None = None
    """Returns the file in the same folder that holds a file's skeleton; MotionFileError if it is not clear which."""
    external: Callable[[MotionFile], tuple[str, ...]] | None = None
    """Returns the names of other files, except the skeleton's, in which the motion of a file lies that was read."""
