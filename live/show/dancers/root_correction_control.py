"""Control of the root corrections: how far dancers are moved beyond their steps, and reference paths for the agents.

When a measure is decided, each dancer's correction is the part of the missing distance that legs and obedience allow.
In the ticks until the measure line, the paths of all dancers through the measure are separated. Within the measure, the
rest of the correction is recomputed from the difference between predicted and actual agent position. Dancers who would
still touch are pushed apart.
"""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.agent_command_kernels import same_indices
from live.agents.entrances.entrances import ON, WAITING
from live.agents.separation.path_separation import PathParting
from live.motion.capture.capture_blend_kernels import take_dance_along
from live.motion.pose.root_warp import MOST_HELD
from live.motion.pose.root_warp_kernels import carry_agents, end_rows, settle_ways
from live.show.dancers.collision_avoidance import Pushing
from live.show.dancers.correction_update import FAITHFUL, Coming, ReAiming
from live.show.dancers.dancers import Dancers
from live.show.dancers.root_correction import Carried
from live.show.group.group_motion import GroupMotion
from live.show.patch.patch import Patch

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

__all__ = ["FAITHFUL", "Carrying"]

END_GAP: Final = 0.66
"""Least distance of dancers at the end of a measure [m]. It is a bit less than steering's DANCER_GAP, which large
circles may fall short of: their dancers would otherwise be moved off their places in every measure."""
CROWD: Final = 256
"""With more dancers than this, path separation runs only in every second tick."""


