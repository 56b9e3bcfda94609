"""Root-correction state of the present measure: paths without corrections, their ends, and the corrections' goals."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.entrances.entrances import ON
from live.agents.separation.path_separation import Paths
from live.base.arrays import Float32, Float64, Int32, Int64
from live.motion.pose import root_warp_kernels
from live.show.dancers.hip_path_prediction import trace_paths
from live.show.dancers.measure_state import MeasureState

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion


MIN_CORRECTION_SHARE: Final = 0.7
"""Largest correction at obedience 0, as a share of the legs' reach margin."""
MIN_SEPARATION_CORRECTION: Final = 0.1
"""Least correction allowed for path separation [m], whatever the legs' reach margin."""
SEPARATION_SPEED_FACTOR: Final = 1.5
"""Factor by which corrections for path separation may be faster than others."""


def consecutive_slices(who: Int64) -> list[slice]:
    """Return the indices `who` (n,), which are in rising order, as slices of consecutive ones."""
    parts = np.split(who, np.flatnonzero(np.diff(who) > 1) + 1)
    return [slice(int(part[0]), int(part[-1]) + 1) for part in parts if len(part)]


class RootCorrection:
    """Correction state of A dancers. The arrays of shape (A, 2) [m] are views of `rows`, which the kernels use."""

    def __init__(self, dancers: "Dancers", motion: "GroupMotion") -> None:
        count = len(motion.casting.group)
        self.dancers, self.motion = dancers, motion
        self.paths = Paths(count)
        """Paths of the hips through the present measure."""
        self.node: Int32 = np.full(count, -1, np.int32)
        """The nodes for which `paths` were traced."""
        self.rows: Float64 = np.zeros((root_warp_kernels.ROWS, count, 2))
        self.begin, self.end = self.rows[root_warp_kernels.BEGIN], self.rows[root_warp_kernels.END]
        """Hips at the beginning of the measure, and at its end without correction."""
        self.goal = self.rows[root_warp_kernels.GOAL]
        """Goals of the corrections."""
        self.predicted: Float64 = self.rows[root_warp_kernels.PREDICTED]
        """Predicted agent of each dancer at the end of the present measure, within the steps' reach."""
        self.target_at_decision, self.agent_at_decision = (
            self.rows[root_warp_kernels.TARGET_AT_DECISION],
            self.rows[root_warp_kernels.AGENT_AT_DECISION],
        )
        """The same at the time of the decision, and without the limit of the steps' reach."""
        self.room: Float64 = np.tile(motion.stage_area.half, (count, 1))
        """Largest distance from the centre at the end of the present measure, in x and z [m], (A, 2). A dancer who
        began it outside a stage that has shrunk may stay there, but go no farther out."""
        self.max_separation, self.speed_limit = np.zeros(count), np.zeros(count)
        """Largest correction for path separation [m], and the one that limits its speed [m], (A,)."""

    def set_reach_margin(self, give: Float64) -> None:
        """Set the legs' reach margins [m], (A,), for path separation."""
        self.max_separation[:] = np.maximum(give, MIN_SEPARATION_CORRECTION)
        self.speed_limit[:] = SEPARATION_SPEED_FACTOR * self.max_separation

    def begin_measure(self, present: MeasureState, reference: Float32, *, traced: bool) -> None:
        """Begin the measure `present`, whose paths are known already if `traced`. Writes the agents' `reference`
        (A, 2) [m]."""
        if not traced or not np.array_equal(self.node, present.node):
            trace_paths(self.paths, self.dancers, present, slice(0, len(self.node)))
            self.end[:] = present.end_position() - present.correction[:, :2]
        if (self.node < 0).all():  # first measure: the target is the steps' own end
            self.target_at_decision[:] = self.agent_at_decision[:] = self.end + present.correction[:, :2]
        self.node[:] = present.node
        root_warp_kernels.begin_measure(
            self.rows, self.paths.path, present.correction, self.motion.state.position, reference
        )

    def replace_measures(self, who: Int64) -> None:
        """Update the dancers `who` (n,) whose measures were replaced in the middle of this one."""
        present = self.dancers.present
        for some in consecutive_slices(who):
            trace_paths(self.paths, self.dancers, present, some)
        self.node[who] = present.node[who]
        self.begin[who] = self.paths.path[who, 0]
        self.end[who] = present.end_position()[who] - present.correction[who, :2]
        for place in (root_warp_kernels.PLAN, root_warp_kernels.AIM, root_warp_kernels.GOAL):
            self.rows[place, who] = present.correction[who, :2]
        self.rows[root_warp_kernels.SEPARATION, who] = self.rows[root_warp_kernels.AIM_SPEED, who] = 0.0

    def keep_on_stage(self, way: Float64, end: Float64, room: Float64) -> None:
        """Limit the displacements `way` (A, 2) [m] from `end` (A, 2) so that dancers on the stage stay in `room`."""
        root_warp_kernels.clamp_ends(way, end, self.motion.entrances.state, ON, room)

    def align_partner_ends(self, way: Float64, end: Float64, *, coming: bool) -> None:
        """Change the displacements `way` (A, 2) [m] of measures that end at `end` (A, 2) so that partners stay
        together."""
        if len(self.motion.partners.leader):
            ends = end + way
            self.motion.partners.align_ends(ends, coming=coming)
            way[:] = ends - end
