"""Updates of the root corrections: path separation of the next measure, and re-aiming within the present one."""

from typing import Final

import numpy as np

from live.agents.agent_command import LEASH
from live.agents.entrances.entrances import ON
from live.agents.separation.path_separation import Paths, PathSeparation
from live.base.arrays import Float64, Int64
from live.base.motion_parameters import OBEDIENCE
from live.base.row_ranges import run_rows
from live.clock.ticks import TICK
from live.motion.pose.footstep_plan import MAX_HELD_SHIFT
from live.motion.pose.pose_pipeline import RANGE
from live.motion.pose.root_warp_kernels import (
    DESIRED,
    PLAN,
    SEPARATION,
    apply_desired,
    apply_goals,
    desire_corrections,
    follow_goals,
    limit_desired,
)
from live.show.dancers.hip_path_prediction import trace_paths
from live.show.dancers.measure_state import MIN_REMAINING_WARP
from live.show.dancers.root_correction import MIN_CORRECTION_SHARE, RootCorrection, consecutive_slices

TRACE_TICKS: Final = 8
"""Ticks after the decision over which the coming paths are traced."""
EASE_SHARE: Final = 0.2
"""Share by which corrections return to the decided ones in the first round of separation, so that no dancer keeps a
larger detour than necessary."""
EASE_DECAY: Final = 0.97
"""Factor of that share from round to round: in the end separation prevails over the decision."""


