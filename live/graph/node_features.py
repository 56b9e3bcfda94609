"""Features of every measure (node): ends, headings, turns, corrections, and motion matching features per quarter beat.

Motion matching (Clavet, "Motion Matching and the Road to Next-Gen Animation", GDC 2016; features as in Holden's
Motion-Matching) compares a body with all frames. Here only frames of the same phase of the measure are compared, to
stay on the beat. Features are relative to the hips and the body's heading.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float, Float32, Float64, Int32
from live.graph.build.metric import WINDOW_SAMPLES
from live.graph.build.transitions import clouds
from live.graph.step_library import StepLibrary, window_samples
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.editing.turn_insertion import support_turn_rows
from live.motion.pose.foot_lock import LEG_JOINTS, leg_positions
from live.motion.pose.footstep_plan import MeasurePlans, plan_measures
from live.motion.skeleton import SKELETON

MOMENTS_PER_BEAT: Final = 4
"""Moments per beat."""
COMPARED_JOINTS: Final = (
    ("leftFoot", 1.5), ("rightFoot", 1.5), ("leftToes", 1.0), ("rightToes", 1.0), ("leftLowerLeg", 0.7),
    ("rightLowerLeg", 0.7), ("leftHand", 0.6), ("rightHand", 0.6), ("head", 0.7), ("chest", 0.7),
)  # fmt: skip
"""Joints whose places and speeds are compared, with weights; feet weigh most."""
SPEED_SHARE: Final = 0.06
"""Metres of place that one metre per measure of speed counts as: how far a speed difference displaces a joint while it
fades, 0.2 of 0.4 s, in measures of about 1.3 to 2 s."""
CONTACT_WEIGHT: Final = 0.4
"""Metres that a foot which stands in one clip and swings in the other counts as."""
SPEED_INTERVAL: Final = 1.0 / 128.0
"""Share of a measure over which speeds are measured."""
_JOINTS = [SKELETON.index(name) for name, _ in COMPARED_JOINTS]
_WEIGHTS = np.array([weight for _, weight in COMPARED_JOINTS])
_HEAD_AT = [name for name, _ in COMPARED_JOINTS].index("head")
_HEAD_HEIGHT, _HEAD_WEIGHT = 3 * _HEAD_AT + 1, COMPARED_JOINTS[_HEAD_AT][1]
_ACROSS = tuple(
    (SKELETON.index(left), SKELETON.index(right))
    for left, right in (("leftUpperLeg", "rightUpperLeg"), ("leftUpperArm", "rightUpperArm"))
)


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """K moments of N nodes, from the beginning to the end of the measure."""

    feature: Float32
    """Weighted places and speeds of the compared joints relative to the hips, and standing feet, shape (N, K, F)."""
    hips: Float64
    """Hips in the clip's axes (x, z) [m], shape (N, K, 2)."""
    facing: Float64
    """Heading of the body in the clip's axes [rad], shape (N, K)."""

    def head_height(self, nodes: Int32) -> Float64:
        """Return the height of the head's joint at the highest moment of each of `nodes` (n,) [m], (n,)."""
        return np.asarray(self.feature[nodes, :, _HEAD_HEIGHT].max(axis=1) / _HEAD_WEIGHT, np.float64)

    def joined(self, other: "Moments") -> "Moments":
        """Return the moments of these nodes followed by those of `other`."""
        return Moments(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in Moments.__slots__))

    def at(self, fraction: Float64) -> Int32:
        """Return the moment nearest to each `fraction` (n,) of the measure, (n,)."""
        last = self.hips.shape[1] - 1
        return np.asarray(np.clip(np.rint(fraction * last), 0, last), np.int32)

    def distance(self, feature: Float32, fraction: Float64, nodes: Int32) -> Float64:
        """Return the distance [m], (n, C), of bodies with `feature` (n, F) to each of `nodes` (C,) at the same phase.

        `fraction` (n,) is the phase of the bodies in their measures.
        """
        moment = self.at(fraction)
        out = np.empty((len(feature), len(nodes)))
        for k in np.unique(moment):
            rows = moment == k
            own, other = feature[rows].astype(np.float64), self.feature[nodes, k].astype(np.float64)
            squared = (own**2).sum(1)[:, None] + (other**2).sum(1)[None] - 2.0 * own @ other.T
            out[rows] = np.sqrt(np.maximum(squared, 0.0))
        return out


