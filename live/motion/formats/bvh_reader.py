"""Reader for BVH motion files with any rotation order and channel layout (T164).

Errors that would corrupt the motion are refused (a number missing in a line, no number, NaN). Common deviations are
accepted (wrong Frames count, CRLF, tabs, keywords in other cases, joints without channels). Channels become
translations and rotations relative to the parent; the use of the root's OFFSET is decided from the data.
"""

import re
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32
from live.motion.formats.bvh_header import Hierarchy, parse_hierarchy
from live.motion.formats.bvh_kernels import pose_channels
from live.motion.formats.bvh_numbers import line_at, read_numbers
from live.motion.formats.bvh_writer import stage_bvh, write_bvh
from live.motion.formats.file_error import MotionFileError, quoted, read_number
from live.motion.formats.file_report import refuse_too_large
from live.motion.formats.motion_format import MotionFormat
from live.motion.formats.source_axes import find_up, leg_length
from live.motion.formats.source_motion import FileWarning, LocalPose, OffsetUse, SourceMotion, UpAxis, world_pose
from live.motion.retarget.joint_mapping import find_body
from live.motion.retarget.source_body import SourceBody

FRAME_TIME_RANGE: Final = (1e-4, 10.0)
"""Accepted seconds per frame."""

SKELETON_BYTES: Final = 4_000_000
"""Maximum length of the HIERARCHY part: a thousand joints take less than a tenth of it."""

_MOTION: Final = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*MOTION[ \t]*(?=[\r\n]|\Z)", re.IGNORECASE)
_LINE: Final = re.compile(rb"([^\r\n]*)(\r\n|\r|\n|\Z)")
_HEADER_LINE: Final = re.compile(r"\s*([A-Za-z][A-Za-z ]*?)\s*:?\s+(\S+)\s*", re.ASCII)
_NOT_BLANK: Final = re.compile(rb"\S")
_FRAMES: Final = re.compile(r"\d{1,15}", re.ASCII)


@dataclass(frozen=True, slots=True, eq=False)
class BvhMotion:
    """The content of one file: J joints (End Sites are not joints), C channels, T frames; units as in the file."""

    file: str
    names: tuple[str, ...]
    parents: Int32
    """Parent of each joint, parents first; -1 for the root, shape (J,)."""
    offsets: Float64
    """OFFSET of each joint [file units], shape (J, 3)."""
    channels: tuple[str, ...]
    """Per joint one letter per channel in file order: x y z = position along, X Y Z = rotation about that axis."""
    end_parents: Int32
    """Parent joint of each of the E End Sites, shape (E,)."""
    end_offsets: Float64
    """OFFSET of each End Site [file units], shape (E, 3)."""
    values: Float64
    """The channels of every frame [file units, degrees], shape (T, C)."""
    frame_time: float
    """Seconds per frame as the file states them (may be wrong)."""
    frames_declared: int
    """Number of frames as the file states it (may be wrong)."""
    warnings: tuple[str, ...]
    """Anomalies that do not prevent use."""

    @property
    def joint_count(self) -> int:
        """Number of joints J."""
        return len(self.names)

    @property
    def frame_count(self) -> int:
        """Number of frames T in the file."""
        return int(self.values.shape[0])

    @property
    def header_fps(self) -> float:
        """Frames per second as the file states them."""
        return 1.0 / self.frame_time


def parse_bvh(data: bytes | str, file: str) -> BvhMotion:
    """Parse a whole BVH file; `file` is its name for messages.

    Raises only MotionFileError, for any other content. Time is linear in the length of `data`.
    """
    if isinstance(data, str):
        data = data.encode("utf-8", errors="replace")
    data = data.removeprefix(b"\xef\xbb\xbf")
    motion = _MOTION.search(data, 0, SKELETON_BYTES)
    if motion is None:
        raise _missing_motion_error(data, file)
    hierarchy = parse_hierarchy(_text(data[: motion.start()]), file)
    frames, frame_time, start = _read_motion_header(data, motion.end(), file)
    columns = sum(map(len, hierarchy.channels))
    if columns == 0:
        raise MotionFileError(file, line_at(data, start), "no joint has channels", "CHANNELS with rotations expected")
    values = read_numbers(data, start, columns, frames, file)
    refuse_too_large(file, len(values), len(hierarchy.names), columns, len(data))
    warnings = []
    if values.shape[0] != frames:
        warnings.append(f"says {frames} frames, holds {values.shape[0]} data lines: all of them are used")
    return _build(hierarchy, file, values, frame_time, frames, tuple(warnings))


