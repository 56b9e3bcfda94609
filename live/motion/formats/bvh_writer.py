"""Writer for BVH files: the engine's skeleton in centimetres, Y up, continuous Euler angles in ZXY order (T164)."""

from typing import Final

import numpy as np

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.clip import Clip, resample
from live.motion.formats.stage_motion import StageFiles, StageMotion
from live.motion.skeleton import BONE_TIPS, SKELETON

_GIMBAL_LOCK_COSINE = 1e-9
"""Cosine of x below which the angles are in gimbal lock: only the sum or difference of z and y is defined."""


def zxy_angles(rotation: Float) -> Float64:
    """Angles about z, x and y [rad] of unit quaternions, (..., 4) → (..., 3): R = Rz Rx Ry, x within ±90 degrees."""
    w, x, y, z = np.moveaxis(quaternion.unit(np.asarray(rotation, np.float64)), -1, 0)
    minus_sin_z, cos_z = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z)  # both times cos x
    minus_sin_y, cos_y = 2.0 * (x * z - w * y), 1.0 - 2.0 * (x * x + y * y)  # both times cos x
    cos_x = np.hypot(minus_sin_z, cos_z)
    locked = cos_x < _GIMBAL_LOCK_COSINE
    about_y = np.where(
        locked,
        np.arctan2(2.0 * (x * z + w * y), 1.0 - 2.0 * (y * y + z * z)),
        np.arctan2(-minus_sin_y, cos_y),
    )
    about_z = np.where(locked, 0.0, np.arctan2(-minus_sin_z, cos_z))
    return np.stack((about_z, np.arctan2(2.0 * (y * z + w * x), cos_x), about_y), axis=-1)


def smooth_angles(angles: Float64) -> Float64:
    """Return the same rotations (T, ..., 3) with the angles of each frame nearest to those of the previous frame.

    A rotation has two triples (z, x, y) and (z + π, π - x, y + π), each modulo whole turns. Programs that interpolate
    channels would otherwise spin joints between two frames.
    """
    result = angles.copy()
    turn = 2.0 * np.pi
    for frame in range(1, len(angles)):
        first = angles[frame]
        second = np.stack((first[..., 0] + np.pi, np.pi - first[..., 1], first[..., 2] + np.pi), axis=-1)
        before = result[frame - 1]
        near = [triple + turn * np.round((before - triple) / turn) for triple in (first, second)]
        ways = [np.abs(triple - before).sum(axis=-1, keepdims=True) for triple in near]
        result[frame] = np.where(ways[0] <= ways[1], near[0], near[1])
    return result


FRAME_RATE: Final = 60.0
"""Frames per second of the files that the engine writes."""
UNITS_PER_METRE: Final = 100.0
_TURNS: Final = "Zrotation Xrotation Yrotation"


def write_bvh(clip: Clip, *, rate: float | None = FRAME_RATE) -> str:
    """Return the clip as BVH text, `rate` frames per second (None: one frame per sample of the clip).

    Six decimals: after a round trip joints are within 1e-5 m. For compatibility the root's OFFSET is zero, so a reader
    may add the position channels to it or replace it (Blender subtracts, others add). Every joint has an OFFSET or End
    Site of nonzero length, because Blender makes bones of them and drops those without. Names have no spaces. In
    Blender: File, Import, Motion Capture, scale 0.01, and "Update Scene FPS".
    """
    if rate is not None:
        clip = resample(clip, rate)
    lines = ["HIERARCHY", *_joint(0, 0), "MOTION", f"Frames: {clip.sample_count}"]
    lines.append(f"Frame Time: {1.0 / clip.sample_rate:.10g}")
    angles = np.degrees(smooth_angles(zxy_angles(clip.rotation)))
    root = clip.root_position.astype(np.float64) * UNITS_PER_METRE
    values = np.concatenate((root, angles.reshape(clip.sample_count, -1)), axis=1)
    values = np.round(values, 6) + 0.0  # no -0.000000
    row = " ".join(["%.6f"] * values.shape[1])
    lines += [row % tuple(frame) for frame in values.tolist()]
    return "\n".join(lines) + "\n"


def _joint(joint: int, depth: int) -> list[str]:
    """Return the lines of a joint and its descendants."""
    tab = "\t" * depth
    is_root = joint == 0
    offset = (0.0, 0.0, 0.0) if is_root else tuple(SKELETON.offsets[joint].astype(np.float64))
    lines = [
        f"{tab}{'ROOT' if is_root else 'JOINT'} {SKELETON.names[joint]}",
        tab + "{",
        f"{tab}\tOFFSET {_format_offset(offset)}",
        f"{tab}\tCHANNELS " + (f"6 Xposition Yposition Zposition {_TURNS}" if is_root else f"3 {_TURNS}"),
    ]
    for child in np.flatnonzero(SKELETON.parents == joint):
        lines += _joint(int(child), depth + 1)
    if joint in BONE_TIPS:
        lines += [tab + "\tEnd Site", tab + "\t{", f"{tab}\t\tOFFSET {_format_offset(BONE_TIPS[joint])}", tab + "\t}"]
    return [*lines, tab + "}"]


def _format_offset(offset: tuple[float, ...]) -> str:
    return " ".join(f"{round(UNITS_PER_METRE * metres, 4) + 0.0:.6f}" for metres in offset)


def stage_bvh(motion: StageMotion) -> StageFiles:
    """Return a BVH file for each dancer, in the places of the stage; several are numbered from 1.

    A dancer who is not on the stage stands where the steps left them: BVH cannot hide anybody.
    """
    digits = len(str(len(motion.dancers)))
    return {
        f"-{number:0{digits}d}" if len(motion.dancers) > 1 else "": write_bvh(dancer.clip, rate=None).encode("ascii")
        for number, dancer in enumerate(motion.dancers, start=1)
    }
