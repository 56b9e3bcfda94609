"""The size of the published case (H023), made up: 168 units, a leader who dances them in another order for 150 s."""

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.partner.point_clouds import Cloud, cloud_of
from live.motion.partner.units import Example, Units, cut_units
from live.motion.skeleton import JOINT_COUNT, SKELETON

RATE = 60.0
NOISE = 0.05
"""How far the leader's hands and feet are from the recorded ones [m]."""


def made_units(count: int = 168, seed: int = 1) -> Units:
    """Units of 0.6 to 1 s: hands and feet that wander smoothly."""
    chance = np.random.default_rng(seed)
    cuts = np.concatenate(([3.0], 3.0 + np.cumsum(chance.uniform(0.6, 1.0, count) * RATE)))
    samples = int(cuts[-1]) + 4
    clip = Clip("made", np.tile(SKELETON.rest_positions()[0], (samples, 1)), _still(samples), RATE,
                np.ones((samples, 2), np.bool_))  # fmt: skip
    beats = np.sort(np.concatenate((cuts, 0.5 * (cuts[1:] + cuts[:-1]))))
    return cut_units([Example("made", wandering(chance, samples), wandering(chance, samples), clip, cuts, beats)])


def _still(samples: int) -> npt.NDArray[np.float32]:
    rotation = np.zeros((samples, JOINT_COUNT, 4), np.float32)
    rotation[..., 0] = 1.0
    return rotation


def wandering(chance: np.random.Generator, samples: int) -> Cloud:
    """Four points [m]: sums of sines of up to 2 Hz with random phases that change within some seconds."""
    noise = chance.normal(size=(samples, 4, 3))
    spectrum = np.fft.rfft(noise, axis=0)
    hertz = np.fft.rfftfreq(samples, 1.0 / RATE)[:, None, None]
    spectrum *= np.exp(-0.5 * (hertz / 0.7) ** 2)
    smooth = np.fft.irfft(spectrum, samples, axis=0)
    return cloud_of(0.4 * smooth / smooth.std() + np.array((0.0, 1.0, 0.0)), RATE)


def made_leader(units: Units, seconds: float = 150.0, seed: int = 2) -> tuple[Cloud, list[int]]:
    """A leader who dances units in runs of three, each up to 0.12 s longer or shorter, with noise; and which."""
    chance = np.random.default_rng(seed)
    floors: list[npt.NDArray[np.complex128]] = []
    heights: list[npt.NDArray[np.float64]] = []
    danced: list[int] = []
    total, turn, shift = 0, complex(1.0), complex(0.0)
    while total < seconds * RATE:
        first = int(chance.integers(0, units.count - 3))
        for unit in range(first, first + 3):
            of = units.examples[0].control
            frames = round(float(units.length[unit]) + chance.uniform(-0.12, 0.12) * RATE)
            part = of.at(float(units.start[unit]) + np.arange(frames) * float(units.length[unit]) / frames)
            if floors and unit == first:
                turn = np.exp(1j * chance.uniform(-0.5, 0.5))
                shift = floors[-1][-1].mean() - turn * part.floor[0].mean()
            floors.append(turn * part.floor + shift)
            heights.append(part.height)
            danced.append(unit)
            total += frames
    floor, height = np.concatenate(floors), np.concatenate(heights)
    off = wandering(chance, len(floor))
    count = int(seconds * RATE) + 1
    floor = floor + NOISE * (off.floor - off.floor.mean(axis=0)) / 0.4
    return Cloud(np.ascontiguousarray(floor[:count]), np.ascontiguousarray(height[:count]), RATE), danced
