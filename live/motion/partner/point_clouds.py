"""Point clouds for comparing motion, and the best rigid fit of one cloud to another on the floor (H002-H004).

Floor positions are complex numbers z + i x, so a rotation by `yaw` (heading 0 faces +z, positive towards +x) is a
multiplication by e^(i yaw). The fit here handles one window at a time; it is the reference for the kernels and matrix
products that handle all windows at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Complex128, Float64
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

END_JOINTS: Final = tuple(SKELETON.index(name) for name in ("leftHand", "rightHand", "leftFoot", "rightFoot"))
"""Hands and feet: sufficient for interpretation and continuity (H016)."""
HIP_JOINTS: Final = tuple(SKELETON.index(name) for name in ("leftUpperLeg", "rightUpperLeg"))
"""The hip joints, whose floor projections represent a walk's path (H017)."""
LEADER_JOINTS: Final = HIP_JOINTS + END_JOINTS
"""Hip joints, hands and feet: what a live follower is led by."""
HIP_DISTANCE: Final = 0.18
"""Fixed distance of the two projections [m], so that a tilted pelvis changes nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """P points at T evenly spaced times."""

    floor: Complex128
    """Floor positions z + i x [m], shape (T, P)."""
    height: Float64
    """Heights [m], shape (T, P)."""
    rate: float
    """Sample rate [Hz]."""

    @property
    def count(self) -> int:
        """Number of times T."""
        return len(self.floor)

    def at(self, places: Float64) -> "Cloud":
        """Return the cloud at fractional samples (n,), interpolated linearly, clamped to the ends; `rate` is kept."""
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
        """Return the cloud at another rate (down-sampling, H012)."""
        count = int((self.count - 1) * rate / self.rate + 1e-6) + 1
        thin = self.at(np.asarray(np.arange(count) * self.rate / rate, np.float64))
        return Cloud(thin.floor, thin.height, rate)

    def transformed(self, turn: complex, shift: complex) -> "Cloud":
        """Return the cloud rotated about the vertical by the unit complex number `turn`, then moved by `shift` [m]."""
        return Cloud(turn * self.floor + shift, self.height, self.rate)


def joined_clouds(parts: Sequence[Cloud]) -> Cloud:
    """Return one cloud with the points of all `parts`, which have the same times."""
    return Cloud(
        np.ascontiguousarray(np.concatenate([one.floor for one in parts], axis=1)),
        np.ascontiguousarray(np.concatenate([one.height for one in parts], axis=1)),
        parts[0].rate,
    )


def cloud_of(positions: npt.NDArray[np.floating], rate: float) -> Cloud:
    """Return the cloud of points (T, P, 3) [m]."""
    points = np.asarray(positions, np.float64)
    return Cloud(np.ascontiguousarray(points[..., 2] + 1j * points[..., 0]), np.ascontiguousarray(points[..., 1]), rate)


def ends_cloud(clip: Clip) -> Cloud:
    """Return the cloud of a clip's hands and feet."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return cloud_of(positions[:, END_JOINTS], clip.sample_rate)


def leader_cloud(clip: Clip) -> Cloud:
    """Return the cloud of a clip's hip joints, hands and feet, LEADER_JOINTS."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return cloud_of(positions[:, LEADER_JOINTS], clip.sample_rate)


def path_cloud(clip: Clip) -> Cloud:
    """Return the floor projections of the hip joints at a fixed distance, as a drawn path gives them (H017)."""
    positions, _ = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    floor = cloud_of(positions[:, HIP_JOINTS], clip.sample_rate).floor
    middle, across = floor.mean(axis=1), floor[:, 0] - floor[:, 1]
    size = np.abs(across)
    across = np.where(size > 1e-6, across / np.maximum(size, 1e-6), 1j)
    return hip_projections(middle, across, clip.sample_rate)


def hip_projections(middle: Complex128, across: Complex128, rate: float) -> Cloud:
    """Return two points `HIP_DISTANCE` around `middle` (T,), the left one towards `across` (T,), of length 1."""
    floor = middle[:, None] + 0.5 * HIP_DISTANCE * across[:, None] * np.array((1.0, -1.0))
    return Cloud(np.ascontiguousarray(floor), np.zeros(floor.shape), rate)


@dataclass(frozen=True, slots=True)
class Fit:
    """Best-fitting motion M (2) and distance D (1)."""

    turn: complex
    """Rotation about the vertical as a unit complex number."""
    shift: complex
    """Translation after the rotation [m]."""
    distance: float
    """Sum of the squared residual distances over samples and points [m²]."""


def time_scaled(cloud: Cloud, start: float, length: float, duration: int) -> Cloud:
    """Resample `start` to `start + length` of a cloud in `duration` equal steps: `duration` + 1 samples."""
    return cloud.at(np.asarray(start + np.arange(duration + 1) * (length / duration), np.float64))


def fit(x: Cloud, a: Cloud) -> Fit:
    """Return D(x, a) and its M in closed form (K001): floor translation and rotation about the vertical.

    Both clouds have the same shape. Heights are compared directly. If all points of one cloud coincide, every rotation
    fits equally well and none is applied.
    """
    middle_x, middle_a = x.floor.mean(), a.floor.mean()
    product = complex(np.sum(np.conj(a.floor - middle_a) * (x.floor - middle_x)))
    turn = product / abs(product) if abs(product) > 1e-12 else complex(1.0)
    shift = complex(middle_x - turn * middle_a)
    moved = a.transformed(turn, shift)
    left = np.sum(np.abs(x.floor - moved.floor) ** 2) + np.sum((x.height - moved.height) ** 2)
    return Fit(turn, shift, float(left))


def gap(tail: Cloud, head: Cloud) -> float:
    """Return C (4): the squared distance [m²] of the last sample of `tail` from the first of `head`."""
    floor = np.abs(tail.floor[-1] - head.floor[0]) ** 2
    return float(floor.sum() + ((tail.height[-1] - head.height[0]) ** 2).sum())
