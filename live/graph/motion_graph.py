"""MotionGraph: nodes only at measure ends, edges between compatible measures, dead ends pruned (T031-T042)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.graph.library import StepLibrary, window_samples
from live.graph.structure import may_follow, unmatched_poses
from live.graph.takes import Takes, find_takes
from live.graph.transition import WINDOW_SAMPLES, Transitions, all_pairs, clouds, transition_windows
from live.motion.editing.feet import ANKLES, BALLS, Feet
from live.motion.editing.rotation_insertion import support_turns
from live.motion.editing.support_turns import SupportTurns
from live.motion.posing.pipeline import PosePipeline, PoseSkeleton
from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

NEVER = 1 << 20
"""Hops to a step that cannot be reached."""
TURN_SOFTNESS = 0.3
"""Share of a support over which a live turn speeds up, and slows down: a body cannot turn at once."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionGraph:
    """N nodes (measures of the library) and E edges as compressed rows (C steps)."""

    library: StepLibrary
    edge_start: Int32
    """Edges of node u are edge_start[u] to edge_start[u + 1], shape (N + 1,)."""
    edge_target: Int32
    edge_cost: Float64
    """Distance of the aligned clouds [m], shape (E,); 0 within a step."""
    edge_transform: Float64
    """x, z [m], yaw [rad] that place the next clip in the axes of the last (K001), shape (E, 3)."""
    hops: Int32
    """Measures from a node to the first measure of a step, 0 = it is in it, NEVER if it cannot, shape (C, N)."""
    node_end: Float64
    """Hips at the end of each measure, in its clip's axes (x, z) [m], shape (N, 2)."""
    node_facing: Float64
    """Heading of the body at the end of each measure, in its clip's axes [rad], shape (N,)."""
    node_facing_start: Float64
    """The same at its beginning, shape (N,)."""
    node_facing_mean: Float64
    """Mean heading over the whole measure, a circular mean (T122), shape (N,)."""
    node_start: Float64
    """Hips at the beginning of each measure, in its clip's axes (x, z) [m], shape (N, 2)."""
    node_turns: Float64
    """Where in each measure a dancer can turn on a carrying foot, shape (N, 8, 8): per segment start, stop, weight,
    x, z [m] of the foot at both ends, softness (T048-T050)."""
    node_quickest: Float64
    """How fast a turn is at its fastest, in whole angles per measure, shape (N,)."""
    takes: Takes
    """The other takes of each node's measure (T044-T047)."""
    alive: Bool
    """Whether a node is in the largest strongly connected component, shape (N,)."""
    window: float
    """Length of a transition as a share of the measure."""
    missing: tuple[str, ...]
    """Steps that no dancer can enter and leave again, in words."""

    @property
    def edge_count(self) -> int:
        """Number of edges E."""
        return len(self.edge_target)

    def entries(self, step: int) -> Int32:
        """Nodes that begin the step and are alive."""
        library = self.library
        chosen = (library.node_step == step) & (library.node_measure == 0) & self.alive
        return np.flatnonzero(chosen).astype(np.int32)


def build_graph(
    library: StepLibrary, *, window: float = 0.1875, threshold: float = 0.16, prune: bool = True
) -> MotionGraph:
    """Connect the measures of a library.

    `window`: length of a transition as a share of the measure (T036); `threshold` [m]: largest distance (T034) of an
    edge. Within a step of several measures each one leads to the next alone, without cost (T039). Poses in which steps
    begin and end must agree where they are named (T136), and a step that transfers the weight is repeated on the other
    side (T135). Dead ends are pruned (T037); with `prune` False they stay, for searches that know where a dance ends
    (T064). ValueError if no two measures connect, unless nothing is pruned.
    """
    transitions = all_pairs(*transition_windows(library, window))
    allowed = allowed_edges(library, transitions, threshold)
    alive = largest_component(allowed) if prune else np.ones(library.node_count, np.bool_)
    if prune and not allowed[np.ix_(alive, alive)].any():
        raise ValueError(
            f"no step of {', '.join(library.steps)} leads to another within {threshold} m: "
            "raise the threshold or make their beginnings and ends more alike"
            + "".join(f"; {name} {why}" for name, why in unmatched_poses(library).items())
        )
    allowed &= alive[:, None] & alive[None]
    source, target = np.nonzero(allowed)
    inner = library.node_measure[target] > 0
    shift, yaw = transitions.shift[source, target], transitions.yaw[source, target]
    transform = np.column_stack([shift, yaw])
    transform[inner] = 0.0
    cost = np.where(inner, 0.0, transitions.distance[source, target])
    facing_start, facing_end, facing_mean = _facing(library, window)
    turns = _turns(library, window)
    poses = unmatched_poses(library)
    dead = [
        f"{name}: {poses.get(name, f'nothing leads to it and away again within {threshold:g} m')}"
        for step, name in enumerate(library.steps)
        if not alive[library.node_step == step].any()
    ]
    return MotionGraph(
        library=library,
        edge_start=np.searchsorted(source, np.arange(library.node_count + 1)).astype(np.int32),
        edge_target=target.astype(np.int32),
        edge_cost=np.ascontiguousarray(cost, np.float64),
        edge_transform=np.ascontiguousarray(transform, np.float64),
        hops=_hops(library, allowed, alive),
        node_end=_root_at(library, library.node_last),
        node_facing=facing_end,
        node_facing_start=facing_start,
        node_facing_mean=facing_mean,
        node_start=_root_at(library, library.node_first),
        node_turns=np.ascontiguousarray(np.stack([turn.rows() for turn in turns])),
        node_quickest=np.array([float(turn.quickest) for turn in turns]),
        takes=find_takes(library),
        alive=alive,
        window=window,
        missing=tuple(dead),
    )


