"""Reader for Acclaim motion files (.amc) as the CMU library writes them: per frame, one line of angles per bone."""

import math
from array import array
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.bridges.acclaim.acclaim_skeleton import AcclaimSkeleton, iterate_lines
from live.motion import quaternion
from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, quoted, read_number
from live.motion.formats.file_report import VALUE_LIMIT, refuse_too_large
from live.motion.formats.source_motion import FileWarning, SourceMotion
from live.motion.quaternion import euler_to_quaternion

DEFAULT_RATE: Final = 120.0
"""Frames per second of the CMU library. AMC files rarely state their own."""
RATE_RANGE: Final = (0.1, 10_000.0)


def parse_amc(data: bytes, file: str, skeleton: AcclaimSkeleton) -> SourceMotion:
    """Parse an AMC file for the skeleton of its ASF file; `file` is its name for messages.

    Raises MotionFileError with the line and the expected content. Each frame must hold each movable bone once.
    """
    reader = _AmcReader(file, skeleton)
    values = reader.read(data)
    refuse_too_large(file, len(values), len(skeleton.names), values.shape[1], len(data))
    translation, rotation = _pose(values, skeleton, reader.radians_per_unit)
    for read_only in (translation, rotation):
        read_only.setflags(write=False)
    warnings = [*reader.warnings]
    if reader.rate is None:
        rate = f"the file does not state its frame rate; {DEFAULT_RATE:g}, the CMU's rate, is used"
        warnings.append(FileWarning(rate))
    return SourceMotion(
        file=file,
        names=skeleton.names,
        parents=skeleton.parents,
        offsets=skeleton.offsets,
        end_parents=skeleton.end_parents,
        end_offsets=skeleton.end_offsets,
        translation=translation,
        rotation=rotation,
        rest_rotation=None,
        frame_time=1.0 / (reader.rate or DEFAULT_RATE),
        frames_declared=len(values),
        channel_count=int(values.shape[1]),
        unit_m=skeleton.unit_m,
        root_offset="add" if skeleton.offsets[0].any() else "zero",
        warnings=tuple(warnings),
    )


