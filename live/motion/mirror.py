"""Mirroring of clips and steps: left and right exchanged (T042)."""

import re
from dataclasses import replace
from typing import Final

import numpy as np

from live.motion.clip import Clip
from live.motion.skeleton import MIRROR
from live.motion.step_clip import LeadingFoot, StepClip

_OTHER_FOOT: Final[dict[LeadingFoot, LeadingFoot]] = {"": "", "left": "right", "right": "left"}
_SIDE: Final = re.compile(r"\b(left|right)\b", re.IGNORECASE)
_REFLECTION = np.array((-1.0, 1.0, 1.0), np.float32)
_ROTATION_REFLECTION = np.array((1.0, 1.0, -1.0, -1.0), np.float32)


def mirror_clip(clip: Clip, name: str | None = None) -> Clip:
    """Return the clip mirrored in the plane x = 0, left and right joints exchanged (T042); `name` replaces its name."""
    return Clip(
        name=clip.name if name is None else name,
        root_position=clip.root_position * _REFLECTION,
        rotation=np.ascontiguousarray(clip.rotation[:, MIRROR] * _ROTATION_REFLECTION),
        sample_rate=clip.sample_rate,
        contact=np.ascontiguousarray(clip.contact[:, ::-1]),
    )


def swap_sides(text: str) -> str:
    """Return the text with left and right exchanged: "left foot in front" becomes "right foot in front"."""

    def exchange(found: re.Match[str]) -> str:
        word = "right" if found[0].lower() == "left" else "left"
        return word.upper() if found[0].isupper() else word.capitalize() if found[0][0].isupper() else word

    return _SIDE.sub(exchange, text)


MIRRORED_SUFFIX: Final = " (mirrored)"


def unmirrored_name(name: str) -> str:
    """Return the name of the clip of which this may be the mirror image."""
    return name.removesuffix(MIRRORED_SUFFIX)


def mirror_step(step: StepClip) -> StepClip:
    """Return the step mirrored (T042): motion, direction, leading foot and pose names.

    `mirrored` is inverted.
    """
    name = unmirrored_name(step.clip.name)
    if not step.mirrored:
        name += MIRRORED_SUFFIX
    return replace(
        step,
        clip=mirror_clip(step.clip, name),
        direction=swap_sides(step.direction),
        mirrored=not step.mirrored,
        leading_foot=_OTHER_FOOT[step.leading_foot],
        begin_pose=swap_sides(step.begin_pose),
        end_pose=swap_sides(step.end_pose),
        hands=tuple((beat, right, left) for beat, left, right in step.hands),
    )
