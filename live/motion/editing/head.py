"""Head facing: the head looks at the public while the body turns, as far as a neck lets it (T123-T125)."""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.curve import smoothed
from live.motion.editing.orientation import heading_of
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]

LIMIT: Final = np.radians(60.0)
"""The head turns no farther than this to either side (T124)."""
SIGMA: Final = 0.12
"""Width of the Gaussian [s] that smooths the added turn (T124; not printed there)."""
NECK_SHARE: Final = 0.5
"""Share of the added turn that the neck takes; the head ends as in T125 whatever it is."""

_CHEST, _NECK, _HEAD = (SKELETON.index(name) for name in ("upperChest", "neck", "head"))
_Y: Final = np.array((0.0, 1.0, 0.0))


def face_head(
    clip: Clip,
    *,
    target: float = 0.0,
    limit: float = LIMIT,
    sigma: float = SIGMA,
    neck_share: float = NECK_SHARE,
) -> Clip:
    """The clip with the head turned about the vertical towards `target` [rad, 0 = the public].

    The turn at each sample is that of `head_turn`; the head's rotation in the world becomes R_θ R_head and its local
    one follows from its parents' (T125). ValueError for a limit outside (0, π) or a negative sigma.
    """
    theta = head_turn(clip, target=target, limit=limit, sigma=sigma)
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    neck = quaternion.mul(quaternion.from_axis_angle(_Y, neck_share * theta), world[:, _NECK])
    head = quaternion.mul(quaternion.from_axis_angle(_Y, theta), world[:, _HEAD])
    rotation = clip.rotation.copy()
    rotation[:, _NECK] = quaternion.mul(quaternion.inverse(world[:, _CHEST]), neck)
    rotation[:, _HEAD] = quaternion.mul(quaternion.inverse(neck), head)
    return replace(clip, rotation=rotation)


def head_turn(clip: Clip, *, target: float = 0.0, limit: float = LIMIT, sigma: float = SIGMA) -> Float64:
    """The turn θ [rad] to add to the head at each sample, (T,) (T123, T124).

    θ = target - atan2(v_x, v_z) for the head's forward axis v (with the quadrant that arctg loses). Samples in which
    θ, or the head on the chest that it would lead to, is beyond `limit` are left out (spins), what is missing is
    filled by straight lines, and a Gaussian of `sigma` [s] smooths it all. Last, no sample may turn the head beyond
    the limit on the chest, or farther than it was.
    """
    if not 0.0 < limit < np.pi or not sigma >= 0.0:
        raise ValueError(f"limit {limit} and sigma {sigma}: 0 to π and at least 0 expected")
    _, world = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    theta = wrap(target - heading_of(world[:, _HEAD]))
    turned = wrap(heading_of(world[:, _HEAD]) - heading_of(world[:, _CHEST]))  # already, on the chest
    kept = (np.abs(theta) <= limit) & (np.abs(turned + theta) <= limit)
    theta = fill_gaps(theta, kept)
    if sigma > 0.0:
        theta = np.asarray(smoothed(theta, sigma * clip.sample_rate), np.float64)
    lowest, highest = np.minimum(-limit, turned), np.maximum(limit, turned)
    return np.asarray(np.clip(turned + theta, lowest, highest) - turned)


def fill_gaps(values: Float64, kept: npt.NDArray[np.bool_]) -> Float64:
    """Values (T,) with those that are not `kept` on straight lines between their neighbours; 0 if none is kept."""
    if not kept.any():
        return np.zeros_like(values)
    places = np.arange(len(values))
    return np.interp(places, places[kept], values[kept])


def wrap(angle: npt.NDArray[np.floating]) -> Float64:
    """The same angles in [-π, π) [rad]."""
    return np.asarray(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)