class Carrying:
    """Decides the root correction of each dancer, and changes it within the measure."""

    def __init__(self, patch: Patch, dancers: Dancers, motion: GroupMotion) -> None:
        count = len(motion.casting.group)
        self._patch, self._dancers, self._motion = patch, dancers, motion
        half = patch.stage.width / 2, patch.stage.depth / 2
        self.parting = PathParting(
            motion.model.radius,
            motion.model.responsibility,
            gap_at_end=END_GAP,
            half_width=half[0],
            half_depth=half[1],
            seed=motion.model.seed,
            surroundings=motion.surroundings,
        )
        most = patch.locomotion.correction_m
        self._carried = Carried(dancers, motion)
        self._coming = Coming(self._carried, self.parting, most)
        self._re_aiming = ReAiming(self._carried, self.parting, most)
        self._pushing = Pushing(self._carried, self._coming, self.parting) if most > 0.0 else None
        self.reference: Float32 = np.zeros((count, 2), np.float32)
        """Reference positions of the agents: the even path through the measure, (A, 2) [m]."""
        self.pace: Float32 = np.zeros((count, 2), np.float32)
        """Velocity of the reference positions, (A, 2) [m/s]."""
        self.lag: Float64 = np.zeros(count)
        """Distance of each dancer from the predicted agent at the end of the last measure [m], shape (A,)."""
        self._odd = False
        """Whether this tick skips path separation (large groups, every second tick)."""
        self._slid, self._stood = np.zeros(count), np.zeros(count)
        self._ended = False  # whether the foot slide of the last measure has still to be read
        self._begun = False  # whether this is the tick of a line: agents have not strayed, and paths are separate
        self._open = False  # whether the coming measures are not corrected yet

    def take_patch(self, fresh: "Carrying") -> None:
        """Apply the correction limit of another patch."""
        most = fresh._patch.locomotion.correction_m
        self._coming.most = self._re_aiming.most = most
        if (self._pushing is None) != (fresh._pushing is None):
            self._pushing = Pushing(self._carried, self._coming, self.parting) if most > 0.0 else None

    @property
    def predicted(self) -> Float64:
        """Predicted agent of each dancer at the end of the present measure, within the steps' reach [m], (A, 2)."""
        return self._carried.predicted

    @property
    def pushes(self) -> int:
        """Dancer ticks since the start in which a dancer was pushed to avoid contact, at the cost of foot slide."""
        return 0 if self._pushing is None else self._pushing.count

    # -- decision ------------------------------------------------------------------------------------------------

    def decided(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """Accept the coming measures, which are complete except for their corrections.

        They begin at `begin` (A, 2) [m] and should end at `target` (A, 2) [m], the part of the way to the predicted
        agents `wish` (A, 2) [m] that the steps reach. Corrections are computed in the next tick, to limit the load of
        this one, or at the line if it comes first.
        """
        self._coming.decided(begin, target, wish)
        self._open = True

    def _settle(self) -> None:
        """Compute the corrections of the coming measures."""
        self._open = False
        coming, target = self._dancers.coming, self._coming.target
        end = coming.end_position()  # includes the effect of turns on the support foot
        share = FAITHFUL + (1.0 - FAITHFUL) * self._dancers.variation.obedience
        graph, lock = self._dancers.graph, self._dancers.lock
        settle_ways(
            coming.correction, target, end, coming.placement, coming.node, graph.node_gives, graph.node_holds,
            lock.state, share, self._patch.locomotion.correction_m, MOST_HELD,
            self._motion.entrances.state, ON, *self._motion.floor.half.tolist(),
        )  # fmt: skip
        self._carried.level(coming.correction[:, :2], end, coming=True)
        self._coming.end[:] = end

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self, *, anew: bool) -> None:
        """Begin a measure; `anew` if a dancer is not where the coming measure was planned to begin."""
        traced = self._coming.traced and not anew
        self._carried.begin_measure(self._dancers.present, self.reference, traced=traced)
        self._begun = self._ended = True

    def cross_measure_line(self) -> None:
        """End the measure: record the lag, and make the coming paths the present ones."""
        if self._open:
            self._settle()
        end_rows(self.lag, self._carried.rows, self._dancers.present.correction)
        self._coming.cross_measure_line()

    def tick(self, fraction: float, rate: float) -> None:
        """Advance by one tick at `fraction` of the measure, which advances at `rate` [1/s]. Called before the dancers'
        tick."""
        dancers, carried = self._dancers, self._carried
        self.parting.there(self._free(), ON)
        self._odd = not self._odd and len(carried.node) > CROWD
        if not same_indices(carried.node, dancers.present.node):
            who = np.flatnonzero(carried.node != dancers.present.node)
            carried.put_elsewhere(who)
            if dancers.decided:
                self._coming.put_elsewhere(who)
        if dancers.decided and self._open and not self._coming.fresh:
            self._settle()
        elif dancers.decided:
            self._coming.tick(part=not self._odd)
        self._re_aiming.tick(fraction, aim=not (self._odd or self._begun))
        if self._ended and not self._begun:
            self._slid, self._stood = dancers.lock.slid()
            self._ended = False
        self._begun = False
        if self._pushing is not None:
            self._pushing.tick(fraction, rate)
        carry_agents(
            self.reference, self.pace, carried.rows, dancers.present.correction, min(fraction, 1.0), rate,
            dancers.variation.late, dancers.shown,
        )  # fmt: skip

    def take_along(self, rows: npt.NDArray[np.int64], way: Float64) -> None:
        """Displace the own dance of the dancers `rows` (n,) by `way` (n, 2) [m]. It must be invisible."""
        carried, coming, dancers = self._carried, self._coming, self._dancers
        past, present, then = dancers.measures()
        take_dance_along(
            rows, way, past.placement, present.placement, then.placement, carried.begin, carried.end, coming.end,
            carried.paths.path, coming.paths.path, dancers.shown, dancers.lock.state,
        )  # fmt: skip

    def _free(self) -> npt.NDArray[np.int8]:
        """Return the states of `Entrances.state`, with dancers moved by a partner response as WAITING.

        Path separation ignores these: they go where their leaders are, and agents avoid them.
        """
        state, answering = self._motion.entrances.state, self._dancers.answering
        if answering is None or not answering.along.following.any():
            return state
        return np.where(answering.along.following, WAITING, state).astype(np.int8)

    # -- statistics ----------------------------------------------------------------------------------------------

    def figures(self) -> dict[str, Any]:
        """Return statistics of the last measure by group: obedience, mean slide of standing feet [m/s] and mean lag
        [m]; and the dancer ticks with a push since the start."""
        names, group = [section.name for section in self._patch.group], self._motion.casting.group
        told: dict[str, Any] = {}
        for index, name in enumerate(names):
            members = (group == index) & self._motion.present
            if not members.any():
                continue
            stood = float(self._stood[members].sum())
            told[name] = {
                "obedience": round(float(self._dancers.variation.obedience[members].mean()), 3),
                "slide_m_s": round(float(self._slid[members].sum()) / stood, 4) if stood > 0.0 else 0.0,
                "lag_m": round(float(self.lag[members].mean()), 3),
            }
        return {"groups": told, "pushed_ticks": self.pushes}
