"""Updates of the root corrections: path separation of the next measure, and re-aiming within the present one."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.entrances.entrances import ON
from live.agents.separation.path_separation import PathParting, Paths
from live.clock.ticks import TICK
from live.motion.pose.root_warp import MOST_HELD
from live.motion.pose.root_warp_kernels import (
    DODGE,
    PLAN,
    WISH,
    follow_goals,
    limit_wishes,
    stray_wishes,
    take_goals,
    take_wishes,
)
from live.show.dancers.hip_path_prediction import trace
from live.show.dancers.measure_state import LEAST_LEFT
from live.show.dancers.root_correction import Carried, runs
from live.show.group.group_motion import LEASH

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

TRACE_TICKS: Final = 8
"""Ticks after the decision over which the coming paths are traced."""
EASE: Final = 0.2
"""Share by which corrections return to the decided ones in the first round of separation, so that no dancer keeps a
larger detour than necessary."""
EASED: Final = 0.9
"""Factor of that share from round to round: in the end separation prevails over the decision."""


class Coming:
    """Correction state of the next measure. At the line it is moved into `Carried`, that of the present one."""

    def __init__(self, carried: Carried, parting: PathParting, most: float) -> None:
        """`most` [m]: largest correction; 0 for none."""
        count = len(carried.node)
        self._carried, self._parting, self.most = carried, parting, most
        self.paths = Paths(count)
        self.end: Float64 = np.zeros((count, 2))
        """End of the measure without correction [m], (A, 2)."""
        self.target, self.wish = np.zeros((2, count, 2))
        """Targets within the steps' reach, and predicted agents [m], (A, 2) each."""
        self.room: Float64 = carried.room.copy()
        """As in `Carried`, for the coming measure."""
        self._traced = 0
        self.fresh = False
        """Whether this is the tick of the decision."""
        self._goal, self._plan = np.zeros((2, count, 2))
        self._ease = 0.0
        """Share by which corrections return to the decided ones, `_plan` (A, 2), in the next round of separation."""

    @property
    def traced(self) -> bool:
        """Whether all paths are traced."""
        return self._traced >= len(self.end)

    def decided(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """Accept the chosen measure, which begins at `begin` (A, 2) [m]; other parameters as the attributes."""
        self.target[:], self.wish[:] = target, wish
        self.room[:] = np.maximum(self._carried.motion.floor.half, np.abs(begin))
        self._traced, self.fresh = 0, True

    def put_elsewhere(self, who: Int64) -> None:
        """Update the dancers `who` (n,) whose present measures were replaced: their coming ones begin elsewhere."""
        self._plan[who] = self._carried.dancers.coming.correction[who, :2]
        for some in runs(who[who < self._traced]):
            trace(self.paths, self._carried.dancers, self._carried.dancers.coming, some)

    def tick(self, *, part: bool) -> None:
        """Trace a piece of the paths; once all are traced, run a round of separation if `part` is true."""
        carried, dancers, count = self._carried, self._carried.dancers, len(self.end)
        coming = dancers.coming
        if self.fresh:  # limits the load of the tick of the decision
            self.fresh = False
            return
        if self._traced < count:
            piece = slice(self._traced, min(self._traced + -(-count // TRACE_TICKS), count))
            trace(self.paths, dancers, coming, piece)
            self._traced = piece.stop
            if self._traced == count:
                self._plan[:], self._ease = coming.correction[:, :2], EASE
            if self._traced == count and self.most > 0.0:
                carried.allow(np.minimum(dancers.graph.node_give[coming.node], self.most))
            return
        if not part:
            return
        goal = self._goal
        goal[:] = coming.correction[:, :2]
        goal += self._ease * (self._plan - goal)
        self._ease *= EASED
        self._parting.part(self.paths, goal, coming.aimed, carried.most)
        carried.level(goal, self.end, coming=True)
        carried.keep_on_stage(goal, self.end, self.room)
        coming.correction[:, :2] = goal

    def cross_measure_line(self) -> None:
        """Make the coming measure the present one. The path arrays are swapped."""
        carried = self._carried
        carried.asked[:], carried.foreseen[:], carried.room[:] = self.target, self.wish, self.room
        if self.traced:
            carried.paths, self.paths = self.paths, carried.paths
            carried.node[:] = carried.dancers.coming.node
            carried.end[:] = self.end


FAITHFUL: Final = 0.4
"""Largest correction at obedience 0, as a share of the legs' reach margin."""
DEAF: Final = 0.08
"""Dead zone [m]: a smaller deviation of an agent from the dancer's plan causes no re-aiming."""
GO_BACK: Final = 0.03
"""Decay of detours per tick. Separation restores a detour that is still needed in the same tick, so dancers return to
their targets once they have passed each other."""
AIM_RATE: Final = 14.0
"""Rate at which a correction follows its goal, critically damped [1/s]."""


class ReAiming:
    """Recomputes the corrections within the present measure."""

    def __init__(self, carried: Carried, parting: PathParting, most: float) -> None:
        """`most` [m]: largest correction."""
        self._carried, self._parting, self.most = carried, parting, most
        self._phase = np.zeros(len(carried.node))

    def tick(self, fraction: float, *, aim: bool) -> None:
        """Advance by one tick at `fraction` of the measure; recompute the goals only if `aim` is true."""
        carried, dancers = self._carried, self._carried.dancers
        if dancers.decided:
            return
        present = dancers.present
        dancers.variation.phases(self._phase, fraction, present.warp)
        if aim:
            self._aim_anew(fraction)
        follow_goals(
            carried.rows, present.correction, present.aimed, self._phase, present.node, dancers.graph.node_rise,
            AIM_RATE, TICK, LEAST_LEFT,
        )  # fmt: skip

    def _aim_anew(self, fraction: float) -> None:
        """Recompute the corrections' goals from the decided ones, the agents' deviations and path separation."""
        carried, dancers, rows = self._carried, self._carried.dancers, self._carried.rows
        present, graph, variation = dancers.present, dancers.graph, dancers.variation
        if variation.obeys:
            position, state = carried.motion.state.position, carried.motion.entrances.state
            obedience, late, share = variation.obedience, variation.late, min(fraction, 1.0)
            stray_wishes(rows, position, obedience, late, dancers.shown, share, DEAF, LEASH)
            limit_wishes(
                rows, present.placement, present.correction, present.node, graph.node_gives, graph.node_holds,
                dancers.lock.state, FAITHFUL + (1.0 - FAITHFUL) * variation.obedience, self.most, MOST_HELD,
                state, ON, carried.room,
            )  # fmt: skip
        else:
            rows[WISH] = rows[PLAN]
        led = present.correction, present.aimed, self._phase, present.node, graph.node_rise
        rows[DODGE] *= 1.0 - GO_BACK
        take_wishes(rows, *led, carried.most, LEAST_LEFT)
        self._parting.part(carried.paths, carried.goal, present.aimed, carried.most, place=fraction)
        carried.level(carried.goal, carried.end, coming=False)
        carried.keep_on_stage(carried.goal, carried.end, carried.room)
        take_goals(rows, *led, carried.hasty, LEAST_LEFT)
