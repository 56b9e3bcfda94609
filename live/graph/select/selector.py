"""Step selector: tables of a graph from which the next measures of all dancers are chosen in one call (T068-T070)."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.base.row_ranges import run_rows
from live.graph.select.candidates import MAX_TURN_RATE, Candidates, find_candidates, widening_candidates, wrap_angle
from live.graph.select.reachability import ReachTable
from live.graph.select.selector_kernels import choose_measures
from live.motion.editing.tempo_forms import TEMPO_LIMITS

if TYPE_CHECKING:
    from live.graph.motion_graph import MotionGraph
    from live.graph.step_library import StepLibrary


ANGLES: Final = 65
"""Angles at which a turn's displacement is tabulated, from -π to π; interpolation errs by 1.5 mm a metre at most."""
TERMS: Final = ("place", "heading", "pose", "wrong step", "other")
"""The terms of a candidate's cost."""
PLACE_COST: Final = 10.0
"""Cost of a square metre of place error beyond correction ..."""
CORRECTION_COST: Final = 1.0
"""... of a square metre that is corrected, because the legs must compensate it, ..."""
HEADING_COST: Final = 1.0
"""... of a squared radian of remaining heading error, ..."""
TURN_COST: Final = 0.005
"""... of a squared radian of turning, ..."""
POSE_COST: Final = 4.0
"""... of a metre between the poses of a join, ..."""
WRONG_COST: Final = 40.0
"""... of a measure away from the wanted step: more than any place error within a measure's reach, ..."""
SIDE_COST: Final = 20.0
"""... of a mirror image where the group wants none: more than any place, less than another step, ..."""
MIXTURE_COST: Final = 0.003
"""... of a mixture, because 5 cm of place do not justify blurring a clip, ..."""
COSTS: Final = (PLACE_COST, CORRECTION_COST, HEADING_COST, TURN_COST, POSE_COST, WRONG_COST, SIDE_COST)
PROHIBITIVE_COST: Final = 1e9
"""Cost of a mixture where there should be none."""
DETOUR_COST: Final = 0.2
"""... and of the squared deviation [m²] of the hips from the straight line, to avoid detours."""
TEMPO_COST: Final = 12.0
"""Cost of a recorded measure at a tempo outside its limits, and of e times that excess: more than any place, less than
another step."""
SWAY_SAMPLES: Final = 17
FEWEST_DANCERS: Final = 16
"""So many dancers at least are worth a range of their own."""


@dataclass(frozen=True, slots=True, eq=False)
class StepSelector:
    """Tables over N nodes, E edges and K candidates, and values that may change between measures."""

    graph: "MotionGraph"
    candidates: Candidates
    reach_table: ReachTable
    """Reach of each step in each direction."""
    edge: Float64
    """x, z, yaw, its cosine and sine, distance of the poses of each edge, shape (E, 6)."""
    clip: Float64
    """Hips x, z [m] and heading at each candidate's end, cosine and sine, difference of the measure's mean heading to
        it, the largest distance of its end from that of the node's own clip [m], shape (K, 7)."""
    turn_offsets: Float64
    """Displacement that a turn adds to each node [m], shape (N, ANGLES, 2)."""
    max_turns: Float64
    """Each node's largest turn [rad], cosine and sine, shape (N, 3)."""
    facts: Float64
    """Maximum correction of each node in any direction [m], maximum distance of its mixtures' ends, its own cost,
    largest correction at all [m], shape (N, 4)."""
    detour_cost: Float64
    """The part of a node's own cost that does not depend on the tempo, shape (N,)."""
    recorded_seconds: Float64
    """Duration of each node's measure as recorded [s]; 0 for sketched steps, which fit any tempo, shape (N,)."""
    weights: Float64
    """Shape (8,)."""
    unmixed_weights: Float64
    """The same with a prohibitive cost of mixtures."""
    most_edges: int
    """Most edges of a node."""

    @staticmethod
    def of(graph: "MotionGraph") -> "StepSelector":
        """Build the tables of a graph. Too slow to be called within a frame."""
        candidates = widening_candidates(graph, find_candidates(graph))
        node, transform = candidates.node, graph.edge_transform
        c, s = np.cos(transform[:, 2]), np.sin(transform[:, 2])
        mean = wrap_angle(graph.node_facing_mean[node] - candidates.facing)
        facing = candidates.facing
        angles = np.linspace(-np.pi, np.pi, ANGLES)
        moved = np.empty((graph.library.node_count, ANGLES, 2))
        for n, angle in enumerate(angles):
            moved[:, n] = candidates.turns.displacement(1.0, np.full(len(moved), angle))
        facts = np.zeros((len(moved), 4))
        spread = _mixture_spread(candidates, moved, angles)
        np.maximum.at(facts[:, 1], node, spread)
        detour = DETOUR_COST * _detours(graph) ** 2
        facts[:, 2] = detour
        return StepSelector(
            graph=graph,
            candidates=candidates,
            reach_table=ReachTable.of(graph, candidates),
            edge=np.ascontiguousarray(np.column_stack([transform, c, s, graph.edge_cost])),
            clip=np.ascontiguousarray(
                np.column_stack([candidates.end, facing, np.cos(facing), np.sin(facing), mean, spread])
            ),
            turn_offsets=moved,
            max_turns=np.zeros((len(moved), 3)),
            facts=facts,
            detour_cost=detour,
            recorded_seconds=recorded_seconds(graph.library),
            weights=np.array([*COSTS, MIXTURE_COST]),
            unmixed_weights=np.array([*COSTS, PROHIBITIVE_COST]),
            most_edges=int(np.diff(graph.edge_start).max(initial=0)),
        )  # fmt: skip

    def set_limits(self, *, seconds: float, turn: float, correction: float) -> None:
        """Set the measure's `seconds`, the largest `turn` [rad], and the largest `correction` [m]."""
        angle = np.minimum(min(turn, np.pi), MAX_TURN_RATE * seconds / self.graph.node_peak_turn_rate)
        self.max_turns[:, 0] = angle
        self.max_turns[:, 1], self.max_turns[:, 2] = np.cos(angle), np.sin(angle)
        self.facts[:, 0] = np.minimum(self.graph.node_reach_margins.max(axis=1), correction)
        self.facts[:, 3] = correction
        self.facts[:, 2] = self.detour_cost + tempo_cost(self.recorded_seconds, seconds)

    def choose(
        self,
        rows: slice,
        node: Int32,
        placement: Float64,
        target: Float64,
        row: Int32,
        ahead: Float64,
        side: Int32,
        options: Float64,
        out: tuple[Int32, Int32, Float64, Float64],
        *,
        mixed: bool = True,
    ) -> None:
        """Choose for the dancers `rows`: arguments and results `out` (edge, candidate, terms, end) as in the kernel.

        `mixed`: among mixtures of measures, too.
        """
        graph = self.graph
        edge, candidate, terms, end = out
        weights = self.weights if mixed else self.unmixed_weights

        def part(begin: int, stop: int) -> None:
            choose_measures(
                rows.start + begin, rows.start + stop, node, placement, target, row, ahead, side, options,
                graph.edge_start, graph.edge_target, self.edge, self.candidates.first, self.clip, self.turn_offsets,
                self.max_turns, self.facts, graph.node_reach_margins, graph.library.node_side, weights,
                np.empty((self.most_edges + 1, 2)), edge, candidate, terms, end,
            )  # fmt: skip

        run_rows(part, rows.stop - rows.start, least=FEWEST_DANCERS)


