"""Moments: features of every measure at each quarter of a beat, and the distance of a body from them.

Motion matching (Clavet, "Motion Matching and the Road to Next-Gen Animation", GDC 2016; features as in Holden's
Motion-Matching) compares a body with all frames; here only with those of the same phase of the measure, so that the
beat stays. Features are seen from the hips, in the direction in which the body faces.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.build.transition import clouds
from live.graph.step_library import StepLibrary, window_samples
from live.motion.skeleton import SKELETON

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
Float = npt.NDArray[np.floating]

PER_BEAT: Final = 4
"""Moments in a beat."""
LOOKED_AT: Final = (
    ("leftFoot", 1.5), ("rightFoot", 1.5), ("leftToes", 1.0), ("rightToes", 1.0), ("leftLowerLeg", 0.7),
    ("rightLowerLeg", 0.7), ("leftHand", 0.6), ("rightHand", 0.6), ("head", 0.7), ("chest", 0.7),
)  # fmt: skip
"""Joints whose places and speeds are compared, and how much each counts: feet carry."""
SPEED_SHARE: Final = 0.06
"""A metre per measure of speed counts as so many metres of place: what a difference of speed carries a joint astray
while it fades, 0.2 of 0.4 s, in measures of about 1.3 to 2 s."""
FOOT: Final = 0.4
"""A foot that stands in one clip and swings in the other counts as so many metres between them."""
BETWEEN: Final = 1.0 / 128.0
"""Share of a measure over which speeds are measured."""
_JOINTS = [SKELETON.index(name) for name, _ in LOOKED_AT]
_WEIGHTS = np.array([weight for _, weight in LOOKED_AT])
_ACROSS = tuple(
    (SKELETON.index(left), SKELETON.index(right))
    for left, right in (("leftUpperLeg", "rightUpperLeg"), ("leftUpperArm", "rightUpperArm"))
)


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """K moments of N nodes, the first where the measure begins, the last where it ends."""

    feature: Float32
    """Weighted places and speeds of the joints looked at, seen from the hips, and which feet stand, shape (N, K, F)."""
    hips: Float64
    """Hips in the clip's axes (x, z) [m], shape (N, K, 2)."""
    facing: Float64
    """Heading of the body in the clip's axes [rad], shape (N, K)."""

    def joined(self, other: "Moments") -> "Moments":
        """The moments of this one's nodes, then the other's."""
        return Moments(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in Moments.__slots__))

    def at(self, fraction: Float64) -> Int32:
        """Which moment is nearest to each `fraction` (n,) of the measure, (n,)."""
        last = self.hips.shape[1] - 1
        return np.asarray(np.clip(np.rint(fraction * last), 0, last), np.int32)

    def distance(self, feature: Float32, fraction: Float64, nodes: Int32) -> Float64:
        """How far bodies with `feature` (n, F) at `fraction` (n,) of their measures are from each of `nodes` (C,) at
        that phase [m], (n, C)."""
        moment = self.at(fraction)
        out = np.empty((len(feature), len(nodes)))
        for k in np.unique(moment):
            rows = moment == k
            own, other = feature[rows].astype(np.float64), self.feature[nodes, k].astype(np.float64)
            squared = (own**2).sum(1)[:, None] + (other**2).sum(1)[None] - 2.0 * own @ other.T
            out[rows] = np.sqrt(np.maximum(squared, 0.0))
        return out


def moments_of(library: StepLibrary) -> Moments:
    """The moments of all nodes of a library."""
    count = PER_BEAT * library.beats_per_measure + 1
    size = ((library.node_last - library.node_first) * BETWEEN)[:, None]
    sample = window_samples(library.node_first, library.node_last, count)
    back = np.where(np.arange(count)[None] > 0, -size, size)  # before the moment, but after the measure's beginning
    now, then = clouds(library, sample), clouds(library, sample + back)
    per_measure = np.where(np.arange(count) > 0, 1.0, -1.0)[None, :, None, None] / BETWEEN
    stands = library.clip_contact[np.rint(sample).astype(np.int64)]
    feature, hips, facing = body_features(now, (now - then) * per_measure, stands)
    return Moments(np.ascontiguousarray(feature, np.float32), hips, facing)


def body_features(position: Float, speed: Float, stands: Bool) -> tuple[Float64, Float64, Float64]:
    """Features (..., F), hips x, z (..., 2) [m] and heading (...) [rad] of bodies with joints at `position`
    (..., J, 3) [m], moving at `speed` (..., J, 3) [m per measure]; `stands` (..., 2): on which feet, left and right."""
    facing = heading_of(position)
    hips = np.ascontiguousarray(position[..., 0, ::2], np.float64)
    seen = position[..., _JOINTS, :] - position[..., :1, :] * np.array([1.0, 0.0, 1.0])
    places = _turned(seen, -facing[..., None]) * _WEIGHTS[:, None]
    moving = np.concatenate([speed[..., _JOINTS, :] * _WEIGHTS[:, None], speed[..., :1, :]], axis=-2)
    speeds = SPEED_SHARE * _turned(moving, -facing[..., None])
    shape = (*facing.shape, -1)
    height = position[..., :1, 1]
    parts = [places.reshape(shape), height, speeds.reshape(shape), FOOT * stands]
    return np.concatenate(parts, axis=-1), hips, facing


def heading_of(position: Float) -> Float64:
    """Heading of bodies (...) [rad], from hips and shoulders of `position` (..., J, 3) [m] alike."""
    total = np.zeros(position.shape[:-2], np.complex128)
    for left, right in _ACROSS:
        across = position[..., left, :] - position[..., right, :]
        direction = across[..., 0] + 1j * across[..., 2]
        total += direction / np.maximum(np.abs(direction), 1e-9)
    return np.asarray(-np.angle(total), np.float64)


def _turned(vectors: Float, yaw: Float64) -> Float64:
    """Vectors (..., 3) turned by `yaw` (...) about +Y."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[..., 0], vectors[..., 2]
    return np.stack([x * c + z * s, vectors[..., 1], z * c - x * s], axis=-1)
