"""The other side of the body: what the right does, the left does (T042)."""

from dataclasses import replace

import numpy as np

from live.motion.clip import Clip
from live.motion.skeleton import MIRROR
from live.motion.step_clip import StepClip

_REFLECTION = np.array((-1.0, 1.0, 1.0), np.float32)
_ROTATION_REFLECTION = np.array((1.0, 1.0, -1.0, -1.0), np.float32)


def mirror_clip(clip: Clip, name: str | None = None) -> Clip:
    """The clip reflected in the plane x = 0, left and right joints exchanged (T042); `name` as given or kept."""
    return Clip(
        name=clip.name if name is None else name,
        root_position=clip.root_position * _REFLECTION,
        rotation=np.ascontiguousarray(clip.rotation[:, MIRROR] * _ROTATION_REFLECTION),
        sample_rate=clip.sample_rate,
        contact=np.ascontiguousarray(clip.contact[:, ::-1]),
    )


def mirror_step(step: StepClip) -> StepClip:
    """The step danced on the other side: mirrored motion, the other direction, `mirrored` turned over (T042)."""
    direction = step.direction
    if "left" in direction:
        direction = direction.replace("left", "right")
    else:
        direction = direction.replace("right", "left")
    name = step.clip.name.removesuffix(" (mirrored)")
    if not step.mirrored:
        name += " (mirrored)"
    return replace(step, clip=mirror_clip(step.clip, name), direction=direction, mirrored=not step.mirrored)
