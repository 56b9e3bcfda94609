"""Figures of a motion's quality: slide and skating of feet, jumps of velocity and acceleration, bone lengths."""

import math

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.contact import TOES_OVER_SOLE
from live.motion.editing.feet import ANKLES, BALLS
from live.motion.forward import forward_kinematics
from live.motion.skeleton import SKELETON, SOLE_BELOW_ANKLE
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

SKATING_RATE = 20.0
SKATING_HEIGHT = 0.05
SKATING_SPEED = 0.5
"""Frames per second, metres and m/s of the skating ratio (GMD)."""
ACCELERATION_WINDOW = 3
"""Samples over which velocities are averaged before accelerations: recorded markers tremble."""


class Figures:
    """The figures of one step, over its measures (lead-in and tail left out)."""

    def __init__(self, step: StepClip) -> None:
        first = int(step.first)
        last = math.ceil(step.first + step.measures * step.samples_per_measure)
        part = slice(first, last + 1)
        self._clip = step.clip
        self._contact = step.clip.contact[part]
        self._rotation = step.clip.rotation[part].astype(np.float64)
        self._position, _ = forward_kinematics(step.clip.root_position[part].astype(np.float64), self._rotation)

    @property
    def slides(self) -> Float64:
        """Speeds over the floor [m/s] of feet in contact, of heel and ball the stiller; contact is the clip's own.

        Tools carry the annotation of the source clip along, so a foot that floats or flies is not excused.
        """
        feet = np.stack((self._position[:, ANKLES], self._position[:, BALLS]), axis=2)
        speed = np.hypot(*np.diff(feet, axis=0)[..., (0, 2)].transpose(3, 0, 1, 2)).min(axis=-1)
        return np.asarray(speed[self._contact[1:] & self._contact[:-1]] * self._clip.sample_rate, np.float64)

    @property
    def slide(self) -> float | None:
        """Their mean; None if no foot is ever in contact."""
        slides = self.slides
        return float(slides.mean()) if len(slides) else None

    @property
    def skating(self) -> float:
        """Share of frames in which a ball skates, at 20 frames/s: lower than 5 cm over its place on the floor in two
        adjacent frames, and faster than 0.5 m/s now and in the mean of five frames; either foot."""
        count = max(2, int((len(self._position) - 1) * SKATING_RATE / self._clip.sample_rate) + 1)
        at = np.minimum(np.arange(count) * self._clip.sample_rate / SKATING_RATE, len(self._position) - 1.0)
        low = at.astype(np.int64)
        part = (at - low)[:, None, None]
        after = np.minimum(low + 1, len(self._position) - 1)
        balls = (1.0 - part) * self._position[low][:, BALLS] + part * self._position[after][:, BALLS]
        speed = np.hypot(*np.diff(balls, axis=0)[..., (0, 2)].transpose(2, 0, 1)) * SKATING_RATE
        on_floor = balls[..., 1] - TOES_OVER_SOLE < SKATING_HEIGHT
        five = np.stack([np.convolve(speed[:, foot], np.full(5, 0.2), mode="same") for foot in (0, 1)], axis=1)
        skates = on_floor[1:] & on_floor[:-1] & (speed > SKATING_SPEED) & (five > SKATING_SPEED)
        return float(skates.any(axis=1).mean())

    @property
    def velocity_jump(self) -> float:
        """Largest change of any joint's velocity from one sample to the next [m/s]."""
        velocity = np.diff(self._position, axis=0) * self._clip.sample_rate
        return float(np.linalg.norm(np.diff(velocity, axis=0), axis=-1).max(initial=0.0))

    @property
    def accelerations(self) -> Float64:
        """Acceleration of each joint [m/s²], velocities averaged over three samples, shape (n, J)."""
        velocity = np.diff(self._position, axis=0) * self._clip.sample_rate
        windows = np.lib.stride_tricks.sliding_window_view(velocity, ACCELERATION_WINDOW, axis=0)
        change = np.diff(windows.mean(axis=-1), axis=0) * self._clip.sample_rate
        return np.asarray(np.linalg.norm(change, axis=-1), np.float64)

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
