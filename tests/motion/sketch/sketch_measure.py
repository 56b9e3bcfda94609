"""Measurements of finished clips for sketch tests: joint positions, soles, speeds."""

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

Float = npt.NDArray[np.float64]
SIDES = ("left", "right")


def joints(step: StepClip) -> tuple[Float, Float]:
    """World positions and rotations of all joints at all samples, in double precision."""
    return forward_kinematics(step.clip.root_position.astype(float), step.clip.rotation.astype(float))


def soles(step: StepClip, side: str) -> tuple[Float, Float, Float]:
    """World positions (T, 3) of the heel, the ball and the tip of the toes on the sole of one foot."""
    position, rotation = joints(step)
    foot, toes = SKELETON.index(f"{side}Foot"), SKELETON.index(f"{side}Toes")
    heel = position[:, foot] + quaternion.rotate(rotation[:, foot], np.array((0.0, -0.085, -0.05)))
    ball = position[:, toes] + quaternion.rotate(rotation[:, toes], np.array((0.0, -0.02, 0.0)))
    tip = position[:, toes] + quaternion.rotate(rotation[:, toes], np.array((0.0, -0.02, 0.07)))
    return heel, ball, tip


def slide(step: StepClip) -> float:
    """Greatest speed [m/s] of a foot in contact, at the slower of its ball and its heel."""
    worst = 0.0
    for index, side in enumerate(SIDES):
        heel, ball, _ = soles(step, side)
        planted = step.clip.contact[1:, index] & step.clip.contact[:-1, index]
        speeds = [np.linalg.norm(np.diff(point, axis=0), axis=1) * step.clip.sample_rate for point in (heel, ball)]
        worst = max(worst, float(np.max(np.minimum(*speeds)[planted], initial=0.0)))
    return worst


def first_and_last(step: StepClip) -> tuple[int, int]:
    """Samples at which the step begins and ends."""
    return round(step.first), round(step.first + step.measures * step.samples_per_measure)