class _AmcReader:
    def __init__(self, file: str, skeleton: AcclaimSkeleton) -> None:
        self._file, self._line = file, 1
        self._channel_counts = {
            name: len(letters) for name, letters in zip(skeleton.names, skeleton.channels, strict=True)
        }
        self._moving_bones = [name for name, count in self._channel_counts.items() if count]
        self._values = array("d")
        self._frame_values: dict[str, list[float]] = {}
        self._frame: int | None = None
        self.radians_per_unit = math.pi / 180.0
        """Radians per unit of angles."""
        self.rate: float | None = None
        self.warnings: list[FileWarning] = []

    def read(self, data: bytes) -> Float64:
        """Return the numbers of every frame in the skeleton's order, shape (T, C)."""
        if not self._moving_bones:
            raise MotionFileError(self._file, None, "no bone of the skeleton has 'dof'", "bones that can move expected")
        for line, words in iterate_lines(data, self._file):
            self._line = line
            if words[0].startswith(":"):
                self._read_keyword(words)
            elif len(words) == 1:
                self._begin_frame(words[0])
            else:
                self._read_bone(words)
        if self._frame is None:
            raise self._error("no frames", "a frame's number and a line for each bone expected")
        self._end_frame("the file is cut off: ")
        return np.array(self._values).reshape(-1, sum(self._channel_counts.values()))

    def _read_keyword(self, words: list[str]) -> None:
        key = words[0].lower()
        if self._frame is not None:
            raise self._error(f"{quoted(words[0])} was read among the frames", "a frame's number or a bone expected")
        if key == ":radians":
            self.radians_per_unit = 1.0
        elif key == ":samples-per-second":
            rate = read_number(words[1] if len(words) > 1 else "", self._file, self._line, key)
            if not RATE_RANGE[0] <= rate <= RATE_RANGE[1]:
                raise self._error(f"{quoted(words[1])} frames per second", "0.1 to 10000 expected")
            self.rate = rate

    def _begin_frame(self, word: str) -> None:
        if not (word.isascii() and word.isdigit() and len(word) <= 15):
            raise self._error(f"{quoted(word)} was read", "a frame's number, or a bone and its angles expected")
        number = int(word)
        if self._frame is not None:
            self._end_frame("")
            if number <= self._frame:
                raise self._error(f"frame {number} after frame {self._frame}", f"{self._frame + 1} expected")
            if number > self._frame + 1 and len(self.warnings) < 100:
                words = f"frame {number} comes after {self._frame}: the frames between are missing"
                self.warnings.append(FileWarning(words, line=self._line))
        self._frame = number

    def _end_frame(self, problem: str) -> None:
        read = self._frame_values
        if len(read) < len(self._moving_bones):
            missing = next(name for name in self._moving_bones if name not in read)
            words = f"{problem}frame {self._frame} holds nothing for {quoted(missing)}"
            raise self._error(words, f"a line for each of the {len(self._moving_bones)} bones that move expected")
        for name in self._moving_bones:
            self._values.extend(read[name])
        if len(self._values) > VALUE_LIMIT:
            raise self._error(f"more than {VALUE_LIMIT} numbers", "a shorter recording expected")
        self._frame_values = {}

    def _read_bone(self, words: list[str]) -> None:
        name, count = words[0], len(words) - 1
        if self._frame is None:
            raise self._error(f"{quoted(name)} was read", "the number of the first frame expected")
        if self._channel_counts.get(name) != count or name in self._frame_values:
            raise self._bone_error(name, count)
        try:
            numbers = [float(word) for word in words[1:]]
        except ValueError:
            numbers = []
        if not numbers or not all(abs(x) <= MAGNITUDE_LIMIT for x in numbers) or any("_" in word for word in words[1:]):
            numbers = [read_number(word, self._file, self._line, f"an angle of {name}") for word in words[1:]]
        self._frame_values[name] = numbers

    def _bone_error(self, name: str, count: int) -> MotionFileError:
        expected = self._channel_counts.get(name)
        if expected is None:
            return self._error(
                f"{quoted(name)} is no bone of the skeleton", f"{', '.join(self._moving_bones[:6])}, ... expected"
            )
        if expected == 0:
            return self._error(f"{quoted(name)} cannot move: its skeleton has no 'dof' for it", "other bones expected")
        if name in self._frame_values:
            return self._error(f"{quoted(name)} twice in frame {self._frame}", "each bone once expected")
        return self._error(f"{count} numbers for {quoted(name)}", f"{expected} (one per 'dof') expected")

    def _error(self, problem: str, expected: str) -> MotionFileError:
        return MotionFileError(self._file, self._line, problem, expected)


def _pose(values: Float64, skeleton: AcclaimSkeleton, radians_per_unit: float) -> tuple[Float64, Float64]:
    """Return translations (T, J, 3) and rotations C M C⁻¹ (T, J, 4) of every joint relative to its parent.

    The angles of M are applied in the order of `dof`, first to last, about the bone's own axes C.
    """
    frames, joints = len(values), len(skeleton.names)
    translation, rotation = np.empty((frames, joints, 3)), np.empty((frames, joints, 4))
    first = 0
    for joint, letters in enumerate(skeleton.channels):
        columns = {letter: first + n for n, letter in enumerate(letters)}
        first += len(letters)
        axes = skeleton.axes[joint]
        order = "".join(filter(str.isupper, letters))[::-1]
        turned = euler_to_quaternion(values[:, [columns[letter] for letter in order]] * radians_per_unit, order)
        rotation[:, joint] = quaternion.mul(quaternion.mul(axes, turned), quaternion.inverse(axes))
        translation[:, joint] = skeleton.offsets[joint]
        moved = np.zeros((frames, 3))
        for letter in filter(str.islower, letters):
            moved[:, "xyz".index(letter)] = values[:, columns[letter]]
        if moved.any():
            translation[:, joint] += moved if joint == 0 else quaternion.rotate(axes, moved)
    return translation, rotation
