"""Control of the root corrections: how far dancers are moved beyond their steps, and reference paths for the agents.

When a measure is decided, each dancer's correction is the part of the missing distance that legs and obedience allow.
In the ticks until the measure line, the paths of all dancers through the measure are separated. Within the measure, the
rest of the correction is recomputed from the difference between predicted and actual agent position. Dancers who would
still touch are pushed apart.
"""

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from live.agents.entrances.entrances import ON, WAITING
from live.agents.separation.path_separation import PathSeparation
from live.base.arrays import Float32, Float64
from live.base.motion_parameters import OBEDIENCE
from live.motion.capture.capture_blend_kernels import translate_plans
from live.motion.pose.root_warp_kernels import compute_corrections, compute_references, end_distances
from live.motion.pose.warp_curve_kernels import MAX_HELD_SHIFT
from live.show.dancers.collision_avoidance import ContactResolver
from live.show.dancers.correction_update import CorrectionUpdate, NextCorrection
from live.show.dancers.root_correction import MIN_CORRECTION_SHARE, RootCorrection
from live.show.patch.patch import Patch

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion


MIN_END_DISTANCE: Final = 0.66
"""Least distance of dancers at the end of a measure [m]. It is a bit less than steering's MIN_DANCER_DISTANCE, which
large circles may fall short of: their dancers would otherwise be moved off their places in every measure."""
LARGE_GROUP: Final = 256
"""With more dancers than this, path separation runs only in every second tick."""


