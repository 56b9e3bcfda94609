"""What a BVH file means: its channels as translations and rotations, with the root's OFFSET used as it should be."""

from dataclasses import replace
from typing import Final

import numpy as np

from live.motion.formats.parse import BvhMotion
from live.motion.formats.pose import local_pose
from live.motion.formats.root_offset import find_root_offset, has_no_root_offset
from live.motion.formats.source_axes import find_up
from live.motion.formats.source_motion import FileWarning, OffsetUse, SourceMotion, UpAxis
from live.motion.formats.source_pose import LocalPose, world_pose
from live.motion.retarget.joint_mapping import find_body

SEEN_FRAMES: Final = 500
"""Frames, evenly spread, by which it is decided what the file does not say."""


def source_of_bvh(motion: BvhMotion, up: UpAxis | None = None) -> SourceMotion:
    """The motion of a BVH file in its own units and axes.

    `up` is the axis that points up, if a person has said so; by it and by ground contact it is decided whether the
    root's OFFSET is added (as T164 has it) or replaced. Position channels of other joints: see `local_pose`.
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
    use = _decide(motion, source, up)
    if use == "replace":
        moving = ["XYZ".index(letter.upper()) for letter in motion.channels[0] if letter.islower()]
        local.translation[:, 0, moving] -= motion.offsets[0, moving]
    for array in (local.translation, local.rotation):
        array.setflags(write=False)
    return replace(source, root_offset=use)


def _decide(motion: BvhMotion, source: SourceMotion, up: UpAxis | None) -> OffsetUse | None:
    if has_no_root_offset(motion):
        return "zero"
    body = find_body(source)
    if body.missing:
        return None
    frames = np.unique(np.linspace(0, motion.frame_count - 1, SEEN_FRAMES).astype(np.int64))
    seen = world_pose(source.parents, LocalPose(source.translation[frames], source.rotation[frames]))
    return find_root_offset(motion, body, seen.positions, up or find_up(body, seen.positions) or "Y")
