"""Reader for AMASS archives (.npz): joint rotations of the SMPL family of body models, on a fixed skeleton.

The body models are licensed and not needed: the rotations hold the motion. The skeleton used here is an adult 1.70 m
tall, with segment lengths as fractions of the stature (Drillis and Contini 1966, as printed in Winter, Biomechanics
and Motor Control of Human Movement). `betas`, the body shape, are ignored.
"""

from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion import quaternion
from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError
from live.motion.formats.motion_format import MotionFormat
from live.motion.formats.npz import Archive, as_float64
from live.motion.formats.source_motion import FileWarning, SourceMotion

STATURE: Final = 1.70
RATES: Final = ("mocap_framerate", "mocap_frame_rate", "fps")
POSE_WIDTHS: Final = {66: "body", 72: "SMPL", 156: "SMPL-H", 159: "SMPL-H", 165: "SMPL-X"}
"""Allowed numbers per frame in `poses`, three per joint; the first 22 joints are the same in all models."""
FPS_RANGE: Final = (1.0, 1000.0)
_BODY_JOINTS: Final = 22
_FRAME_BYTES: Final = 4000
"""Memory [bytes] for one frame while reading."""
_H: Final = STATURE
# name, parent, offset from the parent [m] in the T-pose, facing +z with the left at +x
_JOINTS: Final = (
    ("pelvis", "", (0.0, 0.0, 0.0)),
    ("left_hip", "pelvis", (0.050 * _H, -0.045 * _H, 0.0)),
    ("right_hip", "pelvis", (-0.050 * _H, -0.045 * _H, 0.0)),
    ("spine1", "pelvis", (0.0, 0.065 * _H, -0.010)),
    ("left_knee", "left_hip", (0.0, -0.245 * _H, 0.0)),
    ("right_knee", "right_hip", (0.0, -0.245 * _H, 0.0)),
    ("spine2", "spine1", (0.0, 0.075 * _H, 0.0)),
    ("left_ankle", "left_knee", (0.0, -0.246 * _H, 0.0)),
    ("right_ankle", "right_knee", (0.0, -0.246 * _H, 0.0)),
    ("spine3", "spine2", (0.0, 0.035 * _H, 0.0)),
    ("left_foot", "left_ankle", (0.0, -0.032 * _H, 0.075 * _H)),
    ("right_foot", "right_ankle", (0.0, -0.032 * _H, 0.075 * _H)),
    ("neck", "spine3", (0.0, 0.105 * _H, -0.010)),
    ("left_collar", "spine3", (0.045 * _H, 0.070 * _H, -0.010)),
    ("right_collar", "spine3", (-0.045 * _H, 0.070 * _H, -0.010)),
    ("head", "neck", (0.0, 0.052 * _H, 0.020)),
    ("left_shoulder", "left_collar", (0.0845 * _H, 0.010, 0.0)),
    ("right_shoulder", "right_collar", (-0.0845 * _H, 0.010, 0.0)),
    ("left_elbow", "left_shoulder", (0.186 * _H, 0.0, 0.0)),
    ("right_elbow", "right_shoulder", (-0.186 * _H, 0.0, 0.0)),
    ("left_wrist", "left_elbow", (0.146 * _H, 0.0, 0.0)),
    ("right_wrist", "right_elbow", (-0.146 * _H, 0.0, 0.0)),
)
_ENDS: Final = (
    ("head", (0.0, 0.093 * _H, 0.0)),
    ("left_wrist", (0.108 * _H, 0.0, 0.0)),
    ("right_wrist", (-0.108 * _H, 0.0, 0.0)),
    ("left_foot", (0.0, 0.0, 0.045 * _H)),
    ("right_foot", (0.0, 0.0, 0.045 * _H)),
)
NAMES: Final = tuple(name for name, _, _ in _JOINTS)
"""The first 22 joints of SMPL, SMPL-H and SMPL-X, in their order."""
_Y_UP_TO_Z_UP: Final = np.array((np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0))


_PARENTS: Final = np.array([NAMES.index(parent) if parent else -1 for _, parent, _ in _JOINTS], np.int32)
_OFFSETS: Final = np.array([offset for _, _, offset in _JOINTS])
_END_PARENTS: Final = np.array([NAMES.index(name) for name, _ in _ENDS], np.int32)
_END_OFFSETS: Final = np.array([offset for _, offset in _ENDS])
for _array in (_PARENTS, _OFFSETS, _END_PARENTS, _END_OFFSETS):
    _array.setflags(write=False)