def _text(data: bytes) -> str:
    return data.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n")


def _missing_motion_error(data: bytes, file: str) -> MotionFileError:
    text = _text(data[:SKELETON_BYTES])
    start = text[:1000].lstrip()
    if start[:9].upper() != "HIERARCHY":
        return MotionFileError(file, 1, f"{quoted(start[:20])} was read", "a BVH file begins with HIERARCHY")
    parse_hierarchy(text, file)  # an error in the skeleton gives a better message
    if len(data) > SKELETON_BYTES:
        text = f"no MOTION within the first {SKELETON_BYTES} bytes"
        return MotionFileError(file, None, text, "a file with recorded frames expected")
    return MotionFileError(file, text.count("\n") + 1, "no MOTION section", "a file with recorded frames expected")


def _build(
    hierarchy: Hierarchy, file: str, values: Float64, frame_time: float, frames: int, warnings: tuple[str, ...]
) -> BvhMotion:
    arrays = (
        np.array(hierarchy.parents, np.int32),
        np.array(hierarchy.offsets, np.float64).reshape(-1, 3),
        np.array(hierarchy.end_parents, np.int32),
        np.array(hierarchy.end_offsets, np.float64).reshape(-1, 3),
        values,
    )
    for array in arrays:
        array.setflags(write=False)
    return BvhMotion(
        file=file,
        names=tuple(hierarchy.names),
        parents=arrays[0],
        offsets=arrays[1],
        channels=tuple(hierarchy.channels),
        end_parents=arrays[2],
        end_offsets=arrays[3],
        values=values,
        frame_time=frame_time,
        frames_declared=frames,
        warnings=warnings,
    )


def _read_motion_header(data: bytes, place: int, file: str) -> tuple[int, float, int]:
    """Return frames, frame time [s], and the byte where the numbers begin; `place` is the end of the word MOTION."""
    frames: int | None = None
    frame_time: float | None = None
    place = _next_line(data, place)
    while frames is None or frame_time is None:
        missing = "Frames: COUNT" if frames is None else "Frame Time: SECONDS"
        word = _NOT_BLANK.search(data, place)
        if word is None:
            raise MotionFileError(file, line_at(data, len(data)), "the file ends here", f"{missing} expected")
        line = line_at(data, word.start())
        place = _next_line(data, word.start())
        content = _text(data[word.start() : min(place, word.start() + 500)]).strip()
        match = _HEADER_LINE.fullmatch(content)
        key = match.group(1).lower().replace(" ", "") if match else ""
        if match is None or key not in ("frames", "frametime"):
            raise MotionFileError(file, line, f"{quoted(content)} was read", f"{missing} expected")
        if (frames if key == "frames" else frame_time) is not None:
            raise MotionFileError(file, line, f"{quoted(content)} a second time", f"{missing} expected")
        if key == "frames":
            frames = _read_frame_count(match.group(2), file, line)
        else:
            frame_time = _read_frame_time(match.group(2), file, line)
    return frames, frame_time, place


def _next_line(data: bytes, place: int) -> int:
    """Return the start of the next line."""
    match = _LINE.match(data, place)
    return match.end() if match else len(data)


def _read_frame_count(text: str, file: str, line: int) -> int:
    if not _FRAMES.fullmatch(text):
        raise MotionFileError(file, line, f"{quoted(text)} frames", "a whole number expected")
    return int(text)


def _read_frame_time(text: str, file: str, line: int) -> float:
    seconds = read_number(text, file, line, "Frame Time")
    if not FRAME_TIME_RANGE[0] <= seconds <= FRAME_TIME_RANGE[1]:
        raise MotionFileError(file, line, f"Frame Time {quoted(text)}", "0.0001 to 10 seconds expected")
    return seconds


def local_pose(motion: BvhMotion, root_offset: Literal["add", "replace"] = "add") -> LocalPose:
    """Return the channels as rotations and translations.

    By the format (T164: A = O_A + T_A) position channels are added to OFFSET. Some programs write the full position
    into them instead. For the root `root_offset` selects the interpretation; for other joints it is decided from the
    values (near zero or near OFFSET).
    """
    base = np.array(motion.offsets, np.float64)
    kinds: list[tuple[int, int]] = []
    for joint, letters in enumerate(motion.channels):
        moves = {"xyz".index(letter): len(kinds) + n for n, letter in enumerate(letters) if letter.islower()}
        if moves:
            axes = list(moves)
            moved = motion.values[:, list(moves.values())]
            if root_offset == "replace" if joint == 0 else _includes_offset(moved, base[joint, axes]):
                base[joint, axes] = 0.0
        kinds += [(joint, "xyzXYZ".index(letter)) for letter in letters]
    frames, joints = motion.frame_count, motion.joint_count
    translation, rotation = np.empty((frames, joints, 3)), np.empty((frames, joints, 4))
    pose_channels(motion.values, np.array(kinds, np.int32).reshape(-1, 2), base, translation, rotation)
    return LocalPose(translation, rotation)


