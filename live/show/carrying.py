"""Carrying: how far dancers are carried beyond their steps, and agents along with their dancers.

When measures are decided, each dancer's correction is what her legs and her obedience allow of the way that she lacks.
In the ticks until the line the paths of all dancers through that measure are kept apart. Within the measure her agent
shows what steering wants at once, bound to her; how far it strays from what was planned re-aims the rest of her
correction. Who would touch all the same is pushed away: collisions come before feet.
"""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.parting.paths.paths import PathParting, Paths
from live.agents.wings.entrances import ON
from live.clock.ticks import TICK
from live.motion.shifting.kernels import bound_ways
from live.motion.shifting.rise import MOST_HELD
from live.show.danced import Danced
from live.show.dancers import Dancers
from live.show.group_motion import DANCER_GAP, LEASH, GroupMotion
from live.show.patch import Patch
from live.show.tracing import trace

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

FAITHFUL: Final = 0.4
"""Share of what legs give that a faithful dancer (obedience 0) is carried beyond her step at most."""
DEAF: Final = 0.08
"""An agent who strays from her dancer's plan by less than this [m] re-aims nothing."""
AIM_RATE: Final = 14.0
"""How fast a correction follows what it is re-aimed to [1/s], critically damped."""
LEAST_DODGE: Final = 0.1
"""Whatever legs give, dancers are carried this far [m] beyond their steps where they would touch."""
IN_HASTE: Final = 1.5
"""Who would touch goes this much faster than others who are carried."""
TRACE_TICKS: Final = 8
"""Ticks after the decision in which the coming paths are traced."""
CROWD: Final = 256
"""So many dancers have little to do with most others: their paths are parted half as often."""
PUSH_AHEAD: Final = 0.4
"""Who will touch in this time [s] is pushed apart."""
PUSH_MARGIN: Final = 0.08
PUSH_STIFFNESS: Final = 24.0


