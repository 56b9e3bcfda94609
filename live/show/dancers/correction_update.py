"""Coming: the paths of all dancers through the measure that is decided, traced and kept apart until the line.

ReAiming: within the measure corrections follow what agents stray from the prediction, and keep paths apart.
"""

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
"""Ticks after the decision in which the coming paths are traced."""
EASE: Final = 0.2
"""In the first round of parting corrections go so far back to what was decided, so that nobody keeps more of a way out
than she needs, ..."""
EASED: Final = 0.9
"""... and in each round this share of it as in the one before: in the end paths are parted, whatever was decided."""


class Coming:
    """What is known of the measure after the present one; at the line it becomes the present one's `Carried`."""

    def __init__(self, carried: Carried, parting: PathParting, most: float) -> None:
        """`most` [m]: how far anybody may be carried; 0 and nobody is."""
        count = len(carried.node)
        self._carried, self._parting, self.most = carried, parting, most
        self.paths = Paths(count)
        self.end: Float64 = np.zeros((count, 2))
        """Where it ends if it is not corrected [m], (A, 2)."""
        self.target, self.wish = np.zeros((2, count, 2))
        """Where dancers are sent, and where their agents are predicted to be [m], (A, 2) each."""
        self.room: Float64 = carried.room.copy()
        """As in `Carried`, of the coming measure."""
        self._traced = 0
        self.fresh = False
        """Whether this is the tick of the decision."""
        self._goal, self._plan = np.zeros((2, count, 2))
        self._ease = 0.0
        """How far corrections go back, in the next round of parting, to what was decided of them, `_plan` (A, 2)."""

    @property
    def traced(self) -> bool:
        """Whether all paths are known."""
        return self._traced >= len(self.end)

    def decided(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """The measure is chosen, and begins at `begin` (A, 2) [m]; see the attributes."""
        self.target[:], self.wish[:] = target, wish
        self.room[:] = np.maximum(self._carried.motion.floor.half, np.abs(begin))
        self._traced, self.fresh = 0, True

    def put_elsewhere(self, who: Int64) -> None:
        """The dancers `who` (n,) were put into other present measures: their coming ones begin elsewhere."""
        self._plan[who] = self._carried.dancers.coming.correction[who, :2]
        for some in runs(who[who < self._traced]):
            trace(self.paths, self._carried.dancers, self._carried.dancers.coming, some)

    def tick(self, *, part: bool) -> None:
        """Trace the paths piece by piece; then, where it is time to `part`, keep them apart, a round in each tick."""
        carried, dancers, count = self._carried, self._carried.dancers, len(self.end)
        coming = dancers.coming
        if self.fresh:  # the tick of the decision has enough to do
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
        """What was coming is the present one now; paths change places."""
        carried = self._carried
        carried.asked[:], carried.foreseen[:], carried.room[:] = self.target, self.wish, self.room
        if self.traced:
            carried.paths, self.paths = self.paths, carried.paths
            carried.node[:] = carried.dancers.coming.node
            carried.end[:] = self.end


FAITHFUL: Final = 0.4
"""Share of what legs give that a faithful dancer (obedience 0) is carried beyond her step at most."""
DEAF: Final = 0.08
"""An agent who strays from her dancer's plan by less than this [m] re-aims nothing."""
GO_BACK: Final = 0.03
"""In each tick dancers give up this share of the way by which they dodge others; who is not past them yet is led there
anew in the same tick. So, when they are, they come back to where they were sent."""
AIM_RATE: Final = 14.0
"""How fast a correction follows what it is re-aimed to [1/s], critically damped."""


class ReAiming:
    """Changes what is carried of a measure that is danced already."""

    def __init__(self, carried: Carried, parting: PathParting, most: float) -> None:
        """`most` [m]: how far anybody may be carried."""
        self._carried, self._parting, self.most = carried, parting, most
        self._phase = np.zeros(len(carried.node))

    def tick(self, fraction: float, *, aim: bool) -> None:
        """One tick at `fraction` of the measure; goals are looked for anew only where it is time to `aim`."""
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
        """What corrections shall lead to now: as decided, or as far as agents strayed, or as others leave room."""
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
