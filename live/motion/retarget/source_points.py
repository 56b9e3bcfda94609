"""A recorded body as points and rotations in Y-up axes, with the tips of its hands and feet."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.source_motion import SourceMotion, UpAxis
from live.motion.formats.source_pose import WorldPose, end_positions, rest_pose
from live.motion.retarget.joint_mapping import SourceBody
from live.motion.retarget.rest_pose_alignment import SIDES, SourcePoints

Float = npt.NDArray[np.floating]

_Z_UP_TO_Y_UP: Final = np.array((np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0))


def source_points(motion: SourceMotion, body: SourceBody, world: WorldPose, axis: UpAxis) -> SourcePoints:
    """A body's poses in the `world` in Y-up axes, lengths in its own unit, with the tips of hands and feet.

    MotionFileError if nothing ends a lower arm.
    """
    ends = end_positions(motion, world)
    positions, rotations = world.positions, world.rotations
    if axis == "Z":
        ends, positions = (quaternion.rotate(_Z_UP_TO_Y_UP, points) for points in (ends, positions))
        rotations = quaternion.mul(_Z_UP_TO_Y_UP, rotations)
    tips: dict[str, Float] = {}
    for side, _ in SIDES:
        for joint, child in (("LowerArm", "Hand"), ("Foot", "Toes"), ("Hand", "HandEnd")):
            source = body.joints[side + joint]
            if source is not None and body.joints.get(side + child) is None:
                tip = _tip(motion, source, positions, ends)
                if tip is not None:
                    tips[side + child] = tip
        if not (body.joints[side + "Hand"] is not None or side + "Hand" in tips):
            raise MotionFileError(
                motion.file, None, f"nothing ends the {side} lower arm", "a hand or an End Site expected"
            )
    return SourcePoints(body, positions, rotations, tips)


def _tip(motion: SourceMotion, joint: int, positions: Float, ends: Float) -> Float | None:
    """Mean of what hangs on a joint (thumbs left out), (T, 3); None if nothing does or if it is the joint itself."""
    children = [c for c in np.flatnonzero(motion.parents == joint) if "thumb" not in motion.names[c].lower()]
    places = [positions[:, c] for c in children] + [ends[:, e] for e in np.flatnonzero(motion.end_parents == joint)]
    distant = [place for place in places if np.median(np.linalg.norm(place - positions[:, joint], axis=-1)) > 1e-6]
    return np.mean(distant, axis=0) if distant else None


def rest_points(motion: SourceMotion, body: SourceBody, axis: UpAxis) -> SourcePoints:
    """The same of its rest pose, a single sample."""
    return source_points(motion, body, rest_pose(motion), axis)
