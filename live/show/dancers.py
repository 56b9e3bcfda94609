"""Dancers: which measure each dancer is in, where its clip lies on the stage, and the pose at any moment of it."""

import numpy as np
import numpy.typing as npt

from live.base.kernels import ease
from live.graph.library import StepLibrary
from live.graph.motion_graph import MotionGraph
from live.motion.pose import PoseBuffer

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

UNDECIDED = -1


def turn_vectors(vectors: Float64, yaw: Float64) -> Float64:
    """Rotate stage vectors (A, 2) by yaw (A,) about +Y: (0, 1) becomes (sin yaw, cos yaw)."""
    c, s = np.cos(yaw), np.sin(yaw)
    x, z = vectors[:, 0], vectors[:, 1]
    return np.stack([x * c + z * s, z * c - x * s], axis=1)


def transition_weight(into: float) -> float:
    """Weight of the next clip when the share `into` of the transition has passed: C1, after Kovar (K004)."""
    return ease(into)


class Dancers:
    """The dancing state of A dancers: plain arrays, replaced as a whole at measure lines."""

    def __init__(self, graph: MotionGraph, dancer_count: int) -> None:
        self.graph = graph
        self.node: Int32 = np.zeros(dancer_count, np.int32)
        """Node danced now, shape (A,)."""
        self.placement: Float64 = np.zeros((dancer_count, 3))
        """x, z [m], yaw [rad] of the axes of its clip on the stage, shape (A, 3)."""
        self.correction: Float64 = np.zeros((dancer_count, 3))
        """What is added over the measure so that it ends where it should: x, z [m], yaw [rad], shape (A, 3)."""
        self.next_node: Int32 = np.full(dancer_count, UNDECIDED, np.int32)
        """Node of the next measure, UNDECIDED until a beat before the measure line."""
        self.next_placement: Float64 = np.zeros((dancer_count, 3))
        self.next_correction: Float64 = np.zeros((dancer_count, 3))
        self._buffer = PoseBuffer(dancer_count)
        self._sample_a, self._sample_b = np.zeros(dancer_count), np.zeros(dancer_count)
        self._weight = np.zeros(dancer_count)
        self._place_a, self._place_b = np.zeros((dancer_count, 4)), np.zeros((dancer_count, 4))

    @property
    def decided(self) -> bool:
        """Whether the next measure of every dancer is chosen."""
        return bool((self.next_node >= 0).all())

    def start(self, node: Int32, position: Float64, heading: Float64) -> None:
        """Put every dancer at the beginning of a node: hips at `position` (A, 2) [m], body facing `heading` (A,)."""
        library = self.graph.library
        self.node[:] = node
        yaw = heading - self.graph.node_facing_start[node]
        first = np.stack([library.clip_root[np.round(library.node_first[node]).astype(int), c] for c in (0, 2)], axis=1)
        self.placement[:, :2] = position - turn_vectors(first.astype(np.float64), yaw)
        self.placement[:, 2] = yaw
        self.correction[:] = 0.0
        self.next_node[:] = UNDECIDED

    def end_placement(self) -> Float64:
        """The axes (x, z, yaw) in which each dancer's clip lies when the measure ends, correction included, (A, 3)."""
        end = self.graph.node_end[self.node]
        yaw = self.placement[:, 2] + self.correction[:, 2]
        hips = self.placement[:, :2] + turn_vectors(end, self.placement[:, 2]) + self.correction[:, :2]
        return np.ascontiguousarray(np.column_stack([hips - turn_vectors(end, yaw), yaw]))

    def end_position(self) -> Float64:
        """Where the hips of each dancer will be at the measure's end [m], shape (A, 2)."""
        end = self.graph.node_end[self.node]
        return self.placement[:, :2] + turn_vectors(end, self.placement[:, 2]) + self.correction[:, :2]

    def hips(self, fraction: float) -> Float32:
        """Where the hips of each dancer are at the share `fraction` of the measure [m], float32, shape (A, 2)."""
        library = self.graph.library
        first = library.node_first[self.node]
        sample = np.floor(first + fraction * (library.node_last[self.node] - first)).astype(np.int64)
        root = library.clip_root[sample][:, (0, 2)].astype(np.float64)
        place = self.placement[:, :2] + turn_vectors(root, self.placement[:, 2])
        return np.ascontiguousarray(place + ease(fraction) * self.correction[:, :2], np.float32)

    def contact(self, fraction: float) -> npt.NDArray[np.bool_]:
        """Whether the left and right foot are annotated as on the floor in the clip that weighs more, shape (A, 2)."""
        library = self.graph.library
        self._fill_samples(library, fraction)
        sample = np.where(self._weight > 0.5, self._sample_b, self._sample_a)
        contact = library.clip_contact[np.round(sample).astype(np.int64)]
        # while two clips are blended a foot counts only if both have it on the floor
        other = library.clip_contact[np.round(np.where(self._weight > 0.5, self._sample_a, self._sample_b)).astype(int)]
        blended = (self._weight > 0.0) & (self._weight < 1.0)
        return np.asarray(np.where(blended[:, None], contact & other, contact), np.bool_)

    def cross_measure_line(self) -> None:
        """The next measure becomes the present one."""
        self.node[:] = self.next_node
        self.placement[:] = self.next_placement
        self.correction[:] = self.next_correction
        self.next_node[:] = UNDECIDED

    def pose(self, fraction: float, out: tuple[Float32, Float32] | None = None) -> tuple[Float32, Float32]:
        """World positions (A, J, 3) and rotations (A, J, 4) when the share `fraction` of the measure has passed.

        Fills `out` if given, else the dancers' own buffer; returns what it filled.
        """
        library = self.graph.library
        self._fill_samples(library, fraction)
        share = ease(fraction)
        self._place_a[:, :3] = self.placement
        self._place_a[:, :2] += share * self.correction[:, :2]
        self._place_a[:, 3] = self.placement[:, 2] + share * self.correction[:, 2]
        self._place_b[:, :3] = self.next_placement
        self._place_b[:, 3] = self.next_placement[:, 2]
        self._buffer.sample(
            library.clip_root,
            library.clip_rotation,
            sample_a=self._sample_a,
            sample_b=self._sample_b,
            weight=self._weight,
            placement_a=self._place_a,
            placement_b=self._place_b,
            out=out,
        )
        return out if out is not None else (self._buffer.world_position, self._buffer.world_rotation)

    def _fill_samples(self, library: StepLibrary, fraction: float) -> None:
        """Clip time follows the beat: samples of the present clip and of the lead-in of the next one."""
        first = library.node_first[self.node]
        self._sample_a[:] = first + fraction * (library.node_last[self.node] - first)
        window = self.graph.window
        into = (fraction - (1.0 - window)) / window
        coming = np.maximum(self.next_node, 0)
        first = library.node_first[coming]
        back = (fraction - 1.0) * (library.node_last[coming] - first)
        self._sample_b[:] = np.maximum(first + back, library.node_lead[coming])
        self._weight[:] = transition_weight(into) if into > 0.0 else 0.0
        self._weight[self.next_node < 0] = 0.0
