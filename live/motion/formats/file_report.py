"""Report about a recording: counts, axes, unit, floor, body height, travelled distance and warnings.

Also the size limits that bound the memory for reading a file to 64 MB plus 20 times its length.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion import quaternion
from live.motion.cleanup.frame_rate_check import suspect_frame_rate
from live.motion.cleanup.glitch_detection import Glitch, find_glitches
from live.motion.cleanup.trim_start import find_recording_start
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import BODY_HEIGHT_RANGE, body_height, find_unit, find_up, leg_length
from live.motion.formats.source_motion import (
    FileWarning,
    LocalPose,
    OffsetUse,
    SourceMotion,
    UpAxis,
    WorldPose,
    end_positions,
    world_pose,
)
from live.motion.retarget.body_tracks import body_tracks
from live.motion.retarget.joint_mapping import find_body, map_joints
from live.motion.retarget.source_body import SourceBody

FLOOR_PERCENTILE: Final = 5.0
FLOATING_HEIGHT: Final = 0.08
"""If the lowest point is this high [m] above the floor for half of the time, the height is probably wrong."""
STILL_SHARE: Final = 0.01
"""A joint that moves less than this share of the leg length counts as still."""
_Z_UP_TO_Y_UP: Final = np.array((np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0))


@dataclass(frozen=True, slots=True, eq=False)
class MotionReport:
    """The keys of `live bvh --json`; None for unknown values."""

    joints: int
    end_sites: int
    channels: int
    frames: int
    frames_declared: int
    header_fps: float
    fps: float
    seconds: float
    unit_m: float | None
    """Metres per file unit."""
    up: UpAxis | None
    root_offset: OffsetUse | None
    tpose_first: bool
    """Whether the first frame is an added T-pose."""
    floor_m: float | None
    """5th percentile of the height of the lowest joint or End Site [m], without an added T-pose and its transition."""
    height_m: float | None
    """Height of a person with this leg length [m], by the engine's proportions: few files mark the top of the head."""
    travel_m: float | None
    """Length of the hips' horizontal path [m], without an added T-pose and the transition from it."""
    mapped: dict[str, str | None]
    """The file's joint for each of the engine's joints, or None."""
    warnings: tuple[FileWarning, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SourceTracks:
    """All joints of a recording in metres, Y up; in file units if the unit is unknown."""

    names: tuple[str, ...]
    positions: Float64
    """Every frame, joints in file order without End Sites, shape (T, J, 3)."""


def analyze_motion(
    motion: SourceMotion, *, fps: float | None = None, unit_m: float | None = None, up: UpAxis | None = None
) -> tuple[MotionReport, SourceTracks]:
    """Return facts and joint positions of a recording; given values (rate, unit, axis) override detected ones."""
    body = find_body(motion)
    world = world_pose(motion.parents, LocalPose(motion.translation, motion.rotation))
    whole = not body.missing
    axis = up or motion.up or (find_up(body, world.positions) if whole else None)
    leg = leg_length(body, world.positions) if whole else 0.0
    unit = unit_m or _plausible_unit(motion.unit_m, leg) or find_unit(leg) or motion.unit_m
    warnings = [*motion.warnings, *_detection_warnings(motion, body, axis, unit, leg)]
    added = 0
    if whole and leg > 0.0:
        tracks = body_tracks(motion, fps=fps, up=axis, unit_m=unit)
        beginning = find_recording_start(tracks)
        added = beginning.drop_frames
        if beginning.t_pose_first:
            warnings.append(FileWarning(_tpose_message(added), frame=0))
        suspicion = suspect_frame_rate(tracks, added) if fps is None else None
        if suspicion is not None:
            warnings.append(FileWarning(str(suspicion)))
        warnings += [_glitch_warning(one) for one in find_glitches(tracks, motion.parents, added)]
        warnings += _still_root_warnings(motion, body, world, leg)
    points, lowest = _upright(motion, world, axis)
    if unit is not None:
        warnings += _floating_warnings(lowest[added:] * unit)
    points *= unit or 1.0
    hips = body.joints["hips"] or 0
    facts = MotionReport(
        joints=motion.joint_count,
        end_sites=motion.end_parents.size,
        channels=motion.channel_count,
        frames=motion.frame_count,
        frames_declared=motion.frames_declared,
        header_fps=motion.header_fps,
        fps=fps or motion.header_fps,
        seconds=motion.frame_count / (fps or motion.header_fps),
        unit_m=unit,
        up=axis,
        root_offset=motion.root_offset,
        tpose_first=added > 0,
        floor_m=None if unit is None else float(np.percentile(lowest[added:], FLOOR_PERCENTILE)) * unit,
        height_m=None if unit is None or not leg > 0.0 else body_height(leg) * unit,
        travel_m=None if unit is None else _path_length(points[added:, hips]),
        mapped=map_joints(motion),
        warnings=tuple(warnings),
    )
    return facts, SourceTracks(motion.names, points)


def _plausible_unit(unit: float | None, leg: float) -> float | None:
    """Return the unit fixed by the format, or None if it gives an implausible body height (files in centimetres)."""
    low, high = BODY_HEIGHT_RANGE
    return unit if unit is not None and (leg == 0.0 or low <= body_height(leg) * unit <= high) else None


def _upright(motion: SourceMotion, world: WorldPose, axis: UpAxis | None) -> tuple[Float64, Float64]:
    """Return joints with Y up (T, J, 3) and the height of the lowest joint or End Site (T,), in file units."""
    points, height = np.array(world.positions, np.float64), "XYZ".index(axis or "Y")
    lowest = points[..., height].min(axis=1)
    if motion.end_parents.size:
        lowest = np.minimum(lowest, end_positions(motion, world)[..., height].min(axis=1))
    if axis == "Z":
        points = np.asarray(quaternion.rotate(_Z_UP_TO_Y_UP, points), np.float64)
    return points, lowest


def _path_length(hips: npt.NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(hips[:, [0, 2]], axis=0), axis=-1).sum())