_NODES: Final = 256
"""Nodes that are posed at a time."""


def moments_of(library: StepLibrary) -> Moments:
    """Return the moments of all nodes of a library."""
    count = MOMENTS_PER_BEAT * library.beats_per_measure + 1
    size = ((library.node_last - library.node_first) * SPEED_INTERVAL)[:, None]
    sample = window_samples(library.node_first, library.node_last, count)
    back = np.where(np.arange(count)[None] > 0, -size, size)  # before the moment, but not before the measure begins
    per_measure = np.where(np.arange(count) > 0, 1.0, -1.0)[None, :, None, None] / SPEED_INTERVAL
    stands = library.clip_contact[np.rint(sample).astype(np.int64)]
    parts = []
    for begin in range(0, library.node_count, _NODES):
        own = slice(begin, begin + _NODES)
        now, then = clouds(library, sample[own]), clouds(library, sample[own] + back[own])
        feature, hips, facing = body_features(now, (now - then) * per_measure, stands[own])
        parts.append((feature.astype(np.float32), hips, facing))
    return Moments(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def body_features(position: Float, speed: Float, stands: Bool) -> tuple[Float64, Float64, Float64]:
    """Return features (..., F), hips x, z (..., 2) [m] and heading (...) [rad] of bodies.

    `position` (..., J, 3) [m] and `speed` (..., J, 3) [m per measure] are those of the joints; `stands` (..., 2):
    left and right foot on the floor.
    """
    facing = heading_of(position)
    hips = np.ascontiguousarray(position[..., 0, ::2], np.float64)
    seen = position[..., _JOINTS, :] - position[..., :1, :] * np.array([1.0, 0.0, 1.0])
    places = _turned(seen, -facing[..., None]) * _WEIGHTS[:, None]
    moving = np.concatenate([speed[..., _JOINTS, :] * _WEIGHTS[:, None], speed[..., :1, :]], axis=-2)
    speeds = SPEED_SHARE * _turned(moving, -facing[..., None])
    shape = (*facing.shape, -1)
    height = position[..., :1, 1]
    parts = [places.reshape(shape), height, speeds.reshape(shape), CONTACT_WEIGHT * stands]
    return np.concatenate(parts, axis=-1), hips, facing


def heading_of(position: Float) -> Float64:
    """Return the heading of bodies (...) [rad], from hips and shoulders of `position` (..., J, 3) [m] equally."""
    total = np.zeros(position.shape[:-2], np.complex128)
    for left, right in _ACROSS:
        across = position[..., left, :] - position[..., right, :]
        direction = across[..., 0] + 1j * across[..., 2]
        total += direction / np.maximum(np.abs(direction), 1e-9)
    return np.asarray(-np.angle(total), np.float64)


def _turned(vectors: Float, yaw: Float64) -> Float64:
    """Rotate vectors (..., 3) by `yaw` (...) about +Y."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[..., 0], vectors[..., 2]
    return np.stack([x * c + z * s, vectors[..., 1], z * c - x * s], axis=-1)


HIPS: Final = tuple(SKELETON.index(f"{side}UpperLeg") for side in ("left", "right"))
MOVED: Final = 1e-3
"""A measure line that differs by more samples from the cut was moved."""
TURN_SOFTNESS: Final = 0.3
"""Share of a support phase over which a live turn accelerates, and decelerates."""


@dataclass(frozen=True, slots=True, eq=False)
class NodeFacts:
    """Facts of N nodes, each depending only on the node's own clip; fields as in MotionGraph."""

    start: Float64
    end: Float64
    facing: Float64
    facing_start: Float64
    facing_mean: Float64
    turns: Float64
    peak_turn_rate: Float64
    warp_curve: Float64
    foot_curve: Float64
    reach_margins: Float64
    lift_shares: Float64
    moments: Moments

    def joined(self, other: "NodeFacts") -> "NodeFacts":
        """Return the facts of these nodes followed by those of `other`."""
        arrays = [name for name in NodeFacts.__slots__ if name != "moments"]
        return NodeFacts(
            **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in arrays},
            moments=self.moments.joined(other.moments),
        )


