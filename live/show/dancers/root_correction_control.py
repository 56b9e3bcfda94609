"""Carrying: how far dancers are carried beyond their steps, and agents along with their dancers.

When measures are decided, each dancer's correction is what her legs and her obedience allow of the way that she lacks.
In the ticks until the line the paths of all dancers through that measure are kept apart (`coming.py`). Within the
measure her agent shows what steering wants at once, bound to her; how far it strays from what was planned re-aims the
rest of her correction (`re_aiming.py`). Who would touch all the same is pushed away (`pushing.py`).
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
"""Corrections see to it that dancers end a measure so far apart [m]: a bit less than steering's DANCER_GAP, which a
circle of many may fall short of; else everybody in it would be led away from her place in every measure."""
CROWD: Final = 256
"""So many dancers have little to do with most others: their paths are parted half as often."""


class Carrying:
    """Decides every dancer's correction, and changes it within the measure."""

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
        """Where agents are bound: the even way through the measure, (A, 2) [m]."""
        self.pace: Float32 = np.zeros((count, 2), np.float32)
        """How fast that moves, (A, 2) [m/s]."""
        self.lag: Float64 = np.zeros(count)
        """How far each dancer ended the last measure from her predicted agent [m], shape (A,)."""
        self._odd = False
        """Of crowds, paths are parted in every second tick."""
        self._slid, self._stood = np.zeros(count), np.zeros(count)
        self._ended = False  # whether how feet have slid in the measure before has still to be asked
        self._begun = False  # whether this is the tick of a line: nobody has strayed yet, and paths are apart
        self._open = False  # whether the coming measures are not corrected yet

    def take_patch(self, fresh: "Carrying") -> None:
        """Carry as far as another patch allows."""
        most = fresh._patch.locomotion.correction_m
        self._coming.most = self._re_aiming.most = most
        if (self._pushing is None) != (fresh._pushing is None):
            self._pushing = Pushing(self._carried, self._coming, self.parting) if most > 0.0 else None

    @property
    def predicted(self) -> Float64:
        """Where each dancer's agent is predicted to be when the present measure ends, as far as steps reach, (A, 2)."""
        return self._carried.predicted

    @property
    def pushes(self) -> int:
        """Ticks times dancers in which feet had to yield so that nobody touched, since the start."""
        return 0 if self._pushing is None else self._pushing.count

    # -- what a correction may be --------------------------------------------------------------------------------

    def decided(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """The coming measures are written but for how they are corrected to end at `target` (A, 2) [m], which is as far
        as steps reach of the way to `wish` (A, 2) [m], where the agents are predicted to be; they `begin` (A, 2) there.

        That is decided in the next tick, or at the line if it comes first: this one has enough to do.
        """
        self._coming.decided(begin, target, wish)
        self._open = True

    def _settle(self) -> None:
        """Decide how the coming measures are corrected."""
        self._open = False
        coming, target = self._dancers.coming, self._coming.target
        end = coming.end_position()  # turned on the feet that carry, the hips end elsewhere
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
        """A measure begins; `anew` if somebody is not where the coming measure would have had her."""
        traced = self._coming.traced and not anew
        self._carried.begin_measure(self._dancers.present, self.reference, traced=traced)
        self._begun = self._ended = True

    def cross_measure_line(self) -> None:
        """The measure ends: how far from the predicted agent; then the coming paths are the present ones."""
        if self._open:
            self._settle()
        end_rows(self.lag, self._carried.rows, self._dancers.present.correction)
        self._coming.cross_measure_line()

    def tick(self, fraction: float, rate: float) -> None:
        """One tick at `fraction` of the measure, of which `rate` [1/s] passes; before the dancers' own tick."""
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
        """The dancers `rows` (n,), whose own dance nobody sees, go on with it elsewhere by `way` (n, 2) [m]."""
        carried, coming, dancers = self._carried, self._coming, self._dancers
        past, present, then = dancers.measures()
        take_dance_along(
            rows, way, past.placement, present.placement, then.placement, carried.begin, carried.end, coming.end,
            carried.paths.path, coming.paths.path, dancers.shown, dancers.lock.state,
        )  # fmt: skip

    def _free(self) -> npt.NDArray[np.int8]:
        """Where everybody is on the way in and out, as `Entrances.state`; who is taken along by what she answers is in
        nobody's way: she goes where her leader is, and agents see her."""
        state, answering = self._motion.entrances.state, self._dancers.answering
        if answering is None or not answering.along.following.any():
            return state
        return np.where(answering.along.following, WAITING, state).astype(np.int8)

    # -- what it costs -------------------------------------------------------------------------------------------

    def figures(self) -> dict[str, Any]:
        """By group, of the last measure: obedience, how feet slid while they stood on the average [m/s], and how far
        dancers ended from their predicted agents [m]; and how often somebody was pushed since the start."""
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
