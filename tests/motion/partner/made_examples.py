"""Synthetic partner examples: hands and feet of two bodies that swing at random and differ in every unit."""

import numpy as np

from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud, cloud_of
from live.motion.partner.units import Example, Units, cut_units
from live.motion.skeleton import JOINT_COUNT, SKELETON


def made_cloud(chance: np.random.Generator, samples: int, rate: float, points: int = 4) -> Cloud:
    """Points [m] that move smoothly: sums of slow sines."""
    time = np.arange(samples) / rate
    waves = sum(
        chance.normal(0.0, 0.4 / n, (1, points, 3))
        * np.sin(
            2.0 * np.pi * chance.uniform(0.1, 0.6) * n * time[:, None, None] + chance.uniform(0, 6, (1, points, 3))
        )
        for n in range(1, 5)
    )
    return cloud_of(waves + np.array((0.0, 1.0, 0.0)), rate)


def standing(samples: int, rate: float, name: str = "stand") -> Clip:
    """A follower who stands."""
    rotation = np.zeros((samples, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    root = np.tile(SKELETON.rest_positions()[0], (samples, 1)).astype(np.float32)
    return Clip(name, root, rotation, rate, np.ones((samples, 2), np.bool_))


def made_units(seed: int, count: int, rate: float = 60.0, seconds: tuple[float, float] = (0.6, 1.0)) -> Units:
    """`count` units of random lengths in one recording."""
    chance = np.random.default_rng(seed)
    lengths = chance.uniform(*seconds, count) * rate
    cuts = np.concatenate(([3.0], 3.0 + np.cumsum(lengths)))
    samples = int(cuts[-1]) + 4
    control, target = made_cloud(chance, samples, rate), made_cloud(chance, samples, rate)
    order = [0, 1, *range(4)]  # two of the points lead as hips, too
    leader = Cloud(np.ascontiguousarray(control.floor[:, order]), np.ascontiguousarray(control.height[:, order]), rate)
    follower = standing(samples, rate)
    return cut_units([Example("made", control, target, follower, cuts, np.zeros(0), leader=leader)])
