"""Synthetic recordings for tests of texturing: dances with arms that follow the legs, sketches without arms."""

from dataclasses import replace

import numpy as np

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.skeleton import JOINT_COUNT, SKELETON
from live.motion.step_clip import StepClip
from live.motion.texture.texture_settings import UPPER

RATE = 60.0
BEAT = 30.0
"""Samples of a beat: 120 bpm."""


def dance(seconds: float, seed: int) -> StepClip:
    """A dancer whose legs swing at several frequencies about one beat, while her arms swing against them."""
    chance = np.random.default_rng(seed)
    count = int(seconds * RATE) + 1
    t = np.arange(count) / RATE
    swing = sum(
        chance.uniform(0.1, 0.25) * np.sin(2.0 * np.pi * hertz * t + chance.uniform(0.0, 6.0))
        for hertz in (0.5, 1.0, 1.1, 2.0)
    )
    vector = np.zeros((count, JOINT_COUNT, 3))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        vector[:, SKELETON.index(side + "UpperLeg"), 0] = sign * swing
        vector[:, SKELETON.index(side + "LowerLeg"), 0] = 0.3 + 0.5 * np.abs(swing)
        vector[:, SKELETON.index(side + "UpperArm"), 2] = -sign * 1.2
        vector[:, SKELETON.index(side + "UpperArm"), 0] = -sign * 1.5 * swing
        vector[:, SKELETON.index(side + "LowerArm"), 1] = -sign * (0.4 + 0.3 * swing)
    vector[:, SKELETON.index("chest"), 1] = 0.3 * swing
    root = np.zeros((count, 3), np.float32)
    root[:, 1] = 0.9
    contact = np.stack((swing > 0.0, swing <= 0.0), axis=-1)
    rotation = quaternion.from_rotation_vector(vector).astype(np.float32)
    clip = Clip(f"dance {seed}", root, rotation, RATE, contact)
    return StepClip(clip.name, clip, 0.0, 4.0 * BEAT, int((count - 1) / (4.0 * BEAT)))


def without_arms(clip: Clip) -> Clip:
    """The same legs under an upper body at rest: a sketch."""
    rotation = clip.rotation.copy()
    rotation[:, list(UPPER)] = (1.0, 0.0, 0.0, 0.0)
    return replace(clip, name="sketch", rotation=rotation)


def improvisation(seconds: float, seed: int, told: float = 1.0) -> Clip:
    """A dancer whose four leg joints move without a period, and whose arms follow them by the share `told`, 0 to 1.

    The rest of the arms' movement, of the same size, is independent of the legs.
    """
    chance = np.random.default_rng(seed)
    count = int(seconds * RATE) + 1
    t = np.arange(count) / RATE

    def curves(number: int) -> np.ndarray:
        hertz = chance.uniform(0.2, 2.0, (1, number, 12))
        phase = chance.uniform(0.0, 2.0 * np.pi, (1, number, 12))
        return 0.12 * np.sin(2.0 * np.pi * hertz * t[:, None, None] + phase).sum(axis=-1)

    legs, own = curves(4), curves(4)
    vector = np.zeros((count, JOINT_COUNT, 3))
    for n, (leg, arm) in enumerate(
        (("leftUpperLeg", "rightUpperArm"), ("rightUpperLeg", "leftUpperArm"), ("leftLowerLeg", "rightLowerArm"),
         ("rightLowerLeg", "leftLowerArm"))
    ):  # fmt: skip
        vector[:, SKELETON.index(leg), 0] = legs[:, n]
        vector[:, SKELETON.index(arm), 0] = told * legs[:, n] + (1.0 - told) * own[:, n]
    root = np.zeros((count, 3), np.float32)
    root[:, 1] = 0.9
    rotation = quaternion.from_rotation_vector(vector).astype(np.float32)
    return Clip(f"improvisation {seed}", root, rotation, RATE, np.ones((count, 2), np.bool_))


def at_beats(seconds: float, seed: int, told: float) -> StepClip:
    """The same, with a beat."""
    clip = improvisation(seconds, seed, told)
    return StepClip(clip.name, clip, 0.0, 4.0 * BEAT, int((clip.sample_count - 1) / (4.0 * BEAT)))
