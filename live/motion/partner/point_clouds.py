"""Clouds: what is compared of a motion, a few points at even times, their places on the floor as complex numbers.

A point's place is z + i x, so that turning by `yaw` (heading 0 faces +z, positive towards +x) multiplies by e^(i yaw).

One unit laid on a stretch of the input: the rigid motion of the floor that fits best, and what is left (H002-H004).

This is the plain form, for one window at a time: what kernels and matrix products do for all of them at once is
measured against it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]
Complex128 = npt.NDArray[np.complex128]

END_JOINTS: Final = tuple(SKELETON.index(name) for name in ("leftHand", "rightHand", "leftFoot", "rightFoot"))
"""Hands and feet: enough for interpretation and continuity (H016)."""
HIP_JOINTS: Final = tuple(SKELETON.index(name) for name in ("leftUpperLeg", "rightUpperLeg"))
"""The hip joints, whose shadows on the floor stand for a walk's path (H017)."""
HIP_APART: Final = 0.18
"""The shadows are brought to this distance [m], so that a tilted pelvis changes nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """P points at T evenly spaced times."""

    floor: Complex128
    """Places on the floor z + i x [m], shape (T, P)."""
    height: Float64
    """Heights [m], shape (T, P)."""
    rate: float
    """Times per second [Hz]."""

    @property
    def count(self) -> int:
        """Number of times T."""
        return len(self.floor)

    def at(self, places: Float64) -> "Cloud":
        """The cloud at fractional samples (n,), linearly between them; ends are held; its rate is kept."""
        places = np.clip(places, 0.0, self.count - 1.0)
        low = np.minimum(places.astype(np.int64), max(self.count - 2, 0))
        high = np.minimum(low + 1, self.count - 1)
        part = (places - low)[:, None]
        return Cloud(
            (1.0 - part) * self.floor[low] + part * self.floor[high],
            (1.0 - part) * self.height[low] + part * self.height[high],
            self.rate,
        )

    def resampled(self, rate: float) -> "Cloud":
        """The cloud at another rate (down-sampling, H012)."""
        count = int((self.count - 1) * rate / self.rate + 1e-6) + 1
        thin = self.at(np.asarray(np.arange(count) * self.rate / rate, np.float64))
        return Cloud(thin.floor, thin.height, rate)

    def moved(self, turn: complex, shift: complex) -> "Cloud":
        """Turned about the vertical by the unit number `turn`, then moved by `shift` [m]."""
        return Cloud(turn * self.floor + shift, self.height, self.rate)


def cloud_of(positions: npt.NDArray[np.floating], rate: float) -> Cloud:
    """The cloud of points (T, P, 3) [m]."""
    points = np.asarray(positions, np.float64)
    return Cloud(np.ascontiguousarray(points[..., 2] + 1j * points[..., 0]), np.ascontiguousarray(points[..., 1]), rate)


def ends_cloud(clip: Clip) -> Cloud:
    """Hands and feet of a clip."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return cloud_of(positions[:, END_JOINTS], clip.sample_rate)


def path_cloud(clip: Clip) -> Cloud:
    """The shadows of the hip joints, always equally far apart: what a drawn path knows of a walk (H017)."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    floor = cloud_of(positions[:, HIP_JOINTS], clip.sample_rate).floor
    middle, across = floor.mean(axis=1), floor[:, 0] - floor[:, 1]
    size = np.abs(across)
    across = np.where(size > 1e-6, across / np.maximum(size, 1e-6), 1j)
    return shadows(middle, across, clip.sample_rate)


def shadows(middle: Complex128, across: Complex128, rate: float) -> Cloud:
    """Two points `HIP_APART` about `middle` (T,), the left one towards the unit number `across` (T,)."""
    floor = middle[:, None] + 0.5 * HIP_APART * across[:, None] * np.array((1.0, -1.0))
    return Cloud(np.ascontiguousarray(floor), np.zeros(floor.shape), rate)


@dataclass(frozen=True, slots=True)
class Fit:
    """M (2) and D (1)."""

    turn: complex
    """Rotation about the vertical as a unit number."""
    shift: complex
    """What is added after it [m]."""
    distance: float
    """Sum over samples and points of the squared distances that remain [m²]."""


def stretched(cloud: Cloud, start: float, length: float, duration: int) -> Cloud:
    """The samples `start` to `start + length` of a cloud in `duration` equal steps: `duration` + 1 samples."""
    return cloud.at(np.asarray(start + np.arange(duration + 1) * (length / duration), np.float64))


def fit(x: Cloud, a: Cloud) -> Fit:
    """D(x, a) and the M that it is taken at, in closed form (K001): ground translation and vertical rotation.

    Both clouds have the same shape. Heights are compared as they are. Where every rotation is as good (all points of
    one in one place) there is none.
    """
    middle_x, middle_a = x.floor.mean(), a.floor.mean()
    product = complex(np.sum(np.conj(a.floor - middle_a) * (x.floor - middle_x)))
    turn = product / abs(product) if abs(product) > 1e-12 else complex(1.0)
    shift = complex(middle_x - turn * middle_a)
    moved = a.moved(turn, shift)
    left = np.sum(np.abs(x.floor - moved.floor) ** 2) + np.sum((x.height - moved.height) ** 2)
    return Fit(turn, shift, float(left))


def gap(tail: Cloud, head: Cloud) -> float:
    """C (4): the squared distance [m²] of the last sample of `tail` from the first of `head`."""
    floor = np.abs(tail.floor[-1] - head.floor[0]) ** 2
    return float(floor.sum() + ((tail.height[-1] - head.height[0]) ** 2).sum())