class Carrying:
    """Decides every dancer's correction, and changes it within the measure."""

    def __init__(self, patch: Patch, dancers: Dancers, motion: GroupMotion) -> None:
        count = len(motion.casting.group)
        self._patch, self._dancers, self._motion = patch, dancers, motion
        half = patch.stage.width / 2, patch.stage.depth / 2
        self._edge = np.array(half)
        self._carries = patch.locomotion.correction_m > 0.0
        self.parting = PathParting(
            motion.model.radius,
            motion.model.responsibility,
            gap_at_end=DANCER_GAP,
            half_width=half[0],
            half_depth=half[1],
            seed=motion.model.seed,
        )
        self.paths, self._next = Paths(count), Paths(count)
        """Where the hips go in the present measure."""
        self._node: Int32 = np.full(count, -1, np.int32)
        self._begin, self._end = np.zeros((count, 2)), np.zeros((count, 2))
        self._coming_end = np.zeros((count, 2))
        self._plan, self._dodge = np.zeros((count, 2)), np.zeros((count, 2))
        self._goal, self._aim, self._aim_speed = np.zeros((3, count, 2))
        self._most = np.zeros(count)
        self._traced = 0
        """How many dancers' coming paths are traced."""
        self._soon, self._sooner = np.zeros((2, count, 2), np.float32)
        self.predicted: Float64 = np.zeros((count, 2))
        """Where each dancer's agent is predicted to be when the present measure ends, as far as steps reach, (A, 2)."""
        self._asked, self._target = np.zeros((2, count, 2))
        self._foreseen, self._wish, self._ahead = np.zeros((3, count, 2))
        self.reference: Float32 = np.zeros((count, 2), np.float32)
        """Where agents are bound: the even way through the measure, (A, 2) [m]."""
        self.pace: Float32 = np.zeros((count, 2), np.float32)
        """How fast that moves, (A, 2) [m/s]."""
        self.lag: Float64 = np.zeros(count)
        """How far each dancer ended the last measure from her predicted agent [m], shape (A,)."""
        self._odd = False
        """Of crowds, paths are parted in every second tick."""
        self._slid, self._stood = np.zeros(count), np.zeros(count)
        self.pushes = 0
        """Ticks times dancers in which feet had to yield so that nobody touched, since the start."""

    # -- what a correction may be --------------------------------------------------------------------------------

    def _bounded(self, danced: Danced, way: Float64, share: Float64) -> Float64:
        """The `way` (A, 2) [m] as far as legs give, `share` (A,) of that."""
        graph, lock = self._dancers.graph, self._dancers.lock
        way = np.ascontiguousarray(way)
        bound_ways(
            way,
            danced.placement[:, 2] + 0.5 * danced.correction[:, 2],
            danced.node,
            graph.node_gives,
            graph.node_holds,
            lock.held(),
            share,
            self._patch.locomotion.correction_m,
            MOST_HELD,
        )
        return way

    def settle(self, target: Float64, wish: Float64) -> None:
        """Decide how the coming measures, all else of which is written, are corrected to end at `target` (A, 2) [m],
        which is as far as steps reach of the way to `wish` (A, 2) [m], where the agents are predicted to be."""
        coming = self._dancers.coming
        end = coming.end_position()  # turned on the feet that carry, the hips end elsewhere
        share = FAITHFUL + (1.0 - FAITHFUL) * self._dancers.variation.obedience
        on = (self._motion.entrances.state == ON)[:, None]
        inside = np.where(on, np.clip(target, -self._edge, self._edge), target)
        coming.correction[:, :2] = self._bounded(coming, inside - end, share)
        self._level(coming.correction[:, :2], end, coming=True)
        self._coming_end[:], self._target[:], self._wish[:] = end, target, wish
        self._traced = 0

    def _level(self, way: Float64, end: Float64, *, coming: bool) -> None:
        """Change the ways (A, 2) [m] added to measures that end at `end` (A, 2) so that partners stay together."""
        if len(self._motion.partners.leader):
            ends = end + way
            self._motion.partners.level(ends, coming=coming)
            way[:] = ends - end

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self, *, anew: bool) -> None:
        """A measure begins; `anew` if somebody is not where the coming measure would have had her."""
        present, count = self._dancers.present, len(self._node)
        if anew or self._traced < count or (self._node != present.node).any():
            trace(self.paths, self._dancers, present, slice(0, count))
            self._end[:] = present.end_position() - present.correction[:, :2]
        self._node[:] = present.node
        self._begin[:] = self.reference[:] = self.paths.path[:, 0]
        self._plan[:] = self._aim[:] = self._goal[:] = present.correction[:, :2]
        self._dodge[:] = self._aim_speed[:] = 0.0
        self.predicted[:] = self._asked
        self._ahead[:] = self._motion.state.position - self._begin

    def cross_measure_line(self) -> None:
        """The measure ends: how far from the predicted agent; then the coming paths are the present ones."""
        present, coming = self._dancers.present, self._dancers.coming
        self.lag[:] = np.hypot(*(self._end + present.correction[:, :2] - self.predicted).T)
        self._slid, self._stood = self._dancers.lock.slid()
        self._asked[:], self._foreseen[:] = self._target, self._wish
        if self._traced >= len(self._node):
            self.paths, self._next = self._next, self.paths
            self._node[:] = coming.node
            self._end[:] = self._coming_end

    def tick(self, fraction: float, rate: float) -> None:
        """One tick at `fraction` of the measure, of which `rate` [1/s] passes; before the dancers' own tick."""
        dancers = self._dancers
        self.parting.there(self._motion.entrances.state == ON)
        self._odd = not self._odd and len(self._node) > CROWD
        for row in np.flatnonzero(self._node != dancers.present.node).tolist():
            self._put_elsewhere(row)
        if dancers.decided:
            self._prepare_coming()
        self._re_aim(fraction)
        self._push(fraction, rate)
        self._carry_agents(fraction, rate)

    def _put_elsewhere(self, row: int) -> None:
        """A dancer was put into another measure in the middle of this one: plan with that."""
        dancers, one = self._dancers, slice(row, row + 1)
        present = dancers.present
        trace(self.paths, dancers, present, one)
        self._node[row] = present.node[row]
        self._begin[row] = self.paths.path[row, 0]
        self._end[row] = present.end_position()[row] - present.correction[row, :2]
        self._plan[row] = self._aim[row] = self._goal[row] = present.correction[row, :2]
        self._dodge[row] = self._aim_speed[row] = 0.0
        if dancers.decided and self._traced > row:
            trace(self._next, dancers, dancers.coming, one)

    def _prepare_coming(self) -> None:
        """Trace the coming paths piece by piece, then keep them apart, a round in each tick."""
        coming, count = self._dancers.coming, len(self._node)
        if self._traced < count:
            piece = slice(self._traced, min(self._traced + -(-count // TRACE_TICKS), count))
            trace(self._next, self._dancers, coming, piece)
            self._traced = piece.stop
            if self._traced == count:
                give = np.minimum(self._dancers.graph.node_give[coming.node], self._patch.locomotion.correction_m)
                self._most[:] = np.maximum(give, LEAST_DODGE) if self._carries else 0.0
            return
        if self._odd:
            return
        goal = np.ascontiguousarray(coming.correction[:, :2])
        self.parting.part(self._next, goal, coming.aimed, self._most)
        on = self._motion.entrances.state == ON
        self._level(goal, self._coming_end, coming=True)
        ends = self._coming_end + goal
        goal[on] += (np.clip(ends, -self._edge, self._edge) - ends)[on]
        coming.correction[:, :2] = goal

    def _re_aim(self, fraction: float) -> None:
        """Let corrections follow what agents stray from the prediction, and keep the rest of the paths apart."""
        dancers, present = self._dancers, self._dancers.present
        if dancers.decided:
            return
        phase = dancers.phases(fraction)
        if not self._odd:
            self._aim_anew(fraction, phase)
        bend = self._aim_speed + AIM_RATE * (self._aim - self._goal)
        fall = np.exp(-AIM_RATE * TICK)
        self._aim[:] = self._goal + fall * (self._aim - self._goal + bend * TICK)
        self._aim_speed[:] = fall * (self._aim_speed - AIM_RATE * TICK * bend)
        present.re_aim(self._aim, phase)

    def _aim_anew(self, fraction: float, phase: Float64) -> None:
        """What corrections shall lead to now: as decided, or as far as agents strayed, or as others leave room."""
        dancers, present = self._dancers, self._dancers.present
        obedience = dancers.variation.obedience
        wish = self._plan.copy()
        if obedience.any():
            stray = self._strayed(min(fraction, 1.0))
            size = np.hypot(stray[:, 0], stray[:, 1])
            stray *= (obedience * np.maximum(size - DEAF, 0.0) / np.maximum(size, 1e-9))[:, None]
            wish = self._bounded(present, wish + stray, FAITHFUL + (1.0 - FAITHFUL) * obedience)
            ends = self._end + wish
            on = (self._motion.entrances.state == ON)[:, None]
            wish += np.where(on, np.clip(ends, -self._edge, self._edge) - ends, 0.0)
        present.bound_aims(wish, phase, self._most)
        open_ = (wish != present.correction[:, :2]).any(axis=1)
        self.predicted[open_] = (self._asked + wish - self._plan)[open_]  # moved by what they strayed since
        goal = wish + self._dodge
        self.parting.part(self.paths, goal, present.aimed, self._most, place=fraction)
        self._level(goal, self._end, coming=False)
        present.bound_aims(goal, phase, IN_HASTE * self._most)
        self._dodge[:] = goal - wish
        self._goal[:] = goal

    def _strayed(self, fraction: float) -> Float64:
        """How far agents are from where the prediction had them at `fraction` of the measure, (A, 2) [m].

        They were so far ahead of their dancers when it began, and should be so far ahead when it ends; between, both go
        evenly. Who is bound to her dancer has not strayed.
        """
        plan = self._end + self._plan
        ahead = self._motion.state.position - (self._begin + (plan - self._begin) * fraction)
        foreseen = self._ahead * (1.0 - fraction) + (self._foreseen - plan) * fraction
        foreseen *= np.minimum(1.0, LEASH / np.maximum(np.hypot(*foreseen.T), 1e-9))[:, None]
        stray = ahead - foreseen
        stray[self._dancers.variation.late > 0.0] = 0.0
        return np.asarray(stray)

    def _push(self, fraction: float, rate: float) -> None:
        dancers, present = self._dancers, self._dancers.present
        if not self._carries:
            return
        way = np.ascontiguousarray(present.correction[:, :2])
        self.paths.walk(fraction, way, present.aimed, self._sooner)
        beyond = fraction + PUSH_AHEAD * rate - 1.0
        if beyond > 0.0 and dancers.decided and self._traced >= len(self._node):
            coming = dancers.coming
            self._next.walk(beyond, np.ascontiguousarray(coming.correction[:, :2]), coming.aimed, self._soon)
        else:
            self.paths.walk(min(beyond, 0.0) + 1.0, way, present.aimed, self._soon)
        self._soon += dancers.shown - self._sooner
        moved = self.parting.push(dancers.shown, self._soon, margin=PUSH_MARGIN, stiffness=PUSH_STIFFNESS, dt=TICK)
        if not moved.any():
            return
        self._motion.partners.move(moved, dancers.shown)
        moved[np.abs(moved) < 1e-7] = 0.0
        self.pushes += int(np.count_nonzero(moved.any(axis=1)))
        for danced in (dancers.past, present, dancers.coming):
            danced.placement[:, :2] += moved
        for place in (self._begin, self._end, self._coming_end):
            place += moved
        for paths in (self.paths, self._next):
            paths.path += moved[:, None].astype(np.float32)

    def _carry_agents(self, fraction: float, rate: float) -> None:
        """Where agents are bound in the next tick: on the even way from the beginning of the measure to its end."""
        way = self._end + self._dancers.present.correction[:, :2] - self._begin
        self.reference[:] = self._begin + way * min(fraction, 1.0)
        self.pace[:] = way * rate
        late = self._dancers.variation.late > 0.0
        if late.any():
            self.reference[late], self.pace[late] = self._dancers.shown[late], 0.0

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
