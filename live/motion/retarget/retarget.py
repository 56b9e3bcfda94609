"""A recording onto the engine's skeleton: the bones keep their directions, the feet their places on the floor."""

from typing import Final

import numpy as np

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.foot_contact import TOES_OVER_SOLE, find_contacts
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_axes import (
    BODY_HEIGHT_RANGE,
    ENGINE_LEG,
    body_height,
    leg_length,
    standing_pose,
)
from live.motion.formats.source_motion import SourceMotion, UpAxis
from live.motion.formats.source_pose import LocalPose, world_pose
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.body_rotations import local_rotations, world_rotations
from live.motion.retarget.floor_contact import find_floor, place_hips
from live.motion.retarget.joint_mapping import SourceBody, find_body
from live.motion.retarget.rest_pose_alignment import SIDES
from live.motion.retarget.source_points import rest_points, source_points
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE

SAMPLE_RATE: Final = 60.0
"""Samples per second of clips made from recordings [Hz]."""
_NEARLY: Final = 1e-3
"""Part of a frame that is none: headers round the frame time."""


def retarget(
    motion: SourceMotion,
    *,
    name: str,
    fps: float | None = None,
    unit_m: float | None = None,
    up: UpAxis | None = None,
    drop_frames: int = 0,
    sample_rate: float = SAMPLE_RATE,
    centred: bool = True,
) -> Clip:
    """The motion as a clip of the engine's skeleton, `sample_rate` samples per second.

    `fps` is the true frame rate where the header lies, `drop_frames` leading frames are left out before anything
    else, `unit_m` (metres per unit) is only checked for plausibility, for the scale is the ratio of leg lengths:
    steps become as long as the engine's legs make them. `up` is found if it is not given.

    Limb bones point exactly where the source's do (its own skeleton, at the same moment); trunk and neck chains of
    any length are spread over ours; the hips are placed so that the feet that carry stand where the source's stood.
    The floor comes to y = 0 (5th percentile of the lowest sole; a recording that drifts up and down, as those from
    video do, is followed slowly), the first sample's hips come to x = z = 0, unless it is not to be `centred`
    (two who were recorded together); the heading stays as recorded. Between
    frames rotations are interpolated by SLERP, never as Euler angles.

    Raises MotionFileError if the skeleton is no body or has no size, ValueError for arguments out of range.
    """
    body = find_body(motion)
    _check(motion, body, fps, drop_frames, sample_rate)
    _, axis = standing_pose(motion, body, up)
    recorded = LocalPose(motion.translation, motion.rotation)
    local = _resampled(recorded, drop_frames, (fps or motion.header_fps) / sample_rate)
    points = source_points(motion, body, world_pose(motion.parents, local), axis)
    leg = leg_length(body, points.positions)
    if not leg > 1e-6 or not np.isfinite(leg):
        raise MotionFileError(motion.file, None, "the legs have no length", "OFFSETs of a body expected")
    _check_unit(motion, body_height(leg), unit_m)
    world = world_rotations(points, rest_points(motion, body, axis))
    rotation = quaternion.continuous(local_rotations(world))
    root = place_hips(points, world, rotation, ENGINE_LEG / leg)
    positions, _ = forward_kinematics(root, rotation)
    ankles, toes = (positions[:, [SKELETON.index(s + j) for s, _ in SIDES]] for j in ("Foot", "Toes"))
    lowest = np.minimum(ankles[..., 1] - SOLE_BELOW_ANKLE, toes[..., 1] - TOES_OVER_SOLE).min(axis=1)
    shift = np.empty_like(root)
    shift[:] = -root[0] if centred else 0.0
    shift[:, 1] = -find_floor(lowest, sample_rate)
    places = shift[:, None]
    return Clip(
        name=name,
        root_position=np.ascontiguousarray(root + shift, np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        sample_rate=sample_rate,
        contact=find_contacts(ankles + places, toes + places, sample_rate),
    )


def _check(motion: SourceMotion, body: SourceBody, fps: float | None, drop_frames: int, sample_rate: float) -> None:
    if fps is not None and not 1.0 <= fps <= 10_000.0:
        raise ValueError(f"fps {fps}: 1 to 10000 expected")
    if not 1.0 <= sample_rate <= 1000.0:
        raise ValueError(f"sample rate {sample_rate} Hz: 1 to 1000 expected")
    if not 0 <= drop_frames < motion.frame_count:
        raise ValueError(f"drop_frames {drop_frames}: 0 to {motion.frame_count - 1} expected in {motion.file}")
    if body.missing:
        found = ", ".join(motion.names[:8]) + (", ..." if motion.joint_count > 8 else "")
        raise MotionFileError(
            motion.file,
            None,
            f"no joints found for {', '.join(body.missing)} among {found}",
            "names of a body expected",
        )


def _check_unit(motion: SourceMotion, height: float, unit_m: float | None) -> None:
    low, high = BODY_HEIGHT_RANGE
    if unit_m is not None and not low <= height * unit_m <= high:
        raise ValueError(
            f"unit_m {unit_m}: the dancer of {motion.file} would be {height * unit_m:.3g} m tall; "
            f"{low} to {high} m is believed, that is unit_m {low / height:.3g} to {high / height:.3g}"
        )


def _resampled(local: LocalPose, drop: int, frames_per_sample: float) -> LocalPose:
    """Samples at the new rate from frame `drop` on: SLERP and linear between frames."""
    frames = local.rotation.shape[0] - drop
    count = int((frames - 1) / frames_per_sample + _NEARLY) + 1
    place = np.minimum(np.arange(count) * frames_per_sample, frames - 1)
    before = np.minimum(place.astype(np.int64), max(frames - 2, 0))
    part = place - before
    before += drop
    if np.abs(part - np.round(part)).max(initial=0.0) < _NEARLY:
        exact = before + np.round(part).astype(np.int64)
        return LocalPose(local.translation[exact], local.rotation[exact])
    after, weight = before + 1, part[:, None, None]
    return LocalPose(
        local.translation[before] * (1.0 - weight) + local.translation[after] * weight,
        quaternion.slerp(local.rotation[before], local.rotation[after], part[:, None]),
    )
