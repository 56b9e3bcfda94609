"""Choice of the nodes for the first measure."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from live.base.arrays import Int32
from live.graph.motion_graph import MotionGraph

if TYPE_CHECKING:
    from live.show.selection.scheduler import Scheduler


Bools = npt.NDArray[np.bool_]

TRAVEL_COST = 0.1
"""Cost of a metre of travel in the first measure, relative to a measure of the sequence that goes wrong."""


def initial_nodes(graph: MotionGraph, scheduler: "Scheduler", group: Int32, mirrored: Bools, measure: int) -> Int32:
    """Return a node of the group's first step for each dancer, without travel if the sequence allows it, (A,).

    `group` (A,): group of each dancer; `mirrored` (A,): whether a dancer dances the other side of the partner's step.
    """
    library, node = graph.library, np.zeros(len(group), np.int32)
    for index in scheduler.order:
        programme, members = scheduler.programmes[index], group == index
        entries = graph.entries(programme.step_for(measure, node[members]))
        ahead = scheduler.step_costs.sequence_cost(programme.upcoming, programme.measures_done)[entries]
        cost = ahead + TRAVEL_COST * np.hypot(*library.node_travel[entries].T)
        node[members] = entries[np.argmin(cost)]
        side, other = library.node_side[entries], members & mirrored
        node[other] = entries[np.argmin(cost + (side == library.node_side[node[other][:1]].sum()))]
    return node
