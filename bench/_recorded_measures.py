"""Many recorded measures for benches: those of real recordings, each held, timed and mirrored a little differently."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench._motion_clips import SALSA, WALKS, Material, measures_of, recordings
from live.motion import quaternion
from live.motion.editing.time_warp import draw_measure_warps, warp_step
from live.motion.mirror import mirror_step
from live.motion.skeleton import JOINT_COUNT
from live.motion.step_clip import StepClip, measured_direction

FILES = (*(name for name in SALSA if int(name[-5]) <= 4), WALKS[1])
HABIT = 0.04
"""Standard deviation of the angle at which each joint is held differently [rad]."""


def varied_measures(shared: Path | None, count: int, seed: int = 1) -> list[StepClip]:
    """Return `count` measures, each as `live steps add` would cut it; none without the recordings."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    own = [measure for each in recordings(folder, FILES) for measure in single_measures(each)]
    chance = np.random.default_rng(seed)
    return [varied(own[n % len(own)], chance, bool(chance.random() < 0.5)) for n in range(count)] if own else []


def single_measures(material: Material) -> list[StepClip]:
    """Return every measure of a recording as a step of its own."""
    first = material.steps[0]
    anchor = (first.first - min(first.first, first.samples_per_measure)) / material.clip.sample_rate
    cut = measures_of(material.clip, first.step, anchor, first.bpm, 1)
    return [replace(step, direction=measured_direction(step)) for step in cut]


def varied(step: StepClip, chance: np.random.Generator, mirrored: bool) -> StepClip:
    """Return a measure warped in time, its joints held a little differently, and mirrored or not."""
    step = warp_step(step, draw_measure_warps(chance, 1))
    if mirrored:
        step = mirror_step(step)
    axis = chance.normal(size=(JOINT_COUNT, 3))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    habit = quaternion.from_axis_angle(axis, chance.normal(0.0, HABIT, JOINT_COUNT))
    rotation = quaternion.unit(quaternion.mul(step.clip.rotation.astype(np.float64), habit)).astype(np.float32)
    return replace(step, clip=replace(step.clip, rotation=rotation))
