"""Steps for tests of the editing tools: the project's own sketches, and short random clips."""

from functools import cache

import numpy as np

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import StepClip
from tests.places import ROOT

STEPS = ROOT / "patches" / "steps"


@cache
def sketched_step(name: str, direction: str = "in place") -> StepClip:
    """One of the project's sketches, e.g. "walk"; built once per test run."""
    path = STEPS / f"{name}.toml"
    return step_clip(parse_sketch(path.read_text(encoding="utf-8"), path.name), direction)


def random_clip(seed: int, samples: int = 60, joints: int = JOINT_COUNT) -> Clip:
    """A smooth random motion: every joint swings about a random pose."""
    chance = np.random.default_rng(seed)
    time = np.linspace(0.0, 2.0 * np.pi, samples)[:, None, None]
    swing = chance.uniform(-0.8, 0.8, (1, joints, 3)) * np.sin(time + chance.uniform(0, 6, (1, joints, 3)))
    rest = quaternion.unit(chance.normal(size=(1, joints, 4)))
    angle = np.linalg.norm(swing, axis=-1)
    rotation = quaternion.mul(rest, quaternion.from_axis_angle(swing + 1e-12, angle))
    root = chance.uniform(-1, 1, 3) + 0.2 * np.sin(time[:, 0] + chance.uniform(0, 6, 3))
    contact = chance.random((samples, 2)) < 0.5
    return Clip(f"random {seed}", root.astype(np.float32), np.ascontiguousarray(rotation, np.float32), 60.0, contact)


def random_step(seed: int, name: str = "step") -> StepClip:
    """A step of one measure of 40 samples after a lead-in of 12 and a fraction."""
    return StepClip(step=name, clip=random_clip(seed), first=12.4, samples_per_measure=40.0)
