"""Quality of one step, and what an edit moved: what the bench of motion quality measures."""

import math

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.foot_contact import TOES_OVER_SOLE
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.metrics import accelerations, contact_slide_speeds, skating_frames, velocity_changes
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]


class StepMetrics:
    """Metrics of one step over its measures (without lead-in and tail)."""

    def __init__(self, step: StepClip) -> None:
        first = int(step.first)
        last = math.ceil(step.first + step.measures * step.samples_per_measure)
        part = slice(first, last + 1)
        self._rate = step.clip.sample_rate
        self._contact = step.clip.contact[part]
        self._rotation = step.clip.rotation[part].astype(np.float64)
        self._position, _ = forward_kinematics(step.clip.root_position[part].astype(np.float64), self._rotation)

    @property
    def contact_speeds(self) -> Float64:
        """Horizontal speeds [m/s] of feet in contact (the clip's annotation), the slower of heel and ball."""
        return contact_slide_speeds(self._position, self._contact, self._rate)

    @property
    def mean_slide(self) -> float | None:
        """Mean of `slide_speeds`; None if no foot is ever in contact."""
        found = self.contact_speeds
        return float(found.mean()) if len(found) else None

    @property
    def skating(self) -> float:
        """Share of frames, at 20 per second, in which a foot skates."""
        found = skating_frames(self._position, self._rate)
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
        """Largest deviation of a bone's length from the skeleton's [m], from world joint positions."""
        error = 0.0
        for joint, parent in enumerate(SKELETON.parents):
            if parent >= 0:
                length = np.linalg.norm(self._position[:, joint] - self._position[:, parent], axis=-1)
                error = max(error, float(np.abs(length - np.linalg.norm(SKELETON.offsets[joint])).max()))
        return error

    @property
    def below_floor(self) -> float:
        """Depth of the lowest sole below the floor [m]."""
        heel = self._position[:, ANKLES, 1] - SOLE_BELOW_ANKLE
        ball = self._position[:, BALLS, 1] - TOES_OVER_SOLE
        return float(max(0.0, -np.minimum(heel, ball).min()))


def pelvis_displacement(before: Clip, after: Clip) -> float:
    """Return the largest displacement of the pelvis by an edit [m]."""
    return float(np.linalg.norm(after.root_position - before.root_position, axis=-1).max())