class NextCorrection:
    """Correction state of the next measure. At the line it is moved into `RootCorrection`, that of the present one."""

    def __init__(self, correction: RootCorrection, path_separation: PathSeparation, max_correction: float) -> None:
        """`max_correction` [m]: largest correction; 0 for none."""
        count = len(correction.node)
        self._correction, self._path_separation, self.max_correction = correction, path_separation, max_correction
        self.paths = Paths(count)
        self.end: Float64 = np.zeros((count, 2))
        """End of the measure without correction [m], (A, 2)."""
        self.target, self.wish = np.zeros((2, count, 2))
        """Targets within the steps' reach, and predicted agents [m], (A, 2) each."""
        self.room: Float64 = correction.room.copy()
        """As in `RootCorrection`, for the coming measure."""
        self._traced = 0
        self.just_decided = False
        """Whether this is the tick of the decision."""
        self._goal, self._plan = np.zeros((2, count, 2))
        self._ease = 0.0
        """Share by which corrections return to the decided ones, `_plan` (A, 2), in the next round of separation."""

    @property
    def traced(self) -> bool:
        """Whether all paths are traced."""
        return self._traced >= len(self.end)

    def accept_decision(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """Accept the chosen measure, which begins at `begin` (A, 2) [m]; other parameters as the attributes."""
        self.target[:], self.wish[:] = target, wish
        self.room[:] = np.maximum(self._correction.motion.stage_area.half, np.abs(begin))
        self._traced, self.just_decided = 0, True

    def replace_measures(self, who: Int64) -> None:
        """Update the dancers `who` (n,) whose present measures were replaced: their coming ones begin elsewhere."""
        self._plan[who] = self._correction.dancers.coming.correction[who, :2]
        for some in consecutive_slices(who[who < self._traced]):
            trace_paths(self.paths, self._correction.dancers, self._correction.dancers.coming, some)

    def tick(self, *, separate: bool) -> None:
        """Trace a piece of the paths; once all are traced, run a round of separation if `separate` is true."""
        carried, dancers, count = self._correction, self._correction.dancers, len(self.end)
        coming = dancers.coming
        if self.just_decided:  # limits the load of the tick of the decision
            self.just_decided = False
            return
        if self._traced < count:
            piece = slice(self._traced, min(self._traced + -(-count // TRACE_TICKS), count))
            trace_paths(self.paths, dancers, coming, piece)
            self._traced = piece.stop
            if self._traced == count:
                self._plan[:], self._ease = coming.correction[:, :2], EASE_SHARE
            if self._traced == count and self.max_correction > 0.0:
                carried.set_reach_margin(np.minimum(dancers.graph.node_reach_margin[coming.node], self.max_correction))
            return
        if not separate:
            return
        goal = self._goal
        goal[:] = coming.correction[:, :2]
        goal += self._ease * (self._plan - goal)
        self._ease *= EASE_DECAY
        self._path_separation.separate(self.paths, goal, coming.aim_origin, carried.max_separation)
        carried.align_partner_ends(goal, self.end, coming=True)
        carried.keep_on_stage(goal, self.end, self.room)
        coming.correction[:, :2] = goal

    def cross_measure_line(self) -> None:
        """Make the coming measure the present one. The path arrays are swapped."""
        carried = self._correction
        carried.target_at_decision[:], carried.agent_at_decision[:], carried.room[:] = self.target, self.wish, self.room
        if self.traced:
            carried.paths, self.paths = self.paths, carried.paths
            carried.node[:] = carried.dancers.coming.node
            carried.end[:] = self.end


DEAD_ZONE: Final = 0.08
"""Dead zone [m]: a smaller deviation of an agent from the dancer's plan causes no re-aiming."""
DETOUR_DECAY: Final = 0.03
"""Decay of detours per tick. Separation restores a detour that is still needed in the same tick, so dancers return to
their targets once they have passed each other."""
AIM_RATE: Final = 14.0
"""Rate at which a correction follows its goal, critically damped [1/s]."""


class CorrectionUpdate:
    """Recomputes the corrections within the present measure."""

    def __init__(self, correction: RootCorrection, path_separation: PathSeparation, max_correction: float) -> None:
        """`max_correction` [m]: largest correction."""
        self._correction, self._path_separation, self.max_correction = correction, path_separation, max_correction
        self._phase = np.zeros(len(correction.node))

    def tick(self, fraction: float, *, aim: bool) -> None:
        """Advance by one tick at `fraction` of the measure; recompute the goals only if `aim` is true."""
        carried, dancers = self._correction, self._correction.dancers
        if dancers.decided:
            return
        present = dancers.present
        dancers.variation.phases(self._phase, fraction, present.warp)
        if aim:
            self._recompute_goals(fraction)

        def part(begin: int, end: int) -> None:
            follow_goals(
                carried.rows, present.correction, present.aim_origin, present.foot_aim, self._phase, present.node,
                dancers.graph.node_warp_curve, dancers.graph.node_foot_curve, AIM_RATE, TICK, MIN_REMAINING_WARP,
                begin, end,
            )  # fmt: skip

        run_rows(part, len(self._phase), least=4 * RANGE)

    def _recompute_goals(self, fraction: float) -> None:
        """Recompute the corrections' goals from the decided ones, the agents' deviations and path separation."""
        carried, dancers, rows = self._correction, self._correction.dancers, self._correction.rows
        present, graph, variation = dancers.present, dancers.graph, dancers.variation
        if variation.any(OBEDIENCE):
            position, state = carried.motion.state.position, carried.motion.entrances.state
            obedience, late, share = variation[OBEDIENCE], variation.delays, min(fraction, 1.0)
            shown = dancers.drawn_hips

            def part(begin: int, end: int) -> None:
                desire_corrections(
                    rows, position, obedience, late, shown, share, DEAD_ZONE, LEASH, begin, end
                )  # fmt: skip

            run_rows(part, len(position), least=8 * RANGE)
            limit_desired(
                rows, present.placement, present.correction, present.node, graph.node_reach_margins,
                graph.node_lift_shares, dancers.lock.state,
                MIN_CORRECTION_SHARE + (1.0 - MIN_CORRECTION_SHARE) * variation[OBEDIENCE], self.max_correction,
                MAX_HELD_SHIFT, state, ON, carried.room,
            )  # fmt: skip
        else:
            rows[DESIRED] = rows[PLAN]
        led = present.correction, present.aim_origin, self._phase, present.node, graph.node_warp_curve
        rows[SEPARATION] *= 1.0 - DETOUR_DECAY
        apply_desired(rows, *led, carried.max_separation, MIN_REMAINING_WARP)
        self._path_separation.separate(
            carried.paths, carried.goal, present.aim_origin, carried.max_separation, place=fraction
        )
        carried.align_partner_ends(carried.goal, carried.end, coming=False)
        carried.keep_on_stage(carried.goal, carried.end, carried.room)
        apply_goals(rows, *led, carried.speed_limit, MIN_REMAINING_WARP)
