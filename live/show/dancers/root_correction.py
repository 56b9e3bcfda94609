"""Carried: where the present measure takes every dancer, corrections apart and in, and what these shall lead to."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command_kernels import same_indices
from live.agents.entrances.entrances import ON
from live.agents.separation.path_separation import Paths
from live.motion.pose import root_warp_kernels
from live.show.dancers.dancers import Dancers
from live.show.dancers.hip_path_prediction import trace
from live.show.dancers.measure_state import Danced
from live.show.group.group_motion import GroupMotion

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

LEAST_DODGE: Final = 0.1
"""Whatever legs give, dancers are carried this far [m] beyond their steps where they would touch."""
IN_HASTE: Final = 1.5
"""Who would touch goes this much faster than others who are carried."""


def runs(who: Int64) -> list[slice]:
    """Indices `who` (n,), in rising order, as runs of neighbours."""
    parts = np.split(who, np.flatnonzero(np.diff(who) > 1) + 1)
    return [slice(int(part[0]), int(part[-1]) + 1) for part in parts if len(part)]


class Carried:
    """Plain arrays over A dancers; those of shape (A, 2) [m] are views of `rows`, which the kernels take."""

    def __init__(self, dancers: Dancers, motion: GroupMotion) -> None:
        count = len(motion.casting.group)
        self.dancers, self.motion = dancers, motion
        self.paths = Paths(count)
        """Where the hips go in the present measure."""
        self.node: Int32 = np.full(count, -1, np.int32)
        """Of which node `paths` are."""
        self.rows: Float64 = np.zeros((root_warp_kernels.ROWS, count, 2))
        self.begin, self.end = self.rows[root_warp_kernels.BEGIN], self.rows[root_warp_kernels.END]
        """Where the hips are when the measure begins, and when it ends if it is not corrected."""
        self.goal = self.rows[root_warp_kernels.GOAL]
        """What corrections shall lead to."""
        self.predicted: Float64 = self.rows[root_warp_kernels.PREDICTED]
        """Where each dancer's agent is predicted to be when the present measure ends, as far as steps reach."""
        self.asked, self.foreseen = self.rows[root_warp_kernels.ASKED], self.rows[root_warp_kernels.FORESEEN]
        """The same as it was decided, and as it would be if steps reached everywhere."""
        self.room: Float64 = np.tile(motion.floor.half, (count, 1))
        """How far to each side of the centre the present measure may end [m], (A, 2): who began it outside, because the
        stage has become smaller, may still be there, but no farther out."""
        self.most, self.hasty = np.zeros(count), np.zeros(count)
        """How long a correction may become so that nobody touches [m], and how far one may hurry to, (A,)."""

    def allow(self, give: Float64) -> None:
        """Legs give so much [m], (A,), for what keeps dancers apart."""
        self.most[:] = np.maximum(give, LEAST_DODGE)
        self.hasty[:] = IN_HASTE * self.most

    def begin_measure(self, present: Danced, reference: Float32, *, traced: bool) -> None:
        """The measure `present` begins; its paths are known already if they are `traced`. Agents are bound to
        `reference` (A, 2) [m], which is written."""
        if not traced or not same_indices(self.node, present.node):
            trace(self.paths, self.dancers, present, slice(0, len(self.node)))
            self.end[:] = present.end_position() - present.correction[:, :2]
        if (self.node < 0).all():  # the first measure: nobody asked for another end than that of her steps
            self.asked[:] = self.foreseen[:] = self.end + present.correction[:, :2]
        self.node[:] = present.node
        root_warp_kernels.begin_rows(
            self.rows, self.paths.path, present.correction, self.motion.state.position, reference
        )

    def put_elsewhere(self, who: Int64) -> None:
        """The dancers `who` (n,) were put into other measures in the middle of this one: go on with those."""
        present = self.dancers.present
        for some in runs(who):
            trace(self.paths, self.dancers, present, some)
        self.node[who] = present.node[who]
        self.begin[who] = self.paths.path[who, 0]
        self.end[who] = present.end_position()[who] - present.correction[who, :2]
        for place in (root_warp_kernels.PLAN, root_warp_kernels.AIM, root_warp_kernels.GOAL):
            self.rows[place, who] = present.correction[who, :2]
        self.rows[root_warp_kernels.DODGE, who] = self.rows[root_warp_kernels.AIM_SPEED, who] = 0.0

    def keep_on_stage(self, way: Float64, end: Float64, room: Float64) -> None:
        """Change the ways (A, 2) [m] from `end` (A, 2) so that nobody on the stage leaves her `room` (A, 2) of it."""
        root_warp_kernels.keep_ends(way, end, self.motion.entrances.state, ON, room)

    def level(self, way: Float64, end: Float64, *, coming: bool) -> None:
        """Change the ways (A, 2) [m] added to measures that end at `end` (A, 2) so that partners stay together."""
        if len(self.motion.partners.leader):
            ends = end + way
            self.motion.partners.level(ends, coming=coming)
            way[:] = ends - end