class RootCorrectionControl:
    """Decides the root correction of each dancer, and changes it within the measure."""

    def __init__(self, patch: Patch, dancers: "Dancers", motion: "GroupMotion") -> None:
        count = len(motion.casting.group)
        self._patch, self._dancers, self._motion = patch, dancers, motion
        half = patch.stage.width / 2, patch.stage.depth / 2
        self.path_separation = PathSeparation(
            motion.model.radius,
            motion.model.responsibility,
            gap_at_end=MIN_END_DISTANCE,
            half_width=half[0],
            half_depth=half[1],
            seed=motion.model.seed,
            surroundings=motion.surroundings,
        )
        most = patch.locomotion.correction_m
        self._correction = RootCorrection(dancers, motion)
        self._next_correction = NextCorrection(self._correction, self.path_separation, most)
        self._correction_update = CorrectionUpdate(self._correction, self.path_separation, most)
        self._contact_resolver = (
            ContactResolver(self._correction, self._next_correction, self.path_separation) if most > 0.0 else None
        )
        self.reference: Float32 = np.zeros((count, 2), np.float32)
        """Reference positions of the agents: the even path through the measure, (A, 2) [m]."""
        self.reference_velocity: Float32 = np.zeros((count, 2), np.float32)
        """Velocity of the reference positions, (A, 2) [m/s]."""
        self.lag: Float64 = np.zeros(count)
        """Distance of each dancer from the predicted agent at the end of the last measure [m], shape (A,)."""
        self._skip_separation = False
        """Whether this tick skips path separation (large groups, every second tick)."""
        self._slid, self._stood = np.zeros(count), np.zeros(count)
        self._ended = False  # whether the foot slide of the last measure has still to be read
        self._begun = False  # whether this is the tick of a line: agents have not strayed, and paths are separate
        self._open = False  # whether the coming measures are not corrected yet

    def apply_patch(self, fresh: "RootCorrectionControl") -> None:
        """Apply the correction limit and the stage of another patch."""
        self.path_separation.resize(fresh.path_separation)
        most = fresh._patch.locomotion.correction_m
        self._next_correction.max_correction = self._correction_update.max_correction = most
        if (self._contact_resolver is None) != (fresh._contact_resolver is None):
            self._contact_resolver = (
                ContactResolver(self._correction, self._next_correction, self.path_separation) if most > 0.0 else None
            )

    @property
    def predicted(self) -> Float64:
        """Predicted agent of each dancer at the end of the present measure, within the steps' reach [m], (A, 2)."""
        return self._correction.predicted

    @property
    def push_count(self) -> int:
        """Dancer ticks since the start in which a dancer was pushed to avoid contact, at the cost of foot slide."""
        return 0 if self._contact_resolver is None else self._contact_resolver.count

    # -- decision ------------------------------------------------------------------------------------------------

    def accept_decision(self, begin: Float64, target: Float64, wish: Float64) -> None:
        """Accept the coming measures, which are complete except for their corrections.

        They begin at `begin` (A, 2) [m] and should end at `target` (A, 2) [m], the part of the way to the predicted
        agents `wish` (A, 2) [m] that the steps reach. Corrections are computed in the next tick, to limit the load of
        this one, or at the line if it comes first.
        """
        self._next_correction.accept_decision(begin, target, wish)
        self._open = True

    def _compute_corrections(self) -> None:
        """Compute the corrections of the coming measures."""
        self._open = False
        coming, target = self._dancers.coming, self._next_correction.target
        end = coming.end_position()  # includes the effect of turns on the support foot
        share = MIN_CORRECTION_SHARE + (1.0 - MIN_CORRECTION_SHARE) * self._dancers.variation[OBEDIENCE]
        graph, lock = self._dancers.graph, self._dancers.lock
        compute_corrections(
            coming.correction, target, end, coming.placement, coming.node, graph.node_reach_margins,
            graph.node_lift_shares, lock.state, share, self._patch.locomotion.correction_m, MAX_HELD_SHIFT,
            self._motion.entrances.state, ON, *self._motion.stage_area.half.tolist(),
        )  # fmt: skip
        self._correction.align_partner_ends(coming.correction[:, :2], end, coming=True)
        self._next_correction.end[:] = end

    # -- time ----------------------------------------------------------------------------------------------------

    def begin_measure(self, *, displaced: bool) -> None:
        """Begin a measure; `displaced` if a dancer is not where the coming measure was planned to begin."""
        traced = self._next_correction.traced and not displaced
        self._correction.begin_measure(self._dancers.present, self.reference, traced=traced)
        self._begun = self._ended = True

    def cross_measure_line(self) -> None:
        """End the measure: record the lag, and make the coming paths the present ones."""
        if self._open:
            self._compute_corrections()
        end_distances(self.lag, self._correction.rows, self._dancers.present.correction)
        self._next_correction.cross_measure_line()

    def tick(self, fraction: float, rate: float) -> None:
        """Advance by one tick at `fraction` of the measure, which advances at `rate` [1/s]. Called before the dancers'
        tick."""
        dancers, carried = self._dancers, self._correction
        self.path_separation.set_present(self._separation_states(), ON)
        self._skip_separation = not self._skip_separation and len(carried.node) > LARGE_GROUP
        if not np.array_equal(carried.node, dancers.present.node):
            who = np.flatnonzero(carried.node != dancers.present.node)
            carried.replace_measures(who)
            if dancers.decided:
                self._next_correction.replace_measures(who)
        if dancers.decided and self._open and not self._next_correction.just_decided:
            self._compute_corrections()
        elif dancers.decided:
            self._next_correction.tick(separate=not self._skip_separation)
        self._correction_update.tick(fraction, aim=not (self._skip_separation or self._begun))
        if self._ended and not self._begun:
            self._slid, self._stood = dancers.lock.pop_slide()
            self._ended = False
        self._begun = False
        if self._contact_resolver is not None:
            self._contact_resolver.tick(fraction, rate)
        compute_references(
            self.reference, self.reference_velocity, carried.rows, dancers.present.correction, min(fraction, 1.0), rate,
            dancers.variation.delays, dancers.drawn_hips,
        )  # fmt: skip

    def displace(self, rows: npt.NDArray[np.int64], way: Float64) -> None:
        """Displace the own dance of the dancers `rows` (n,) by `way` (n, 2) [m]. It must be invisible."""
        carried, coming, dancers = self._correction, self._next_correction, self._dancers
        past, present, then = dancers.measures()
        translate_plans(
            rows, way, past.placement, present.placement, then.placement, carried.begin, carried.end, coming.end,
            carried.paths.path, coming.paths.path, dancers.drawn_hips, dancers.lock.state,
        )  # fmt: skip

    def _separation_states(self) -> npt.NDArray[np.int8]:
        """Return the states of `Entrances.state`, with dancers moved by a partner response as WAITING.

        Path separation ignores these: they go where their leaders are, and agents avoid them.
        """
        state, answering = self._motion.entrances.state, self._dancers.partner_response
        if answering is None or not answering.path.following.any():
            return state
        return np.where(answering.path.following, WAITING, state).astype(np.int8)

    # -- statistics ----------------------------------------------------------------------------------------------

    def statistics(self) -> dict[str, Any]:
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
                "obedience": round(float(self._dancers.variation[OBEDIENCE][members].mean()), 3),
                "slide_m_s": round(float(self._slid[members].sum()) / stood, 4) if stood > 0.0 else 0.0,
                "lag_m": round(float(self.lag[members].mean()), 3),
            }
        return {"groups": told, "pushed_ticks": self.push_count}
