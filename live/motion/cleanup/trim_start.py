"""Start of a recording: detection of a T-pose added by a converter, and of a smoothed run-in from it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.retarget.body_tracks import BODY_SIDES, BodyTracks

MAX_ARM_SLOPE: Final = 0.35
"""Sine of the largest angle between a T-pose's arm and the horizontal."""
MAX_ARM_COSINE: Final = -0.85
"""Cosine of the smallest angle between its arms."""
MIN_JUMP: Final = 0.2
"""Minimum distance of an added T-pose from the first recorded pose [m]."""
RUN_IN_SPEED_RATIO: Final = 2.0
"""A run-in is faster than the 99th percentile of the dance by this factor ..."""
MIN_RUN_IN_SPEED: Final = 8.0
"""... and than this [m/s]."""
MIN_FRAMES: Final = 8
"""Shorter recordings [frames] are not checked."""
MAX_RUN_IN: Final = 0.5
"""Longer run-ins [s] count as dancing."""


@dataclass(frozen=True, slots=True)
class RecordingStart:
    """Frames before the recorded motion."""

    t_pose_first: bool
    """The first frame is an added T-pose."""
    drop_frames: int
    """Leading frames to drop (0 if nothing was added)."""


def find_recording_start(tracks: BodyTracks) -> RecordingStart:
    """Find an added T-pose in the first frame and the end of the run-in from it.

    A run-in slows down from frame to frame until the recorded pose is reached; it ends where the body is slowest.
    """
    if tracks.frame_count < MIN_FRAMES or not _is_t_pose(tracks):
        return RecordingStart(False, 0)
    longest = max(2, round(MAX_RUN_IN * tracks.rate))
    way = np.linalg.norm(np.diff(tracks.positions, axis=0), axis=-1).max(axis=1)
    if way[0] < MIN_JUMP:
        return RecordingStart(False, 0)
    usual = float(np.percentile(way[min(longest, way.size // 2) :], 99.0))
    fastest = 1 + int(np.argmax(way[1:4]))
    if way[fastest] < max(RUN_IN_SPEED_RATIO * usual, MIN_RUN_IN_SPEED / tracks.rate):
        return RecordingStart(True, 1)
    end = fastest
    while end + 1 < min(way.size, longest) and way[end + 1] < way[end]:
        end += 1
    return RecordingStart(True, end + 1)


def _is_t_pose(tracks: BodyTracks) -> bool:
    arms: list[Float64] = []
    for side, palm in zip(BODY_SIDES, tracks.palms[0].copy(), strict=True):
        shoulder = tracks.column(side + "UpperArm")
        arm = palm - tracks.positions[0, 0 if shoulder is None else shoulder]
        arms.append(arm / max(float(np.linalg.norm(arm)), 1e-9))
    level = max(abs(float(arm[1])) for arm in arms)
    return level <= MAX_ARM_SLOPE and float(arms[0] @ arms[1]) <= MAX_ARM_COSINE