def _includes_offset(moved: Float64, offset: Float64) -> bool:
    """Whether position channels of an inner joint include OFFSET (then it must not be added)."""
    return bool(np.median(np.linalg.norm(moved - offset, axis=-1)) < np.median(np.linalg.norm(moved, axis=-1)))


def find_root_offset(
    motion: BvhMotion, body: SourceBody, positions: npt.NDArray[np.floating], up: UpAxis
) -> OffsetUse | None:
    """Return the use of the root's OFFSET that puts the lowest joint nearer to zero height.

    `positions` (T, J, 3) include the OFFSET, as the format defines (T164). None for a single frame or where both uses
    fit equally well: then it is added.
    """
    if has_no_root_offset(motion):
        return "zero"
    if motion.frame_count < 2:
        return None
    axis = "XYZ".index(up)
    floor = float(np.median(positions[:, :, axis].min(axis=1)))
    raised = float(motion.offsets[0, axis])
    if abs(raised) < 0.05 * leg_length(body, positions):
        return None  # both uses fit equally well
    return "add" if abs(floor) <= abs(floor - raised) else "replace"


def has_no_root_offset(motion: BvhMotion) -> bool:
    """Whether the root's OFFSET is zero or the root has no position channels, so that both uses are the same."""
    return not motion.offsets[0].any() or not any(letter.islower() for letter in motion.channels[0])


DETECTION_FRAMES: Final = 500
"""Maximum number of evenly spaced frames from which missing information is decided."""


def bvh_to_source_motion(motion: BvhMotion, up: UpAxis | None = None) -> SourceMotion:
    """Return the motion of a BVH file in its own units and axes.

    `up` is the axis that points up, if the user has given it. It and ground contact decide whether the root's OFFSET
    is added (T164) or replaced. Position channels of other joints: see `local_pose`.
    """
    local = local_pose(motion)
    source = SourceMotion(
        file=motion.file,
        names=motion.names,
        parents=motion.parents,
        offsets=motion.offsets,
        end_parents=motion.end_parents,
        end_offsets=motion.end_offsets,
        translation=np.asarray(local.translation, np.float64),
        rotation=np.asarray(local.rotation, np.float64),
        rest_rotation=None,
        frame_time=motion.frame_time,
        frames_declared=motion.frames_declared,
        channel_count=int(motion.values.shape[1]),
        up=up,
        warnings=tuple(FileWarning(words) for words in motion.warnings),
    )
    use = _decide_root_offset(motion, source, up)
    if use == "replace":
        moving = ["XYZ".index(letter.upper()) for letter in motion.channels[0] if letter.islower()]
        local.translation[:, 0, moving] -= motion.offsets[0, moving]
    for array in (local.translation, local.rotation):
        array.setflags(write=False)
    return replace(source, root_offset=use)


def _decide_root_offset(motion: BvhMotion, source: SourceMotion, up: UpAxis | None) -> OffsetUse | None:
    if has_no_root_offset(motion):
        return "zero"
    body = find_body(source)
    if body.missing:
        return None
    frames = np.unique(np.linspace(0, motion.frame_count - 1, DETECTION_FRAMES).astype(np.int64))
    seen = world_pose(source.parents, LocalPose(source.translation[frames], source.rotation[frames]))
    return find_root_offset(motion, body, seen.positions, up or find_up(body, seen.positions) or "Y")


BVH: Final = MotionFormat(
    "BVH",
    (".bvh",),
    lambda file: bvh_to_source_motion(parse_bvh(file.data, file.name), file.up),
    "a skeleton and its angles as text, from most capture programs",
    begins=(b"HIERARCHY",),
    write=lambda clip: write_bvh(clip, rate=None).encode("ascii"),
    written=(".bvh",),
    write_stage=lambda motion, _: stage_bvh(motion),
    stage_suffixes=(".bvh",),
)
