"""State of one measure of every dancer: its clip, its placement on the stage and its variation."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.graph.select.candidates import own_end
from live.graph.takes import NO_TAKE
from live.motion.pose.gather_kernels import same_measures
from live.motion.pose.turn_kernels import end_dancers

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph


UNDECIDED = -1
MIN_REMAINING_WARP = 0.15
"""Share of the warp curve that must be left for a correction to be re-aimed: with less, the change would be a jerk."""


class _CachedEnds:
    """Cache of where the measures of a `Danced` end in their clips' own axes, with the inputs of that result."""

    def __init__(self, measure: "MeasureState") -> None:
        self._node, self._take, self._share = measure.node.copy(), measure.take.copy(), measure.take_share[0].copy()
        self._graph = measure.graph
        self.hips, self.heading = own_end(self._graph, self._node, self._take, self._share.astype(np.float64))

    def is_valid(self, measure: "MeasureState") -> bool:
        """Whether `measure` still holds the same measures."""
        same = same_measures(measure.node, self._node, measure.take, self._take, measure.take_share[0], self._share)
        return self._graph is measure.graph and same

    def replace_node(self, rows: Int32, node: Int32) -> None:
        """Update the dancers `rows` (n,) to `node` (n,) without another take. All other rows stay valid."""
        self._node[rows], self._take[rows], self._share[rows] = node, NO_TAKE, 0.0
        known = np.maximum(node, 0)
        self.hips[rows], self.heading[rows] = self._graph.node_end[known], self._graph.node_facing[known]


class MeasureState:
    """One measure of A dancers, as plain arrays. `copy_from` replaces all of them at a measure line."""

    ARRAYS = (
        "node", "placement", "correction", "aim_origin", "foot_aim", "on_support", "take", "take_share", "amplitude",
        "warp",
    )  # fmt: skip

    def __init__(self, graph: "MotionGraph", count: int) -> None:
        self.graph = graph
        self._ends: _CachedEnds | None = None
        self.decided = False
        """Whether the measure of every dancer is chosen."""
        self.node: Int32 = np.full(count, UNDECIDED, np.int32)
        """Node of each dancer, UNDECIDED before it is chosen, shape (A,)."""
        self.placement: Float64 = np.zeros((count, 3))
        """x, z [m], yaw [rad] of the clip's axes on the stage, shape (A, 3)."""
        self.correction: Float64 = np.zeros((count, 3))
        """Offset added over the measure so that it ends at its target: x, z [m], yaw [rad], shape (A, 3)."""
        self.aim_origin: Float64 = np.zeros((count, 3))
        """The part x, z [m] of it already applied at the last re-aim, and the warp curve's value then, (A, 3)."""
        self.foot_aim: Float64 = np.zeros((count, 2, 6))
        """The same of both feet, columns as in `footstep_kernels`, (A, 2, 6)."""
        self.on_support: Float64 = np.zeros(count)
        """1 where the turn happens on the support foot (T048-T050), 0 where it is spread over the measure, (A,)."""
        self.take: Int32 = np.full(count, NO_TAKE, np.int32)
        """Node of the other take that is mixed in, NO_TAKE for none, shape (A,)."""
        self.take_share: Float32 = np.zeros((2, count), np.float32)
        """Weight of that take in the lower and in the upper body, shape (2, A) (T044, T045)."""
        self.amplitude: Float64 = np.ones((2, count))
        """Amplitude of the upper body at the beginning and end of the measure, shape (2, A) (T058-T060)."""
        self.warp: Float64 = np.zeros((4, count))
        """Time warp of the measure: amplitude and start as shares of it, frequency, sign, (4, A) (T055)."""

    def copy_from(self, other: "MeasureState") -> None:
        """Copy all state of `other`. Views into the arrays stay valid."""
        for name in self.ARRAYS:
            getattr(self, name)[:] = getattr(other, name)
        self.decided, self._ends = other.decided, other._ends

    def undecide(self) -> None:
        """Mark the measures of all dancers as not chosen."""
        self.node[:] = UNDECIDED
        self.decided = False

    def replace_node(self, rows: Int32, node: Int32, placement: Float64) -> None:
        """Switch the dancers `rows` (n,) to `node` (n,), with the clip's axes at `placement` (n, 3).

        Their correction and their other take are removed. Time warp and amplitude stay.
        """
        self.node[rows], self.placement[rows] = node, placement
        self.clear_correction(rows)
        self.take[rows], self.take_share[:, rows] = NO_TAKE, 0.0
        if self._ends is not None:
            self._ends.replace_node(rows, node)

    def clear_correction(self, rows: npt.NDArray[np.integer] | slice = slice(None)) -> None:
        """Remove the correction of the dancers `rows` (n,)."""
        self.correction[rows] = self.aim_origin[rows] = 0.0
        self.foot_aim[rows] = 0.0

    def own_end(self) -> tuple[Float64, Float64]:
        """Hips (A, 2) [m] and heading (A,) [rad] at the measure's end in the clips' own axes, other takes included."""
        known = self._ends
        if known is None or not known.is_valid(self):
            self._ends = known = _CachedEnds(self)
        return known.hips, known.heading

    def set_graph(self, graph: "MotionGraph") -> None:
        """Use a graph in which all nodes of the present one keep their indices."""
        self.graph, self._ends = graph, None

    def end_placement(self) -> Float64:
        """Axes (x, z, yaw) at which the next clip joins, corrections and takes included, (A, 3)."""
        return self.ends_and_axes()[2]

    def ends(self) -> tuple[Float64, Float64]:
        """Hips (A, 2) [m] and heading (A,) [rad] on the stage at the measure's end."""
        return self.ends_and_axes()[:2]

    def ends_and_axes(self) -> tuple[Float64, Float64, Float64]:
        """Both `ends` and `end_placement`."""
        graph, (end, facing), count = self.graph, self.own_end(), len(self.node)
        hips, heading, axes = np.empty((count, 2)), np.empty(count), np.empty((count, 3))
        end_dancers(
            hips, heading, axes, self.placement, self.correction, self.aim_origin, self.node, graph.node_turns,
            graph.node_warp_curve, self.on_support, end, facing, graph.node_end, graph.node_facing,
        )  # fmt: skip
        return hips, heading, axes

    def end_position(self) -> Float64:
        """Hips on the stage at the measure's end [m], shape (A, 2)."""
        return self.ends()[0]

    def begin_heading(self) -> Float64:
        """Heading of each dancer at the beginning of the measure [rad], shape (A,)."""
        return np.asarray(self.placement[:, 2] + self.graph.node_facing_start[np.maximum(self.node, 0)])

    def end_heading(self) -> Float64:
        """Heading of each dancer at the measure's end [rad], shape (A,)."""
        return self.ends()[1]
