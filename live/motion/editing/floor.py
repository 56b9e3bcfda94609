"""Floor correction: no sole goes below the floor; feet that would are lifted, softly in time."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.clip import Clip
from live.motion.editing.feet import ANKLES, BALLS, Feet
from live.motion.editing.legs import reach_with_feet
from live.motion.forward_kinematics import forward_kinematics

Float64 = npt.NDArray[np.float64]

SOFT: Final = 0.1
"""Seconds before and after over which a lift comes and goes."""


@dataclass(frozen=True, slots=True, eq=False)
class FloorCorrection:
    """A corrected clip, and by how much each foot was lifted [m], left and right, shape (T, 2)."""

    clip: Clip
    lift: Float64

    @property
    def deepest(self) -> float:
        """How far [m] the farthest sole was lifted."""
        return float(self.lift.max(initial=0.0))


def correct_floor(clip: Clip, *, soft: float = SOFT) -> FloorCorrection:
    """Lift each foot by at least as much as its sole is below y = 0, bending the leg; the rest of the body stays.

    The lift is the smallest smooth one: the depth, held over `soft` seconds to both sides and averaged over as many.
    Places on the floor (x, z) and the directions of the feet stay, so what stood still stands still. A clip in which
    no sole is below the floor is returned as it is.
    """
    root, rotation = clip.root_position.astype(np.float64), clip.rotation.astype(np.float64)
    position, world = forward_kinematics(root, rotation)
    depth = np.maximum(-Feet(position[:, ANKLES], position[:, BALLS]).height, 0.0)
    lift = cover(depth, max(1, round(soft * clip.sample_rate)))
    if not lift.any():
        return FloorCorrection(clip, lift)
    ankles = position[:, ANKLES].copy()
    ankles[..., 1] += lift
    moved = lift.max(axis=1) > 0.0
    rotation[moved] = reach_with_feet(root, rotation, ankles, world[:, ANKLES])[moved]
    return FloorCorrection(replace(clip, rotation=np.ascontiguousarray(rotation, np.float32)), lift)


def cover(depth: Float64, half: int) -> Float64:
    """A smooth curve in time, (T, n), that is nowhere below `depth` (T, n) and 0 beyond 2 · `half` samples from it."""
    windows = np.lib.stride_tricks.sliding_window_view
    padded = np.pad(depth, ((2 * half, 2 * half), (0, 0)), mode="edge")
    most = windows(padded, 2 * half + 1, axis=0).max(axis=-1)
    weights = np.hanning(2 * half + 3)[1:-1]
    return np.asarray(windows(most, 2 * half + 1, axis=0) @ (weights / weights.sum()))
