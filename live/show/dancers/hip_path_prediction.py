"""Prediction of hip paths through a measure that is decided."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.separation.path_separation import MOMENTS, Paths
from live.base.arrays import Float64
from live.graph.select.candidates import take_offset
from live.motion.editing.time_warp import measure_warp
from live.motion.pose.turn_kernels import trace_hips

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.measure_state import MeasureState


FRACTIONS: Final = np.linspace(0.0, 1.0, MOMENTS)[:, None]


def trace_paths(paths: Paths, dancers: "Dancers", measure: "MeasureState", rows: slice) -> None:
    """Fill the `paths` of dancers `rows` through `measure`.

    Delayed dancers begin in the measure before. Time warps within measures and mixed takes are included. Drift over the
    sequence (T056) and blends are not: the margin of path separation covers them.
    """
    amplitude, frequency, start, sign = measure.warp[:, rows]
    phase = measure_warp(FRACTIONS, amplitude, frequency, start, sign, dancers.graph.window).T
    late = dancers.variation.delays[rows]
    phase = np.ascontiguousarray(phase - late[:, None])
    _trace_measure(paths, measure, rows, phase, settled=False)
    if late.any():
        before = dancers.present if measure is dancers.coming else dancers.past
        earlier = np.where((phase < 0.0) & (before.node[rows] >= 0)[:, None], phase + 1.0, -1.0)
        _trace_measure(paths, before, rows, earlier, settled=True)


def _trace_measure(paths: Paths, measure: "MeasureState", rows: slice, phase: Float64, *, settled: bool) -> None:
    """Fill the moments at which dancers are in `measure`, at `phase` (n, MOMENTS), below 0 where not."""
    graph = measure.graph
    library = graph.library
    shift, turn = take_offset(graph, measure.node[rows], measure.take[rows])
    trace_hips(
        paths.path[rows], paths.share[rows], phase, measure.placement[rows], measure.correction[rows],
        measure.aim_origin[rows], measure.node[rows], graph.node_turns, graph.node_warp_curve, measure.on_support[rows],
        library.clip_root, library.node_first, library.node_last, measure.take[rows],
        np.ascontiguousarray(np.column_stack((shift, turn))), np.ascontiguousarray(measure.take_share[0, rows]),
        settled,
    )  # fmt: skip
