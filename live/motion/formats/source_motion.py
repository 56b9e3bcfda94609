"""SourceMotion: what a motion file holds, whatever its format, before it is brought onto the engine's skeleton."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UpAxis = Literal["Y", "Z"]
OffsetUse = Literal["zero", "add", "replace"]


@dataclass(frozen=True, slots=True)
class FileWarning:
    """Something strange but usable in a motion file."""

    what: str
    line: int | None = None
    """Line in the file, from 1, where there is one."""
    frame: int | None = None
    """Frame, from 0, where there is one."""


@dataclass(frozen=True, slots=True, eq=False)
class SourceMotion:
    """J joints (End Sites are not joints) over T frames, in the file's own units and axes; every format ends here."""

    file: str
    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, which always comes before it; -1 for the root, shape (J,)."""
    offsets: Float64
    """From the parent to the joint in the rest pose, in the parent's rest axes [file units], shape (J, 3)."""
    end_parents: Int32
    """Joint that carries each of the E End Sites, shape (E,)."""
    end_offsets: Float64
    """From that joint to the End Site [file units], shape (E, 3)."""
    translation: Float64
    """From the parent to the joint, in the parent's axes [file units], (T, J, 3); the root's is its place."""
    rotation: Float64
    """Rotation of each joint relative to its parent, unit quaternions, shape (T, J, 4)."""
    rest_rotation: Float64 | None
    """The same in the rest pose, (J, 4), where the format has one that is not the identity (glTF)."""
    frame_time: float
    """Seconds per frame as the file says it (it may lie)."""
    frames_declared: int
    """Number of frames as the file says it (it may lie)."""
    channel_count: int
    """Numbers per frame that the file holds."""
    unit_m: float | None = None
    """Metres per unit, where the format fixes it (glTF: 1); None where it must be found."""
    up: UpAxis | None = None
    """The axis that points up, where the format fixes it; None where it must be found."""
    root_offset: OffsetUse | None = None
    """What was done with the OFFSET of the root; None where it cannot be told (then it was added)."""
    warnings: tuple[FileWarning, ...] = ()

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    @property
    def frame_count(self) -> int:
        """Number of frames T that the file really holds."""
        return int(self.rotation.shape[0])

    @property
    def header_fps(self) -> float:
        """Frames per second as the file says it."""
        return 1.0 / self.frame_time
