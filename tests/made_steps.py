"""Step clips made from nothing for tests of the graph and the show: an upright figure that glides and waves.

They are no dance. What matters is that their lengths, ways and poses are known exactly.
"""

import math

import numpy as np

from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip

SAMPLES_PER_BEAT = 8


def made_clip(
    step: str,
    *,
    way: tuple[float, float] = (0.0, 0.0),
    measures: int = 1,
    beats: int = 4,
    turn: float = 0.0,
    arm: float = 1.2,
    direction: str = "in place",
) -> StepClip:
    """A step of `measures` that goes `way` (x, z) [m] and turns by `turn` [rad] per measure, arms at `arm` [rad]."""
    per_measure = SAMPLES_PER_BEAT * beats
    count = per_measure * (measures + 1) + 1
    phase = (np.arange(count) - per_measure) / per_measure
    root = np.zeros((count, 3), np.float32)
    root[:, 0], root[:, 2] = way[0] * phase, way[1] * phase
    root[:, 1] = 0.93 + 0.02 * np.cos(2 * np.pi * phase * beats)
    rotation = np.zeros((count, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    rotation[:, 0, 0], rotation[:, 0, 2] = np.cos(turn * phase / 2), np.sin(turn * phase / 2)
    for name, sign in (("leftUpperArm", -1.0), ("rightUpperArm", 1.0)):
        joint = SKELETON.index(name)
        rotation[:, joint, 0], rotation[:, joint, 3] = math.cos(arm / 2), sign * math.sin(arm / 2)
    contact = np.ones((count, 2), np.bool_)
    clip = Clip(step, root, rotation, SAMPLES_PER_BEAT * 2.0, contact)
    return StepClip(
        step=step,
        clip=clip,
        first=float(per_measure),
        samples_per_measure=float(per_measure),
        measures=measures,
        beats_per_measure=beats,
        direction=direction,
    )


def made_steps() -> list[StepClip]:
    """A sway on the spot, a glide in five directions, a turn, and a phrase of two measures."""
    ways = {"in place": (0.0, 0.0), "long forward": (0.0, 0.8), "long right": (-0.8, 0.0)}
    ways |= {"long left": (0.8, 0.0), "long back": (0.0, -0.8)}
    return [
        made_clip("sway"),
        *(made_clip("glide", way=way, direction=name, arm=1.1) for name, way in ways.items()),
        made_clip("spin", turn=2 * math.pi, arm=1.0),
        made_clip("phrase", measures=2, arm=1.15),
    ]