def allowed_edges(library: StepLibrary, transitions: Transitions, threshold: float) -> Bool:
    """Which ordered pairs of nodes may follow each other, before dead ends are pruned, shape (N, N)."""
    leaves = library.node_measure == library.node_measures - 1
    enters = library.node_measure == 0
    allowed = (transitions.distance <= threshold) & leaves[:, None] & enters[None] & may_follow(library)
    inside = np.flatnonzero(~leaves)
    allowed[inside, inside + 1] = True  # the measures of one clip are neighbours in the library
    return np.asarray(allowed, np.bool_)


def largest_component(allowed: Bool) -> Bool:
    """Nodes of the largest strongly connected component, shape (N,): dead ends are pruned (T037)."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    _, label = connected_components(csr_array(allowed), directed=True, connection="strong")
    size = np.bincount(label)
    source, target = np.nonzero(allowed)
    lives = np.zeros(len(size), np.bool_)  # a lone node without an edge to itself is a component, but no dance
    lives[label[source[label[source] == label[target]]]] = True
    return np.asarray(label == np.argmax(size + lives * len(label)), np.bool_)


def _hops(library: StepLibrary, allowed: Bool, alive: Bool) -> Int32:
    """Breadth-first from each step's first measures against the arrows, shape (C, N)."""
    hops = np.full((len(library.steps), library.node_count), NEVER, np.int32)
    for step in range(len(library.steps)):
        front = alive & (library.node_step == step) & (library.node_measure == 0)
        distance = 0
        while front.any():
            hops[step, front] = distance
            distance += 1
            front = allowed[:, front].any(axis=1) & (hops[step] == NEVER)
    return hops


def _turns(library: StepLibrary, window: float) -> list[SupportTurns]:
    """Support turns of every node."""
    feet = _feet(library)
    return [
        support_turns(library.clips[n], int(m), window=min(window, 0.9), softness=TURN_SOFTNESS, feet=feet[n])
        for n, m in zip(library.node_clip, library.node_measure, strict=True)
    ]


def _feet(library: StepLibrary) -> list[Feet]:
    """The feet of every clip, by one run of the pose pipeline over all samples."""
    skeleton, joints = PoseSkeleton.legs_only()
    pipeline = PosePipeline(len(library.clip_root), skeleton)
    pipeline.sample[0] = np.arange(len(library.clip_root))
    position = pipeline.run(library.leg_store)[0].astype(np.float64)
    ankles, balls = (np.searchsorted(joints, names) for names in (ANKLES, BALLS))
    feet, begin = [], 0
    for clip in library.clips:
        own = position[begin : begin + clip.clip.sample_count]
        feet.append(Feet(own[:, ankles], own[:, balls]))
        begin += clip.clip.sample_count
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
    pairs = (("leftUpperLeg", "rightUpperLeg"), ("leftUpperArm", "rightUpperArm"))

    def mean(cloud: Float64) -> Float64:
        total = np.zeros(len(cloud), np.complex128)
        for left, right in pairs:
            across = cloud[:, :, SKELETON.index(left)] - cloud[:, :, SKELETON.index(right)]
            direction = across[..., 0] + 1j * across[..., 2]
            total += (direction / np.maximum(np.abs(direction), 1e-9)).mean(axis=1)
        # facing +z the left side is at +x: heading 0 is direction 1 + 0i, and yaw turns it by exp(-i yaw)
        return np.ascontiguousarray(-np.angle(total), np.float64)

    return mean(start), mean(end), mean(whole)
