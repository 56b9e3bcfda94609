"""Danced: one measure of every dancer, which clip, where on the stage, and how it is varied."""

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import own_end, take_placement, turn_vectors
from live.graph.takes import NO_TAKE
from live.motion.pose.gather_kernels import same_measures
from live.motion.pose.root_warp_kernels import bound_aims, re_aim_dancers
from live.motion.pose.turn_kernels import end_dancers, place_dancers

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

__all__ = ["UNDECIDED", "Danced", "turn_vectors"]

UNDECIDED = -1
LEAST_LEFT = 0.15
"""Share of the rise that must be left for a correction to be aimed anew: with less it would be a jerk."""


class _Ends:
    """Where the measures of a `Danced` end in their clips' own axes, and what that was worked out of."""

    def __init__(self, danced: "Danced") -> None:
        self._node, self._take, self._share = danced.node.copy(), danced.take.copy(), danced.take_share[0].copy()
        self._graph = danced.graph
        self.hips, self.heading = own_end(self._graph, self._node, self._take, self._share.astype(np.float64))

    def still(self, danced: "Danced") -> bool:
        """Whether `danced` holds the same measures."""
        same = same_measures(danced.node, self._node, danced.take, self._take, danced.take_share[0], self._share)
        return self._graph is danced.graph and same

    def leap(self, rows: Int32, node: Int32) -> None:
        """The dancers `rows` (n,) dance `node` (n,) alone: what is known of the others stays."""
        self._node[rows], self._take[rows], self._share[rows] = node, NO_TAKE, 0.0
        known = np.maximum(node, 0)
        self.hips[rows], self.heading[rows] = self._graph.node_end[known], self._graph.node_facing[known]


