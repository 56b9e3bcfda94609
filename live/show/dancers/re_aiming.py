"""ReAiming: within the measure corrections follow what agents stray from the prediction, and keep paths apart."""

from typing import Final

import numpy as np

from live.agents.entrances.entrances import ON
from live.agents.separation.paths import PathParting
from live.clock.ticks import TICK
from live.motion.pose.aiming_kernels import (
    DODGE,
    PLAN,
    WISH,
    follow_goals,
    limit_wishes,
    stray_wishes,
    take_goals,
    take_wishes,
)
from live.motion.pose.rise import MOST_HELD
from live.show.dancers.measure_state import LEAST_LEFT
from live.show.dancers.root_correction import Carried
from live.show.group.group_motion import LEASH

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
