"""Recordings for tests, as SourceMotion: the body of `made_bvh` without a file, and motions for it."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from live.motion.formats.source_motion import SourceMotion
from tests.motion.formats.made_bvh import BODY, NAMES, STANDING_CM, column, dance_values, still

PARENTS = tuple(NAMES.index(parent) if parent else -1 for _, parent, _ in BODY)


def source(values: np.ndarray, fps: float = 60.0, name: str = "made") -> SourceMotion:
    """`values` as in `made_bvh.body_bvh`: hips position [cm], then Z, X, Y rotations [degrees] per joint."""
    frames, joints = len(values), len(NAMES)
    angles = values[:, 3:].reshape(-1, 3)
    rotation = Rotation.from_euler("ZXY", angles, degrees=True).as_quat()[:, [3, 0, 1, 2]].reshape(frames, joints, 4)
    offsets = np.array([offset for _, _, offset in BODY])
    translation = np.broadcast_to(offsets, (frames, joints, 3)).copy()
    translation[:, 0] = values[:, :3]
    ends = [j for j in range(joints) if j not in PARENTS]
    return SourceMotion(
        file=name,
        names=NAMES,
        parents=np.array(PARENTS, np.int32),
        offsets=offsets,
        end_parents=np.array(ends, np.int32),
        end_offsets=0.3 * offsets[ends],
        translation=translation,
        rotation=rotation,
        rest_rotation=None,
        frame_time=1.0 / fps,
        frames_declared=frames,
        channel_count=3 + 3 * joints,
    )


def moving_values(seconds: float, fps: float, seed: int = 5) -> np.ndarray:
    """A body that moves every joint smoothly, at any frame rate: `made_bvh.dance_values` at a dancer's speed."""
    slow = dance_values(round(40 * seconds), seed)
    place = np.arange(round(seconds * fps)) / (seconds * fps) * (len(slow) - 1)
    return np.stack([np.interp(place, np.arange(len(slow)), one) for one in smooth(slow).T], axis=1)


def smooth(values: np.ndarray) -> np.ndarray:
    """A weak low-pass filter, so that interpolation between the frames has no corners."""
    kernel = np.hanning(9) / np.hanning(9).sum()
    padded = np.pad(values, ((4, 4), (0, 0)), mode="edge")
    return np.stack([np.convolve(one, kernel, mode="valid") for one in padded.T], axis=1)


def clapping_values(apart_cm: Callable[[np.ndarray], np.ndarray], seconds: float, fps: float) -> np.ndarray:
    """A standing body whose palms are `apart_cm(time)` apart; 0 to 143 cm is possible.

    The straight arms swing symmetrically about the vertical axis: the palms are
    2 (shoulder + reach cos(angle)) apart, which is solved for the angle.
    """
    time = np.arange(round(seconds * fps)) / fps
    wanted = apart_cm(time)
    shoulder = 3.0 + 14.0  # clavicle and shoulder [cm beside the spine], then the straight arm to the palm
    reach = 27.0 + 24.0 + 0.5 * 0.3 * 24.0
    half = np.clip((0.5 * wanted - shoulder) / reach, -1.0, 1.0)
    angle = np.degrees(np.arccos(half))  # 0: straight out to the side, 90: straight ahead
    values = still(len(time))
    values[:, column("LeftArm", "Y")] = -angle
    values[:, column("RightArm", "Y")] = angle
    return values


__all__ = ["BODY", "NAMES", "STANDING_CM", "clapping_values", "column", "moving_values", "source", "still"]