def parse_amass(data: bytes, file: str) -> SourceMotion:
    """Parse an AMASS archive: `poses` (T, 66 | 72 | 156 | 165) axis-angle [rad], `trans` (T, 3) [m], a frame rate.

    SMPL-X archives without `poses` are read from `root_orient` (T, 3) and `pose_body` (T, 63). Metres, Z up; fingers
    are ignored. The rest rotation of the root makes the T-pose upright in a Z-up world. Raises only MotionFileError,
    with the expected key, type and shape; memory is bounded by 64 MB + 20 times the data.
    """
    archive = Archive(data, file)
    if not any(archive.has(key) for key in ("poses", "pose_body")):
        there = ", ".join(archive.keys[:8]) or "nothing"
        words = f"no motion: no array 'poses' among {there}"
        raise MotionFileError(file, None, words, "an AMASS archive with poses, trans and mocap_framerate expected")
    body = _body_rotations(archive, file, len(data))
    frames = len(body)
    warnings: list[FileWarning] = []
    if archive.has("trans"):
        trans = _check_values(archive.table("trans", 3, rows=frames), "trans", file)
    else:
        trans = np.zeros((frames, 3))
        warnings.append(FileWarning("no array 'trans': the dancer stays in place"))
    vectors = body.reshape(frames, _BODY_JOINTS, 3)
    rotation = np.asarray(quaternion.align_signs(quaternion.from_rotation_vector(vectors)), np.float64)
    translation = np.broadcast_to(_OFFSETS, (frames, _BODY_JOINTS, 3)).copy()
    translation[:, 0] = trans
    rest = np.tile((1.0, 0.0, 0.0, 0.0), (_BODY_JOINTS, 1))
    rest[0] = _Y_UP_TO_Z_UP
    for array in (rotation, translation, rest):
        array.setflags(write=False)
    return SourceMotion(
        file=file,
        names=NAMES,
        parents=_PARENTS,
        offsets=_OFFSETS,
        end_parents=_END_PARENTS,
        end_offsets=_END_OFFSETS,
        translation=translation,
        rotation=rotation,
        rest_rotation=rest,
        frame_time=1.0 / _frame_rate(archive, file),
        frames_declared=frames,
        channel_count=3 * _BODY_JOINTS + 3,
        unit_m=1.0,
        up="Z",
        root_offset="zero",
        warnings=tuple(warnings),
    )


def _body_rotations(archive: Archive, file: str, size: int) -> Float64:
    """Return the rotation vectors of the 22 body joints, (T, 66) [rad]."""
    if archive.has("poses"):
        poses = archive.array("poses")
        if poses.ndim != 2 or poses.shape[1] not in POSE_WIDTHS:
            widths = " or ".join(map(str, POSE_WIDTHS))
            raise MotionFileError(file, None, f"poses has the shape {poses.shape}", f"(frames, {widths}) expected")
        _check_length(len(poses), size, file)
        body = as_float64(poses[:, : 3 * _BODY_JOINTS])
    else:
        turned = archive.table("pose_body", 3 * _BODY_JOINTS - 3)
        _check_length(len(turned), size, file)
        body = np.concatenate((archive.table("root_orient", 3, rows=len(turned)), turned), axis=1)
    if not len(body):
        raise MotionFileError(file, None, "no frames", "at least one expected")
    return _check_values(body, "poses", file)


def _check_length(frames: int, size: int, file: str) -> None:
    """Raise MotionFileError if a small archive would unpack to excessive memory."""
    if frames * _FRAME_BYTES > 48_000_000 + 14 * size:
        words = f"{frames} frames in a file of {size} bytes"
        raise MotionFileError(file, None, words, "a shorter motion expected; cut it into pieces")


def _check_values(array: Float64, key: str, file: str) -> Float64:
    strange = np.flatnonzero(~(np.abs(array) <= MAGNITUDE_LIMIT).all(axis=1))  # catches NaN too
    if strange.size:
        words = f"frame {strange[0]} of {key} holds a number that is not usable"
        raise MotionFileError(file, None, words, "finite, at most 1e7, expected")
    return array


def _frame_rate(archive: Archive, file: str) -> float:
    key = next((key for key in RATES if archive.has(key)), None)
    if key is None:
        raise MotionFileError(file, None, "no frame rate", f"one number called {' or '.join(RATES)} expected")
    rate = archive.number(key)
    if not FPS_RANGE[0] <= rate <= FPS_RANGE[1]:
        raise MotionFileError(file, None, f"{key} is {rate:g}", "1 to 1000 frames per second expected")
    return rate


AMASS: Final = MotionFormat(
    "AMASS npz",
    (".npz",),
    lambda file: parse_amass(file.data, file.name),
    "joint rotations of the SMPL family of body models",
    begins=(b"PK\3\4",),
)
