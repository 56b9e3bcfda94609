"""First nodes: what everybody dances in the first measure."""

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.show.selection.scheduler import Scheduler

Int32 = npt.NDArray[np.int32]
Bools = npt.NDArray[np.bool_]

TRAVEL_COST = 0.1
"""What a metre of travel in the first measure costs beside a sequence that cannot go on."""


def first_nodes(graph: MotionGraph, scheduler: Scheduler, group: Int32, mirrored: Bools, measure: int) -> Int32:
    """Each dancer's group's first step, on the spot if that lets the sequence go on; shape (A,).

    group (A,): the group of each; mirrored (A,): who dances the other side of what her partner dances.
    """
    library, node = graph.library, np.zeros(len(group), np.int32)
    for index in scheduler.order:
        programme, members = scheduler.programmes[index], group == index
        entries = graph.entries(programme.wanted(measure, node[members]))
        ahead = scheduler.foresight.sequence(programme.coming, programme.into)[entries]
        cost = ahead + TRAVEL_COST * np.hypot(*library.node_travel[entries].T)
        node[members] = entries[np.argmin(cost)]
        side, other = library.node_side[entries], members & mirrored
        node[other] = entries[np.argmin(cost + (side == library.node_side[node[other][:1]].sum()))]
    return node
