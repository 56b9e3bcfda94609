"""Whether the OFFSET of a BVH file's root is to be added to its position channels, or already in them."""

import numpy as np
import numpy.typing as npt

from live.motion.formats.parse import BvhMotion
from live.motion.formats.source_axes import leg_length
from live.motion.formats.source_motion import OffsetUse, UpAxis
from live.motion.retarget.joint_mapping import SourceBody


def find_root_offset(
    motion: BvhMotion, body: SourceBody, positions: npt.NDArray[np.floating], up: UpAxis
) -> OffsetUse | None:
    """The use of the root's OFFSET that brings the lowest joint nearer to zero height.

    `positions` (T, J, 3) are those with the OFFSET added, as the format says (T164). One frame alone is no evidence
    (None: then add).
    """
    if has_no_root_offset(motion):
        return "zero"
    if motion.frame_count < 2:
        return None
    axis = "XYZ".index(up)
    floor = float(np.median(positions[:, :, axis].min(axis=1)))
    raised = float(motion.offsets[0, axis])
    if abs(raised) < 0.05 * leg_length(body, positions):
        return None  # both readings stand equally well
    return "add" if abs(floor) <= abs(floor - raised) else "replace"


def has_no_root_offset(motion: BvhMotion) -> bool:
    """Whether the question does not arise: OFFSET is zero, or the root has no position channels."""
    return not motion.offsets[0].any() or not any(letter.islower() for letter in motion.channels[0])
