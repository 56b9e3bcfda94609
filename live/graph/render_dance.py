"""Rendering of a path through the graph to one continuous motion, blended, turned and foot-locked as in the live show.

The pose pipeline processes all samples of the dance at once, as if each were a dancer. Only the feet are processed in
time order, because a foot lock depends on the previous foot position.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import (
    following_placement,
    next_axes,
    own_end,
    starting_placement,
    take_placement,
    transition_weight,
    turn_vectors,
)
from live.graph.takes import NO_TAKE
from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.forward_kinematics import local_rotations
from live.motion.pose.arm_clearance import clear_own_trunk
from live.motion.pose.foot_lock import lock_feet
from live.motion.pose.pipeline_kernels import (
    INTO_NEXT,
    LOWER,
    NEXT,
    NEXT_LOWER,
    NEXT_TAKE,
    PRESENT,
    PRESENT_TAKE,
    UPPER,
)
from live.motion.pose.pose_pipeline import PosePipeline
from live.motion.pose.turn_kernels import place_dancers

SAMPLE_RATE = 60.0
MAX_SAMPLES = 400_000
"""Maximum samples of a dance: nearly two hours at 60 a second, about 1 GB during rendering."""


@dataclass(frozen=True, slots=True, eq=False)
class RenderedDance:
    """A dance of M measures as one clip, with its measure data."""

    clip: Clip
    """From the first to the last measure line; foot contacts as in the source clips, in a blend in both."""
    bpm: float
    beats_per_measure: int
    node: Int32
    """Nodes danced, shape (M,)."""
    line_time: Float64
    """Times of the measure lines [s], shape (M + 1,); the last one is the end."""
    placement: Float64
    """x, z [m], yaw [rad] of the axes of each measure's clip, shape (M, 3)."""
    correction: Float64
    """Corrections over each measure: x, z [m], and the turn on the supporting foot [rad], shape (M, 3)."""
    take: Int32
    """Node of the other take mixed into each measure, NO_TAKE if none, shape (M,)."""
    take_share: Float64
    """Share of the other take, shape (M,)."""
    end: Float64
    """Planned hips x, z [m] and heading [rad] at the end of each measure, shape (M, 3)."""
    join: Float64
    """Begin and end [s] of the blend of each join of two clips, shape (K, 2); there is none within a step."""

    @property
    def beat_time(self) -> Float64:
        """Times of the beats [s], shape (M · beats + 1,)."""
        return np.asarray(np.arange(len(self.node) * self.beats_per_measure + 1) * (60.0 / self.bpm), np.float64)


def render_dance(
    graph: MotionGraph,
    nodes: Sequence[int] | Int32,
    *,
    bpm: float,
    turns: npt.ArrayLike | None = None,
    corrections: npt.ArrayLike | None = None,
    takes: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    hold_feet: bool = True,
    clear_arms: bool = True,
    sample_rate: float = SAMPLE_RATE,
    name: str = "dance",
) -> RenderedDance:
    """Return the motion of a dancer through the M `nodes` at `bpm`.

    `turns` (M,) [rad] are inserted while one foot supports (T048-T050). `corrections` (M, 2) [m] displace the hips over
    each measure. `takes` are a node (M,) and a share (M,) from 0 to 1 of another take of the same measure to mix in
    (T069; NO_TAKE for none). The hips begin at `start` x, z [m], facing its third number [rad]. Blends end on measure
    lines, weights are C1 (K004), rotations use SLERP, the root is linear, the graph's rigid transform places each clip
    (K001). `hold_feet`: supporting feet stay in place and no sole goes below the floor. `clear_arms`: arms keep out of
    the own trunk. There are `sample_rate` samples a second; the last one is at or before the last line. ValueError
    for a pair of nodes without an edge, arrays of other lengths or a dance that is too long.
    """
    node = np.asarray(nodes, np.int32)
    count = len(node)
    seconds = graph.library.beats_per_measure * 60.0 / bpm if np.isfinite(bpm) and bpm > 0.0 else np.nan
    _check(graph, node, seconds, sample_rate)
    correction = np.zeros((count, 3))
    correction[:, :2] = _checked_array(corrections, (count, 2), "corrections")
    correction[:, 2] = _checked_array(turns, (count,), "turns")
    take = np.full(count, NO_TAKE, np.int32)
    share = np.zeros(count)
    if takes is not None:
        take[:] = _checked_array(takes[0], (count,), "takes")
        share[:] = np.where(take != NO_TAKE, _checked_array(takes[1], (count,), "shares of takes"), 0.0)
    placement, end = _placements(graph, node, correction, take, share, start)
    dance = _Dance(graph, node, placement, correction, take, share)
    time = np.arange(int(count * seconds * sample_rate + 1e-6) + 1) / sample_rate
    clip = dance.clip(time / seconds, sample_rate, name)
    if hold_feet:
        clip = lock_feet(clip)
    if clear_arms:
        clip = clear_own_trunk(clip)
    line_time = np.arange(count + 1, dtype=np.float64) * float(seconds)
    joins = np.flatnonzero(graph.library.node_measure[node[1:]] == 0)
    return RenderedDance(
        clip=clip,
        bpm=bpm,
        beats_per_measure=graph.library.beats_per_measure,
        node=node,
        line_time=line_time,
        placement=placement,
        correction=correction,
        take=take,
        take_share=share,
        end=end,
        join=line_time[joins + 1, None] - np.array([graph.window * seconds, 0.0]),
    )


