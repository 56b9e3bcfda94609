"""The figures of one step: slide and skating, jumps of velocity and acceleration, bone lengths."""

import math

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.editing.feet import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.feet import skates, slides
from live.motion.quality.smoothness import accelerations, velocity_changes
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]


class StepFigures:
    """The figures of one step, over its measures (lead-in and tail left out)."""

    def __init__(self, step: StepClip) -> None:
        first = int(step.first)
        last = math.ceil(step.first + step.measures * step.samples_per_measure)
        part = slice(first, last + 1)
        self._rate = step.clip.sample_rate
        self._contact = step.clip.contact[part]
        self._rotation = step.clip.rotation[part].astype(np.float64)
        self._position, _ = forward_kinematics(step.clip.root_position[part].astype(np.float64), self._rotation)

    @property
    def slides(self) -> Float64:
        """Speeds over the floor [m/s] of feet in contact, of heel and ball the stiller; contact is the clip's own."""
        return slides(self._position, self._contact, self._rate)

    @property
    def slide(self) -> float | None:
        """Their mean; None if no foot is ever in contact."""
        found = self.slides
        return float(found.mean()) if len(found) else None

    @property
    def skating(self) -> float:
        """Share of frames, of 20 a second, in which a foot skates."""
        found = skates(self._position, self._rate)
        return float(found.mean()) if len(found) else 0.0

    @property
    def velocity_jump(self) -> float:
        """Largest change of any joint's velocity from one sample to the next [m/s]."""
        return float(velocity_changes(self._position, self._rate).max(initial=0.0))

    @property
    def accelerations(self) -> Float64:
        """Acceleration of each joint [m/s²], velocities averaged over three samples, shape (n, J)."""
        return accelerations(self._position, self._rate)

    @property
    def bone_error(self) -> float:
        """Largest deviation of a bone's length from the skeleton's [m], as a renderer of matrices would see it."""
        error = 0.0
        for joint, parent in enumerate(SKELETON.parents):
            if parent >= 0:
                length = np.linalg.norm(self._position[:, joint] - self._position[:, parent], axis=-1)
                error = max(error, float(np.abs(length - np.linalg.norm(SKELETON.offsets[joint])).max()))
        return error

    @property
    def below_floor(self) -> float:
        """How far the lowest sole goes below the floor [m]."""
        heel = self._position[:, ANKLES, 1] - SOLE_BELOW_ANKLE
        ball = self._position[:, BALLS, 1] - TOES_OVER_SOLE
        return float(max(0.0, -np.minimum(heel, ball).min()))


def pelvis_way(before: Clip, after: Clip) -> float:
    """How far the pelvis was moved by an edit at most [m]."""
    return float(np.linalg.norm(after.root_position - before.root_position, axis=-1).max())
