"""NodeFacts: what is measured of every measure of a library: where it begins and ends, faces, and can be turned."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from live.graph.build.transition import clouds, transition_windows
from live.graph.build.weights import WINDOW_SAMPLES
from live.graph.moments import Moments, moments_of
from live.graph.step_library import StepLibrary, window_samples
from live.motion.editing.feet import ANKLES, BALLS, Feet
from live.motion.editing.rotation_insertion import support_turns
from live.motion.pose.give import give_of, holds_of
from live.motion.pose.pose_pipeline import PosePipeline, PoseSkeleton
from live.motion.pose.rise import rise_of
from live.motion.pose.shifting_kernels import KNOTS
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

TURN_SOFTNESS = 0.3
"""Share of a support over which a live turn speeds up, and slows down: a body cannot turn at once."""
_ACROSS = tuple(
    (SKELETON.index(left), SKELETON.index(right))
    for left, right in (("leftUpperLeg", "rightUpperLeg"), ("leftUpperArm", "rightUpperArm"))
)


@dataclass(frozen=True, slots=True, eq=False)
class NodeFacts:
    """Facts of N nodes, each of which depends on the node's own clip alone; fields as in MotionGraph."""

    start: Float64
    end: Float64
    facing: Float64
    facing_start: Float64
    facing_mean: Float64
    turns: Float64
    quickest: Float64
    rise: Float64
    gives: Float64
    holds: Float64
    moments: Moments

    def joined(self, other: "NodeFacts") -> "NodeFacts":
        """The facts of this one's nodes, then the other's."""
        arrays = [name for name in NodeFacts.__slots__ if name != "moments"]
        return NodeFacts(
            **{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in arrays},
            moments=self.moments.joined(other.moments),
        )


def node_facts(library: StepLibrary, window: float) -> NodeFacts:
    """Measure all nodes; `window` is the length of a transition as a share of the measure (T036)."""
    facing_start, facing_end, facing_mean = _facing(library, window)
    turns, quickest = _turns(library, window)
    rise, gives, holds = _rises(library, window)
    return NodeFacts(
        start=_root_at(library, library.node_first),
        end=_root_at(library, library.node_last),
        facing=facing_end,
        facing_start=facing_start,
        facing_mean=facing_mean,
        turns=turns,
        quickest=quickest,
        rise=rise,
        gives=gives,
        holds=holds,
        moments=moments_of(library),
    )


def _turns(library: StepLibrary, window: float) -> tuple[Float64, Float64]:
    """Support turns of every node, (N, 8, 8), and how fast they are at the fastest, (N,)."""
    feet = _feet(library)
    turns = []
    for node, clip in enumerate(library.node_clip):
        step, measure = _measure(library, node)
        turns.append(support_turns(step, measure, window=min(window, 0.9), softness=TURN_SOFTNESS, feet=feet[clip]))
    rows = np.ascontiguousarray(np.stack([turn.rows() for turn in turns]))
    return rows, np.array([float(turn.quickest) for turn in turns])


def _rises(library: StepLibrary, window: float) -> tuple[Float64, Float64, Float64]:
    """When each node's correction comes in, (N, KNOTS, 2), how far it may go each way [m], (N, DIRECTIONS), and how
    much of it the feet that stand at the beginning hold out, (N, 2)."""
    legs = _legs(library)
    rises, gives, holds = [], [], []
    for first, last in zip(library.node_first, library.node_last, strict=True):
        at = np.linspace(first, last, 4 * (KNOTS - 1) + 1).round().astype(np.int64)
        contact = library.clip_contact[at]
        rise, follows = rise_of(contact, last=1.0 - min(window, 0.9))
        rises.append(rise)
        hip, ankle = legs[at][:, (1, 5)], legs[at][:, (3, 7)]
        gives.append(give_of(hip, ankle, contact, rise, follows=follows))
        holds.append(holds_of(ankle, contact, rise))
    stacked = [np.ascontiguousarray(np.stack(rows)) for rows in (rises, gives, holds)]
    return stacked[0], stacked[1], stacked[2]


def _legs(library: StepLibrary) -> Float64:
    """Hips, and hip, knee, ankle and toes of both legs at all samples [m], (S, 9, 3), by one run of the pipeline."""
    pipeline = PosePipeline(len(library.clip_root), PoseSkeleton.legs_only()[0])
    pipeline.sample[0] = np.arange(len(library.clip_root))
    return np.asarray(pipeline.run(library.leg_store)[0], np.float64)


def _measure(library: StepLibrary, node: int) -> tuple[StepClip, int]:
    """The clip and the measure of it that a node is, or the node alone as a clip where its lines were moved (T140)."""
    step, measure = library.clips[library.node_clip[node]], int(library.node_measure[node])
    first = library.node_first[node] - library.node_lead[node]
    size = library.node_last[node] - library.node_first[node]
    as_cut = step.first + measure * step.samples_per_measure, step.samples_per_measure
    if np.allclose((first, size), as_cut, rtol=0.0, atol=1e-3):
        return step, measure
    return replace(step, first=float(first), samples_per_measure=float(size), measures=1), 0


def _feet(library: StepLibrary) -> list[Feet]:
    """The feet of every clip, by one run of the pose pipeline over all samples."""
    joints, position = PoseSkeleton.legs_only()[1], _legs(library)
    ankles, balls = (position[:, np.searchsorted(joints, names)] for names in (ANKLES, BALLS))
    feet, begin = [], 0
    for clip in library.clips:
        own = slice(begin, begin + clip.clip.sample_count)
        feet.append(Feet(ankles[own], balls[own]))
        begin = own.stop
    return feet


def _root_at(library: StepLibrary, sample: Float64) -> Float64:
    low = np.clip(np.floor(sample).astype(np.int64), 0, len(library.clip_root) - 1)
    high = np.minimum(low + 1, len(library.clip_root) - 1)
    t = (sample - low)[:, None]
    root = (1.0 - t) * library.clip_root[low] + t * library.clip_root[high]
    return np.ascontiguousarray(root[:, (0, 2)], np.float64)


def _facing(library: StepLibrary, window: float) -> tuple[Float64, Float64, Float64]:
    """Heading of the body around the beginning and the end of each measure, and over all of it [rad], (N,) each.

    The line from the right to the left upper leg and that between the shoulders are averaged: hips alone sway with
    every step. Means of angles are taken as means of unit vectors.
    """
    end, start = transition_windows(library, window)
    whole = clouds(library, window_samples(library.node_first, library.node_last, 4 * WINDOW_SAMPLES))

    def mean(cloud: Float64) -> Float64:
        total = np.zeros(len(cloud), np.complex128)
        for left, right in _ACROSS:
            across = cloud[:, :, left] - cloud[:, :, right]
            direction = across[..., 0] + 1j * across[..., 2]
            total += (direction / np.maximum(np.abs(direction), 1e-9)).mean(axis=1)
        # facing +z the left side is at +x: heading 0 is direction 1 + 0i, and yaw turns it by exp(-i yaw)
        return np.ascontiguousarray(-np.angle(total), np.float64)

    return mean(start), mean(end), mean(whole)
