"""Clips as BVH files: the engine's skeleton in centimetres, Y up, rotations in the order ZXY (T164)."""

from typing import Final

import numpy as np

from live.motion.bone_tips import BONE_TIPS
from live.motion.clip import Clip
from live.motion.formats.angles import smooth_angles, zxy_angles
from live.motion.resample import resample
from live.motion.skeleton import SKELETON

FRAME_RATE: Final = 60.0
"""Frames per second of the files that the engine writes."""
UNITS_PER_METRE: Final = 100.0
_TURNS: Final = "Zrotation Xrotation Yrotation"


def write_bvh(clip: Clip, *, rate: float | None = FRAME_RATE) -> str:
    """The text of a BVH file of the clip, `rate` frames per second (None: one frame per sample of the clip).

    Six decimals: read again, joints are within 1e-5 m of where they were. What programs rely on: the root's OFFSET is
    zero, so that it does not matter whether a reader adds its position channels to it or takes them in its place
    (Blender subtracts, others add); every joint has an OFFSET or End Site of some length, for Blender makes bones of
    them and drops those without; names hold no spaces. In Blender: File, Import, Motion Capture, scale 0.01, and
    "Update Scene FPS".
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
    """The lines of a joint and of all below it."""
    tab = "\t" * depth
    is_root = joint == 0
    offset = (0.0, 0.0, 0.0) if is_root else tuple(SKELETON.offsets[joint].astype(np.float64))
    lines = [
        f"{tab}{'ROOT' if is_root else 'JOINT'} {SKELETON.names[joint]}",
        tab + "{",
        f"{tab}\tOFFSET {_shown(offset)}",
        f"{tab}\tCHANNELS " + (f"6 Xposition Yposition Zposition {_TURNS}" if is_root else f"3 {_TURNS}"),
    ]
    for child in np.flatnonzero(SKELETON.parents == joint):
        lines += _joint(int(child), depth + 1)
    if joint in BONE_TIPS:
        lines += [tab + "\tEnd Site", tab + "\t{", f"{tab}\t\tOFFSET {_shown(BONE_TIPS[joint])}", tab + "\t}"]
    return [*lines, tab + "}"]


def _shown(offset: tuple[float, ...]) -> str:
    return " ".join(f"{round(UNITS_PER_METRE * metres, 4) + 0.0:.6f}" for metres in offset)