def with_direction(values: Float64) -> Float64:
    """Return rows (A, 3) of x, z, angle with cosine and sine of the angle appended, (A, 5)."""
    return np.ascontiguousarray(np.column_stack([values, np.cos(values[:, 2]), np.sin(values[:, 2])]))


def recorded_seconds(library: "StepLibrary") -> Float64:
    """Return the duration of each node's measure as recorded [s], 0 for measures of sketched steps, (N,)."""
    seconds = [clip.samples_per_measure / clip.clip.sample_rate if clip.recorded else 0.0 for clip in library.clips]
    return np.array(seconds, np.float64)[library.node_clip]


def tempo_excess(recorded: Float64, seconds: float) -> Float64:
    """Return how far a measure of `seconds` is beyond the limits of the tempo for recorded ones, (N,).

    It is the logarithm of the excess: positive if danced too fast, negative if too slow, 0 within the limits.
    """
    ratio = np.log(np.where(recorded > 0.0, recorded, seconds) / seconds)
    return np.asarray(ratio - np.clip(ratio, math.log(TEMPO_LIMITS[0]), math.log(TEMPO_LIMITS[1])))


def tempo_cost(recorded: Float64, seconds: float) -> Float64:
    """Return the cost of dancing recorded measures (N,) [s] in `seconds`, outside the limits of the tempo, (N,)."""
    off = np.abs(tempo_excess(recorded, seconds))
    return np.where(off > 1e-9, TEMPO_COST * (1.0 + off), 0.0)


def _mixture_spread(candidates: Candidates, moved: Float64, angles: Float64) -> Float64:
    """Return the largest distance of each candidate's end from its node's own clip's end, for any heading, (K,) [m].

    A mixture's end differs by the difference of the two ends, and by the difference of the turns that the headings
    need: a turn moves an end by a bounded distance per radian.
    """
    node, own = candidates.node, candidates.first[:-1]
    step = angles[1] - angles[0]
    arm = np.hypot(*candidates.end.T)
    swing = np.hypot(*np.moveaxis(np.diff(moved, axis=1), -1, 0)).max(axis=1) / step
    per_radian = 1.05 * (swing[node] + np.maximum(arm, arm[own][node]))
    off = np.hypot(*(candidates.end - candidates.end[own][node]).T)
    turned = np.abs(wrap_angle(candidates.facing - candidates.facing[own][node]))
    return np.asarray(off + per_radian * turned)


def _detours(graph: "MotionGraph") -> Float64:
    """Return the largest deviation of the hips of each node from the line between its start and end, (N,) [m]."""
    library = graph.library
    t = np.linspace(0.0, 1.0, SWAY_SAMPLES)
    sample = library.node_first[:, None] + t * (library.node_last - library.node_first)[:, None]
    row = np.clip(np.round(sample).astype(np.int64), 0, len(library.clip_root) - 1)
    hips = library.clip_root[row][:, :, (0, 2)].astype(np.float64)
    way = hips[:, -1] - hips[:, 0]
    along = np.einsum("nsk,nk->ns", hips - hips[:, :1], way) / np.maximum((way**2).sum(axis=1), 1e-9)[:, None]
    straight = hips[:, :1] + np.clip(along, 0.0, 1.0)[..., None] * way[:, None]
    return np.asarray(np.hypot(*np.moveaxis(hips - straight, -1, 0)).max(axis=1))