def node_facts(library: StepLibrary, window: float) -> NodeFacts:
    """Measure all nodes; `window` is the length of a transition as a share of the measure (T036)."""
    facing_start, facing_end, facing_mean = _facing(library, window)
    legs = leg_positions(library.leg_store)
    hip, ankle, ball = (
        np.ascontiguousarray(legs[:, np.searchsorted(LEG_JOINTS, own)]) for own in (HIPS, ANKLES, BALLS)
    )
    del legs
    turns, quickest = _turns(library, ankle, ball, window)
    plans = _plans(library, hip, ankle, window)
    return NodeFacts(
        start=_root_at(library, library.node_first),
        end=_root_at(library, library.node_last),
        facing=facing_end,
        facing_start=facing_start,
        facing_mean=facing_mean,
        turns=turns,
        peak_turn_rate=quickest,
        warp_curve=plans.root,
        foot_curve=plans.feet,
        reach_margins=plans.margin,
        lift_shares=plans.hold,
        moments=moments_of(library),
    )


def _turns(library: StepLibrary, ankle: Float32, ball: Float32, window: float) -> tuple[Float64, Float64]:
    """Return the support turns of every node, (N, 8, 8), and their peak speeds, (N,).

    Measure lines are those of the cut, unless they were moved (T140).
    """
    cut = np.array([(clip.first, clip.samples_per_measure) for clip in library.clips])[library.node_clip]
    first = library.node_lead + cut[:, 0] + library.node_measure * cut[:, 1]
    size = library.node_last - library.node_first
    moved = (np.abs(first - library.node_first) > MOVED) | (np.abs(size - cut[:, 1]) > MOVED)
    first, size = np.where(moved, library.node_first, first), np.where(moved, size, cut[:, 1])
    return support_turn_rows(
        library.clips, library.node_clip, first, size, ankle, ball, window=min(window, 0.9), softness=TURN_SOFTNESS
    )


def _plans(library: StepLibrary, hip: Float32, ankle: Float32, window: float) -> MeasurePlans:
    """Return the footstep plan of every node."""
    measures = list(zip(library.node_first.tolist(), library.node_last.tolist(), strict=True))
    beats, last = library.beats_per_measure, 1.0 - min(window, 0.9)
    return plan_measures(hip, ankle, library.clip_contact, measures, beats=beats, last=last)


def _root_at(library: StepLibrary, sample: Float64) -> Float64:
    low = np.clip(np.floor(sample).astype(np.int64), 0, len(library.clip_root) - 1)
    high = np.minimum(low + 1, len(library.clip_root) - 1)
    t = (sample - low)[:, None]
    root = (1.0 - t) * library.clip_root[low] + t * library.clip_root[high]
    return np.ascontiguousarray(root[:, (0, 2)], np.float64)


def _facing(library: StepLibrary, window: float) -> tuple[Float64, Float64, Float64]:
    """Return the body heading at the beginning, at the end and over all of each measure [rad], (N,) each.

    The line from the right to the left upper leg and that between the shoulders are averaged, because hips alone sway
    with every step. Means of angles are means of unit vectors.
    """
    parts = []
    for begin in range(0, library.node_count, _NODES):
        first, last, lead = (
            array[begin : begin + _NODES] for array in (library.node_first, library.node_last, library.node_lead)
        )
        length = (last - first) * window
        start = np.maximum(window_samples(first - length, first, WINDOW_SAMPLES), lead[:, None])
        end = window_samples(last - length, last, WINDOW_SAMPLES)
        whole = window_samples(first, last, 4 * WINDOW_SAMPLES)
        parts.append([_mean_heading(clouds(library, samples)) for samples in (start, end, whole)])
    at_start, at_end, over_all = (np.concatenate(part) for part in zip(*parts, strict=True))
    return at_start, at_end, over_all


def _mean_heading(cloud: Float64) -> Float64:
    """Return the mean heading [rad] of clouds (n, K, J, 3), (n,)."""
    total = np.zeros(len(cloud), np.complex128)
    for left, right in _ACROSS:
        across = cloud[:, :, left] - cloud[:, :, right]
        direction = across[..., 0] + 1j * across[..., 2]
        total += (direction / np.maximum(np.abs(direction), 1e-9)).mean(axis=1)
    # facing +z, the left side is at +x: heading 0 is direction 1 + 0i, and yaw turns it by exp(-i yaw)
    return np.ascontiguousarray(-np.angle(total), np.float64)
