"""The past, present and next measure of the dancers, and the clip samples that they need at any moment."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float32, Float64, Int32
from live.base.motion_parameters import FOOT_LOCK
from live.base.row_ranges import run_rows
from live.graph.motion_graph import MotionGraph
from live.motion.pose.gather_kernels import clip_hips, gather_dancers, plan_feet, standing_feet
from live.motion.pose.pipeline_kernels import INTO_NEXT
from live.motion.pose.pose_pipeline import RANGE, PosePipeline
from live.show.dancers.measure_state import MeasureState
from live.show.dancers.variation import Variation

LANDING_SAMPLES: Final = 10.0
"""A foot that stands within so many samples lands: raised on its way, it is down by then."""

Rows = npt.NDArray[np.int64]


class CurrentMeasures:
    """The past, the present and the next measure of A dancers."""

    def __init__(self, graph: MotionGraph, variation: Variation, dancer_count: int) -> None:
        self.graph = graph
        self.variation = variation
        self.past, self.present, self.coming = (MeasureState(graph, dancer_count) for _ in range(3))
        self._pipeline = PosePipeline(dancer_count)
        self._everybody = np.arange(dancer_count)
        self._phase = np.zeros(dancer_count)
        self._foot_offset: Float32 = np.zeros((dancer_count, 2, 3), np.float32)
        """How far the footstep plans have the feet from their places in the clips as placed (x, z), and their lift [m],
        shape (A, 2, 3)."""

    def set_graph(self, graph: MotionGraph) -> None:
        """Switch to a graph in which all nodes of the old one keep their indices."""
        self.graph = graph
        for danced in (self.past, self.present, self.coming):
            danced.set_graph(graph)

    @property
    def node(self) -> Int32:
        """Present node of each dancer, shape (A,)."""
        return self.present.node

    @property
    def decided(self) -> bool:
        """Whether the next measure of every dancer is chosen."""
        return self.coming.decided

    def cross_measure_line(self) -> None:
        """Rotate the measures: the next becomes the present one, the present the past one. Nothing is copied."""
        self.past, self.present, self.coming = self.present, self.coming, self.past
        self.coming.undecide()

    def measures(self) -> tuple[MeasureState, MeasureState, MeasureState]:
        """The past, the present and the next measure, indexed by the first result of `measure_and_phase`."""
        return self.past, self.present, self.coming

    def measure_and_phase(self, fraction: float) -> tuple[Int32, Float64]:
        """Index in `measures` of each dancer's measure, (A,), and the phase in it, (A,)."""
        phase = self.phases(fraction)
        which = 1 - ((phase < 0.0) & (self.past.node >= 0)) + ((phase > 1.0) & self.decided)
        return which.astype(np.int32), np.clip(phase - (which - 1.0), 0.0, 1.0)

    @property
    def requested_samples(self) -> tuple[Float64, Float64, Float32]:
        """The samples (4, A) and placements (4, A, 4) of the clips that were requested last, and the share of the next
        clip (A,), as in `PosePipeline`."""
        pipeline = self._pipeline
        return pipeline.sample, pipeline.placement, pipeline.share[INTO_NEXT]

    @property
    def requested_phase(self) -> Float64:
        """Phase of each dancer in the present measure when samples of all were requested last, (A,)."""
        return self._phase

    def predicted_hips(self, fraction: float, rows: Rows | None = None) -> Float64:
        """Hips at `fraction` of the measure as the clips have them [m], time warps and transitions included: of all
        dancers, (A, 2), or of `rows` (n,), (n, 2)."""
        self._request_samples(fraction, rows, whole=False)
        rows = self._everybody if rows is None else rows
        pipeline, out = self._pipeline, np.empty((len(rows), 2))
        clip_hips(out, rows, pipeline.sample, pipeline.placement, pipeline.share, self.graph.library.clip_root)
        return out

    def contact(self, fraction: float) -> Bool:
        """Whether the left and right foot are annotated as on the floor in the present clips, shape (A, 2).

        During a blend, a foot counts only if both clips have it on the floor.
        """
        self._request_samples(fraction)
        return self._standing(0.0)

    def landing_feet(self) -> Bool:
        """Whether feet are on the floor LANDING_SAMPLES after the samples that were requested last, shape (A, 2)."""
        return self._standing(LANDING_SAMPLES)

    def _standing(self, later: float) -> Bool:
        out = np.empty((len(self._everybody), 2), np.bool_)
        pipeline, contact = self._pipeline, self.graph.library.clip_contact

        def part(begin: int, end: int) -> None:
            standing_feet(out, pipeline.sample, later, pipeline.share, contact, self._foot_offset, begin, end)

        run_rows(part, len(out), least=8 * RANGE)
        return out

    # -- sample requests to the pose pipeline ------------------------------------------------------------------

    def _request_samples(self, fraction: float, rows: Rows | None = None, *, whole: bool = True) -> None:
        """Fill the pose pipeline's requests (samples, placements, weights) at `fraction` of the measure, for all
        dancers or for `rows` (n,). Not `whole`: only those that hips need, neither takes nor the feet's plans."""
        present, phase = self.present, self._phase if rows is None else np.empty(len(rows))
        lowest, highest = self.variation.phases(phase, fraction, present.warp, rows)
        rows = self._everybody if rows is None else rows
        self._fill(rows, present, self.coming, phase, fraction, whole)
        if lowest >= 0.0 and highest <= 1.0:
            return
        late = (phase < 0.0) & (self.past.node[rows] >= 0)
        early = (phase > 1.0) & self.decided
        if late.any():
            self._fill(rows[late], self.past, present, phase[late] + 1.0, 1.0, whole)
        if early.any():
            self._fill(rows[early], self.coming, None, phase[early] - 1.0, 0.0, whole)

    def phases(self, fraction: float) -> Float64:
        """Phase of each dancer in the present measure: below 0 in the one before, above 1 in the next one, (A,)."""
        phase = np.empty(len(self._everybody))
        self.variation.phases(phase, fraction, self.present.warp)
        return phase

    def _fill(
        self, rows: Rows, own: MeasureState, then: MeasureState | None, phase: Float64, fraction: float, whole: bool
    ) -> None:
        """Fill the requests of dancers who are at `phase` (n,) of the measure `own`, with `then` after it."""
        graph, pipeline, after = self.graph, self._pipeline, own if then is None else then
        library, locks = graph.library, self.variation[FOOT_LOCK]

        def part(begin: int, end: int) -> None:
            who, at = rows[begin:end], phase[begin:end]
            gather_dancers(
                who, at, fraction, graph.window, then is not None, whole,
                own.node, own.placement, own.correction, own.aim_origin, own.on_support, own.take,
                own.take_share, own.amplitude,
                after.node, after.placement, after.take, after.take_share, after.amplitude,
                library.node_first, library.node_last, library.node_lead, graph.node_start, graph.node_facing_start,
                graph.node_turns, graph.node_warp_curve,
                pipeline.sample, pipeline.placement, pipeline.share, pipeline.mean, pipeline.amplitude,
            )  # fmt: skip
            if whole:
                plan_feet(
                    who, at, pipeline.share, own.node, own.correction, own.aim_origin, graph.node_warp_curve,
                    graph.node_foot_curve, own.foot_aim, locks, self._foot_offset,
                )  # fmt: skip

        run_rows(part, len(rows), least=2 * RANGE)