def _check(graph: MotionGraph, node: Int32, seconds: float, sample_rate: float) -> None:
    if not np.isfinite(seconds) or not np.isfinite(sample_rate) or sample_rate <= 0.0:
        raise ValueError(f"{seconds} s a measure, {sample_rate} samples/s: numbers above 0 expected")
    if len(node) == 0 or node.min() < 0 or node.max() >= graph.library.node_count:
        raise ValueError(f"a path of nodes 0 to {graph.library.node_count - 1} expected, at least one")
    if len(node) * seconds * sample_rate > MAX_SAMPLES:
        most = MAX_SAMPLES / sample_rate
        raise ValueError(
            f"{len(node)} measures of {seconds:.3g} s are {len(node) * seconds / 60.0:.0f} minutes; "
            f"at most {most / 60.0:.0f} can be put together at once"
        )


def _checked_array(values: npt.ArrayLike | None, shape: tuple[int, ...], what: str) -> Float64:
    if values is None:
        return np.zeros(shape)
    array = np.asarray(values, np.float64)
    if array.shape != shape or not np.isfinite(array).all():
        raise ValueError(f"{what}: numbers of shape {shape} expected, got shape {array.shape}")
    return array


def edge_between(graph: MotionGraph, u: int, v: int) -> int:
    """Return the index of the edge from node u to node v; ValueError, naming both, if there is none."""
    first, last = int(graph.edge_start[u]), int(graph.edge_start[u + 1])
    found = np.flatnonzero(graph.edge_target[first:last] == v)
    if not len(found):
        library = graph.library
        raise ValueError(f"no edge leads from {library.describe(u)!r} (node {u}) to {library.describe(v)!r} (node {v})")
    return first + int(found[0])


def _placements(
    graph: MotionGraph,
    node: Int32,
    correction: Float64,
    take: Int32,
    share: Float64,
    start: tuple[float, float, float],
) -> tuple[Float64, Float64]:
    """Return the placement of each measure's clip (M, 3), and hips and heading at its end (M, 3), in sequence."""
    placement, end = np.empty((len(node), 3)), np.empty((len(node), 3))
    ends, facings = own_end(graph, node, take, share)
    placed, one = np.empty((1, 4)), np.ones(1)
    for n in range(len(node)):
        row = slice(n, n + 1)
        if n == 0:
            placement[row] = starting_placement(graph, node[row], np.array([start[:2]]), np.array([start[2]]))
        else:
            axes = next_axes(graph, node[n - 1 : n], end[n - 1 : n, :2], end[n - 1 : n, 2])
            edge = edge_between(graph, int(node[n - 1]), int(node[n]))
            placement[row] = following_placement(axes, graph.edge_transform[edge : edge + 1])
        place_dancers(
            placed, placement[row], correction[row], np.zeros((1, 3)), one, node[row],
            graph.node_turns, graph.node_warp_curve, one,
        )  # fmt: skip
        end[n, :2] = placed[0, :2] + turn_vectors(ends[n], placed[0, 2])
        end[n, 2] = placed[0, 3] + facings[n]
    return placement, end