def _detection_warnings(
    motion: SourceMotion, body: SourceBody, axis: UpAxis | None, unit: float | None, leg: float
) -> list[FileWarning]:
    """Return warnings about unknown properties and implausible given values."""
    words = []
    if body.by_shape:
        words.append("the joint names say nothing: the body was found by its shape; check left and right")
    if body.missing:
        words.append(f"no body: no joints found for {', '.join(body.missing)}")
    if motion.root_offset is None:
        words.append("it is unknown whether the root's position channels include its OFFSET; it was added")
    if axis is None:
        words.append("the up axis is unknown; Y is used (give --up Z otherwise)")
    if unit is None:
        words.append("the length of a unit is unknown (--unit METRES); positions are in file units")
    elif leg > 0.0:
        low, high = BODY_HEIGHT_RANGE
        height = body_height(leg) * unit
        if not low <= height <= high:
            words.append(f"with {unit:g} m per unit the dancer is {height:.3g} m tall; {low} to {high} m is plausible")
    return [FileWarning(one) for one in words]


def _tpose_message(added: int) -> str:
    run_in = f", frames 1 to {added - 1} a transition from it" if added > 1 else ""
    return f"the first frame is an added T-pose{run_in}; the dance begins with frame {added} (drop_frames = {added})"


def _glitch_warning(glitch: Glitch) -> FileWarning:
    frames = f" up to frame {glitch.last_frame}" if glitch.last_frame > glitch.first_frame else ""
    joints = ", ".join(glitch.joints[:3]) + (", ..." if len(glitch.joints) > 3 else "")
    return FileWarning(
        f"{glitch.kind}{frames}: {joints}, off by {100 * glitch.size_m:.0f} cm", frame=glitch.first_frame
    )


def _floating_warnings(lowest: Float64) -> list[FileWarning]:
    """Warn if the body is above its lowest floor most of the time: recordings from video drift up and down."""
    over = float(np.median(lowest) - np.percentile(lowest, FLOOR_PERCENTILE))
    if over < FLOATING_HEIGHT:
        return []
    return [FileWarning(f"the body is {over:.2f} m over the floor half of the time: it drifts, or jumps a lot")]


def _still_root_warnings(motion: SourceMotion, body: SourceBody, world: WorldPose, leg: float) -> list[FileWarning]:
    hips = body.joints["hips"]
    if not hips or np.ptp(world.positions[:, 0], axis=0).max() > STILL_SHARE * leg:
        return []
    if np.ptp(world.positions[:, hips], axis=0).max() <= STILL_SHARE * leg:
        return []
    return [FileWarning(f"the root {motion.names[0]} does not move; {motion.names[hips]} below it travels")]


VALUE_LIMIT: Final = 10_000_000
"""Maximum numbers in the motion part of a file: ten minutes of 43 joints at 120 frames per second."""
JOINT_BYTES: Final = 56
"""Memory of one joint in one frame: a translation and a quaternion in float64."""
BASE_BYTES: Final = 32_000_000
"""Memory allowed for joints besides eight times the file size: a file with few channels may declare many joints."""


def refuse_too_large(file: str, frames: int, joints: int, channels: int, file_bytes: int) -> None:
    """Raise MotionFileError if joints with few channels would take memory out of proportion to the file size."""
    if frames * joints * JOINT_BYTES > BASE_BYTES + 8 * file_bytes:
        problem = f"{frames} frames of {joints} joints with {channels} channels in all"
        raise MotionFileError(file, None, problem, "channels for most joints expected, or fewer frames")
