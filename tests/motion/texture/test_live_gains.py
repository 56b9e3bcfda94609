"""Live texture is as strong as what it copies is true at other choreographies."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import SPREAD_FACTOR, TextureBank, deviations
from live.motion.texture.texture_settings import UPPER
from tests.motion.texture.made_dance import RATE, at_beats


def groove(seconds: float, seed: int) -> StepClip:
    """Legs and arms that swing together once in two beats, a little larger or smaller."""
    chance = np.random.default_rng(seed)
    t = np.arange(int(seconds * RATE) + 1) / RATE
    swing = chance.uniform(0.2, 0.3) * np.sin(2.0 * np.pi * t + chance.uniform(0.0, 2.0 * np.pi))
    vector = np.zeros((len(t), JOINT_COUNT, 3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        vector[:, SKELETON.index(side + "UpperLeg"), 0] = sign * swing
        vector[:, SKELETON.index(side + "UpperArm"), 0] = -2.0 * sign * swing
        vector[:, SKELETON.index(side + "LowerArm"), 0] = -sign * swing
    step = at_beats(seconds, seed, 0.0)
    return replace(step, clip=replace(step.clip, rotation=quaternion.from_rotation_vector(vector).astype(np.float32)))


@pytest.mark.long
def test_arms_that_follow_legs_are_copied_whole_and_others_hardly() -> None:
    told = TextureBank.of([groove(20.0, seed) for seed in range(3)])
    untold = TextureBank.of([at_beats(40.0, seed, 0.0) for seed in range(4)])
    arms = [n for n, joint in enumerate(UPPER) if joint >= 6]
    assert (told.scale + told.told.gains)[arms].min() > 0.9
    assert untold.told.gains[arms].max() < 0.35
    assert untold.scale[arms].max() < 0.35 * SPREAD_FACTOR
    assert np.isfinite(untold.upper).all()
    assert np.abs(np.linalg.norm(untold.upper, axis=-1) - 1.0).max() < 1e-5
    spread = np.abs(deviations(untold.upper, untold.mean_rotations.astype(np.float64))).mean(axis=(0, 2))
    assert (spread[untold.scale == 0.0] < 1e-3).all()


def test_one_short_recording_is_copied_as_it_is() -> None:
    bank = TextureBank.of([at_beats(3.0, 1, 0.0)])
    assert bank.scale.min() == 1.0