@dataclass(frozen=True, slots=True, eq=False)
class _Dance:
    """Input of the pose pipeline: for any place in the dance, the samples, clips and placements."""

    graph: MotionGraph
    node: Int32
    placement: Float64
    correction: Float64
    take: Int32
    share: Float64

    def clip(self, place: Float64, sample_rate: float, name: str) -> Clip:
        """Return the dance at `place` (T,), in measures from its beginning."""
        measure = np.minimum(place.astype(np.int64), len(self.node) - 1)
        phase = np.minimum(place - measure, 1.0)
        following = np.minimum(measure + 1, len(self.node) - 1)
        pipeline = PosePipeline(len(place))
        window = self.graph.window
        into = transition_weight((phase - (1.0 - window)) / window) * (following > measure)
        self._fill(pipeline, PRESENT, measure, phase, np.ones(len(place)))
        self._fill(pipeline, NEXT, following, phase - 1.0, np.zeros(len(place)))
        pipeline.share[INTO_NEXT] = into
        contact = self._contact(pipeline, into)
        position, rotation = pipeline.run(self.graph.library.store)
        return Clip(
            name,
            np.ascontiguousarray(position[:, 0]),
            np.ascontiguousarray(quaternion.align_signs(local_rotations(rotation)), np.float32),
            sample_rate,
            contact,
        )

    def _fill(
        self, pipeline: PosePipeline, which: int, measure: npt.NDArray[np.int64], phase: Float64, corrected: Float64
    ) -> None:
        """Fill the rows `which` (the measure's own clip) and `which` + 1 (its other take) at `phase` of the measures.

        `corrected` (T,): 1 where corrections apply, 0 in the lead-in, where they have not begun.
        """
        node, take = self.node[measure], self.take[measure]
        placed = np.empty((len(node), 4))
        place_dancers(
            placed, self.placement[measure], self.correction[measure] * corrected[:, None], np.zeros((len(node), 3)),
            np.maximum(phase, 0.0), node, self.graph.node_turns, self.graph.node_warp_curve, np.ones(len(node)),
        )  # fmt: skip
        other = np.where(take == NO_TAKE, node, take).astype(np.int32)
        for row, of in ((which, node), (which + 1, other)):
            pipeline.sample[row] = self._sample(of, phase)
        pipeline.placement[which] = placed
        pipeline.placement[which + 1] = take_placement(self.graph, node, other, placed)
        lower = LOWER if which == PRESENT else NEXT_LOWER
        pipeline.share[lower : lower + UPPER - LOWER + 1] = self.share[measure]

    def _sample(self, node: Int32, phase: Float64) -> Float64:
        """Return library samples at `phase` of the nodes' measures; below 0 is in their lead-in."""
        library = self.graph.library
        first = library.node_first[node]
        return np.maximum(first + phase * (library.node_last[node] - first), library.node_lead[node])

    def _contact(self, pipeline: PosePipeline, into: Float64) -> Bool:
        """Return feet on the floor, (T, 2): where all mixed clips have contact."""
        contact = self.graph.library.clip_contact
        standing = [contact[np.round(sample).astype(np.int64)] for sample in pipeline.sample]
        for row, share in ((PRESENT, LOWER), (NEXT, NEXT_LOWER)):
            take = PRESENT_TAKE if row == PRESENT else NEXT_TAKE
            standing[row] = standing[row] & (standing[take] | (pipeline.share[share] <= 0.0)[:, None])
        blends, done = (into > 0.0)[:, None], (into >= 1.0)[:, None]
        return np.asarray((standing[PRESENT] | done) & (standing[NEXT] | ~blends), np.bool_)