class Danced:
    """Plain arrays over A dancers; `copy_from` replaces them as a whole at a measure line."""

    ARRAYS = ("node", "placement", "correction", "aimed", "on_support", "take", "take_share", "amplitude", "warp")

    def __init__(self, graph: MotionGraph, count: int) -> None:
        self.graph = graph
        self._ends: _Ends | None = None
        self.decided = False
        """Whether the measure of every dancer is chosen."""
        self.node: Int32 = np.full(count, UNDECIDED, np.int32)
        """Node danced, UNDECIDED before it is chosen, shape (A,)."""
        self.placement: Float64 = np.zeros((count, 3))
        """x, z [m], yaw [rad] of the axes of its clip on the stage, shape (A, 3)."""
        self.correction: Float64 = np.zeros((count, 3))
        """What is added over the measure so that it ends where it should: x, z [m], yaw [rad], shape (A, 3)."""
        self.aimed: Float64 = np.zeros((count, 3))
        """The way x, z [m] of it that was in when it was aimed anew, and the share of the rise at that time, (A, 3)."""
        self.on_support: Float64 = np.zeros(count)
        """1 where the turn happens on the carrying foot (T048-T050), 0 where it is spread over the measure, (A,)."""
        self.take: Int32 = np.full(count, NO_TAKE, np.int32)
        """Node of the other take that is mixed in, NO_TAKE if none is, shape (A,)."""
        self.take_share: Float32 = np.zeros((2, count), np.float32)
        """How much of it there is in the lower and in the upper body, shape (2, A) (T044, T045)."""
        self.amplitude: Float64 = np.ones((2, count))
        """Amplitude of the upper body where the measure begins and where it ends, shape (2, A) (T058-T060)."""
        self.warp: Float64 = np.zeros((4, count))
        """Time warp of the measure: amplitude and start as shares of it, frequency, sign, (4, A) (T055)."""

    def copy_from(self, other: "Danced") -> None:
        """Take over everything; views into the arrays stay valid."""
        for name in self.ARRAYS:
            getattr(self, name)[:] = getattr(other, name)
        self.decided, self._ends = other.decided, other._ends

    def undecide(self) -> None:
        """Nobody's measure is chosen any more."""
        self.node[:] = UNDECIDED
        self.decided = False

    def turned(self, fraction: Float64, out: Float64) -> None:
        """Placements (A, 4) with the corrections' share in them when `fraction` (A,) of the measure has passed."""
        place_dancers(
            out,
            self.placement,
            self.correction,
            self.aimed,
            fraction,
            np.maximum(self.node, 0),
            self.graph.node_turns,
            self.graph.node_rise,
            self.on_support,
        )

    def bound_aims(self, goal: Float64, phase: Float64, most: Float64) -> None:
        """Change what corrections shall lead to, `goal` (A, 2) [m], to what can still be reached from `phase` (A,) on.

        In the rest of a measure nobody goes faster than with `most` (A,) [m] in the whole, or than she goes already.
        """
        rise = self.graph.node_rise
        bound_aims(goal, self.correction, self.aimed, phase, self.node, rise, most, LEAST_LEFT)

    def re_aim(self, correction: Float64, phase: Float64) -> None:
        """From `phase` (A,) of their measures on let the dancers' ways lead to `correction` (A, 2) [m] instead.

        Nobody jumps, and who moves goes on without a kink where `correction` changes smoothly from call to call. Who
        is in the last LEAST_LEFT of her rise keeps what she has.
        """
        re_aim_dancers(self.correction, self.aimed, correction, phase, self.node, self.graph.node_rise, LEAST_LEFT)

    def leap(self, rows: Int32, node: Int32, placement: Float64) -> None:
        """The dancers `rows` (n,) dance `node` (n,) instead, its clip's axes at `placement` (n, 3); nothing is added or
        mixed in. Time warp and amplitude stay theirs."""
        self.node[rows], self.placement[rows] = node, placement
        self.correction[rows] = self.aimed[rows] = 0.0
        self.take[rows], self.take_share[:, rows] = NO_TAKE, 0.0
        if self._ends is not None:
            self._ends.leap(rows, node)

    def take_placement(self, placement: Float64) -> Float64:
        """Where the other takes' clips lie, (A, 4), when the dancers' own lie at `placement` (A, 4)."""
        return take_placement(self.graph, self.node, self.take, placement)

    def own_end(self) -> tuple[Float64, Float64]:
        """Hips (A, 2) [m] and heading (A,) [rad] at the measure's end in the clips' own axes, takes mixed in."""
        known = self._ends
        if known is None or not known.still(self):
            self._ends = known = _Ends(self)
        return known.hips, known.heading

    def end_placement(self) -> Float64:
        """The axes (x, z, yaw) in which the next clip joins, corrections and takes included, (A, 3)."""
        return self.ends_and_axes()[2]

    def ends(self) -> tuple[Float64, Float64]:
        """Where the hips will be at the measure's end [m], (A, 2), and where the dancers will face [rad], (A,)."""
        return self.ends_and_axes()[:2]

    def ends_and_axes(self) -> tuple[Float64, Float64, Float64]:
        """Both `ends` and `end_placement`."""
        graph, (end, facing), count = self.graph, self.own_end(), len(self.node)
        hips, heading, axes = np.empty((count, 2)), np.empty(count), np.empty((count, 3))
        end_dancers(
            hips, heading, axes, self.placement, self.correction, self.aimed, self.node, graph.node_turns,
            graph.node_rise, self.on_support, end, facing, graph.node_end, graph.node_facing,
        )  # fmt: skip
        return hips, heading, axes

    def end_position(self) -> Float64:
        """Where the hips will be at the measure's end [m], shape (A, 2)."""
        return self.ends()[0]

    def begin_heading(self) -> Float64:
        """Where the dancers face when the measure begins [rad], shape (A,)."""
        return np.asarray(self.placement[:, 2] + self.graph.node_facing_start[np.maximum(self.node, 0)])

    def end_heading(self) -> Float64:
        """Where the dancers face at the measure's end [rad], shape (A,)."""
        return self.ends()[1]
