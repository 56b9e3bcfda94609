"""Choice of the nodes for the first measure."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.base.arrays import Int32
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import SIDE_COST, tempo_cost
from live.show.score.step_program import StepProgram

if TYPE_CHECKING:
    from live.show.selection.scheduler import Scheduler


Bools = npt.NDArray[np.bool_]

TRAVEL_COST = 0.1
"""Cost of a metre of travel in the first measure, relative to a measure of the sequence that goes wrong."""


def initial_nodes(
    graph: MotionGraph, scheduler: "Scheduler", sides: Int32, mirrored: Bools, measure: int, seconds: float
) -> Int32:
    """Return a node of the group's or subgroup's first step for each dancer, without travel if the sequence allows it,
    (A,).

    `sides` (A,): the side that each wants, as `Variation.sides`. `mirrored` (A,): whether a dancer dances the other
    side of the partner's step. `seconds`: duration of a measure.
    """
    library, targets, node = graph.library, scheduler.targets, np.zeros(len(mirrored), np.int32)
    tempo = tempo_cost(scheduler.choosing.recorded_seconds, seconds)
    for row in targets.assign(measure):
        programme, members = targets.program(row), targets.rows() == row
        if isinstance(programme, StepProgram):
            programme.measure_s = seconds
        entries = graph.entries(programme.step_for(measure, node[members]))
        ahead = scheduler.step_costs.sequence_cost(programme.upcoming, programme.measures_done)[entries]
        travel = np.hypot(*library.node_travel[entries].T).round(3)  # rounding errors decide nothing between equals
        cost, side = ahead + TRAVEL_COST * travel + tempo[entries], library.node_side[entries]
        for wanted in np.unique(sides[members]):
            node[members & (sides == wanted)] = entries[np.argmin(cost + SIDE_COST * (side * wanted < 0))]
        other = members & mirrored
        node[other] = entries[np.argmin(cost + (side == library.node_side[node[other][:1]].sum()))]
    return node
