"""Short-term collision avoidance: dancers leave their step to avoid a collision, or are pushed apart.

All dancers are checked a few times a second. Those with a predicted collision cut to another step one after the other,
so that each choice considers the earlier ones. As a last resort, dancers about to touch are displaced, even if their
feet slide.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.entrances.entrances import ON
from live.agents.separation.collision_prediction_kernels import escape_margins, predict_collisions
from live.agents.separation.path_separation import PathSeparation
from live.agents.separation.path_separation_kernels import extrapolate_paths
from live.base.arrays import Float64, Int32, Int64
from live.base.row_ranges import run_rows
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.graph.node_features import MOMENTS_PER_BEAT
from live.graph.select.candidates import turn_vectors
from live.motion.pose.inertialization_kernels import MAX_FADE_TIME
from live.motion.pose.pose_pipeline import RANGE
from live.show.selection.clip_cut import ClipCutter, Moment
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.dancers.correction_update import NextCorrection
    from live.show.dancers.dancers import Dancers
    from live.show.dancers.root_correction import RootCorrection
    from live.show.group.group_motion import GroupMotion

Cut = Callable[[Moment, Int32, MeasureSpan, Timeline], None]
"""Switches the dancers of a moment to other nodes, (n,), from now on."""

PREDICTION_SECONDS: Final = (0.4, 0.8)
"""Prediction times [s]. Collisions between dancers are checked at the first, those with obstacles and performers, which
no plan includes, at all of them."""
PREDICTION_TICKS: Final = 2
"""Ticks from one prediction to the next: all dancers are checked at every fourth tick."""
MAX_CUTS_PER_TICK: Final = 4
"""Most dancers who may leave their step in one tick. Others are found again at the next check."""
OBSTACLE_TOLERANCE: Final = 0.03
"""Overlap with obstacles and performers [m] that is tolerated before a dancer leaves the step."""
DANCER_TOLERANCE: Final = 0.2
"""Overlap of two dancers [m] that root correction and pushing resolve without a change of step."""
ESCAPE_QUARTERS: Final = 8
"""Quarters of a beat over which an escape path is judged."""
NEAR: Final = 3.0
"""Dancers farther away than this [m] are ignored."""
MARGIN: Final = 0.15
"""Clearance that an escape path should keep [m]. The worst and the mean shortfall are added."""
SHORTFALL_WEIGHT: Final = 6.0
"""Weight of a metre of shortfall, relative to a metre between bodies."""
TARGET_WEIGHT: Final = 1.0
"""Weight of a metre between an escape path's end and the dancer's target, relative to a metre between bodies."""
MIN_GAIN: Final = 0.06
"""Least reduction of the shortfall [m] for which a dancer leaves the step."""


class CollisionAvoidance:
    """Predicts collisions and makes dancers leave their steps. `tick` is called once a tick."""

    def __init__(
        self, dancers: "Dancers", motion: "GroupMotion", targets: Callable[[], Float64], cutting: ClipCutter, cut: Cut
    ) -> None:
        """`targets` returns the targets of all dancers for the measure's end, (A, 2) [m]; `cutting` finds candidates,
        and `cut` applies them."""
        count = len(motion.casting.group)
        self._half_stage = motion.stage_area.half  # the same array for the whole show
        self._dancers, self._motion, self._targets = dancers, motion, targets
        self._cutting, self._cut = cutting, cut
        self._ways: Float64 = np.zeros((len(PREDICTION_SECONDS) + 1, count, 2))
        self._things: Float64 = np.zeros((len(PREDICTION_SECONDS) + 1, len(motion.surroundings.obstacles), 2))
        self._tick = -1
        self._met: Float64 = np.zeros(count)
        self._waiting: list[int] = []  # dancers with a predicted collision, the earliest first
        self.count = 0
        """Number of times a dancer has left the step because of a collision."""

    def tick(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Predict at every second tick, each time farther ahead; after the last prediction, select who must leave."""
        self._tick = (self._tick + 1) % (PREDICTION_TICKS * len(PREDICTION_SECONDS))
        k, rest = divmod(self._tick, PREDICTION_TICKS)
        if not rest:
            self._predict(k, span, timeline, time)
            if k == len(PREDICTION_SECONDS) - 1:
                self._select_threatened()
        now, self._waiting = self._waiting[:MAX_CUTS_PER_TICK], self._waiting[MAX_CUTS_PER_TICK:]
        for row in now:
            self._avoid(row, span, timeline, time)

    def _predict(self, k: int, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Predict the hips of all dancers at the moment `k` of AHEAD."""
        if k == 0:
            self._ways[0] = self._dancers.drawn_hips
        if k == 0 or self._motion.surroundings.obstacle_count:  # only obstacles need later moments
            ahead = PREDICTION_SECONDS[k] - PREDICTION_TICKS * TICK * k  # counted from the first prediction
            self._ways[k + 1] = self._dancers.predicted_hips(span.fraction(timeline.beat_at(time + ahead)))

    def _select_threatened(self) -> None:
        """Queue the dancers who must leave their step."""
        around, model = self._motion.surroundings, self._motion.model
        things, count = around.obstacles, around.obstacle_count
        for n, seconds in enumerate((0.0, *PREDICTION_SECONDS) if count else ()):
            self._things[n, :count] = things[:count, :2] + seconds * things[:count, 3:5]
        free = (self._motion.entrances.state == ON) & (self._motion.partners.partner < 0)
        predict_collisions(
            self._ways, model.radius, model.responsibility * free, self._motion.present,
            float(self._half_stage[0]), float(self._half_stage[1]), self._things,
            things[:, 2] + np.float32(DANCER_TOLERANCE - OBSTACLE_TOLERANCE), count, DANCER_TOLERANCE, self._met,
        )  # fmt: skip
        self._waiting = []
        if self._met.max(initial=0.0) > 0.0:
            # dancers after a cut are escaping already; partners stay together and are moved by correction or pushing
            rows = np.flatnonzero((self._met > 0.0) & free & ~self._dancers.inertia.fading)
            self._waiting = rows[np.argsort(self._met[rows], kind="stable")].tolist()

    def _avoid(self, row: int, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Cut dancer `row` to the step with the best escape path, if it improves the clearance enough."""
        if self._dancers.inertia.age[row] < MAX_FADE_TIME or self._motion.entrances.state[row] != ON:
            return  # changed while queued
        apart = np.hypot(*(self._ways[0] - self._ways[0, row]).T)
        near = self._motion.present & (apart < NEAR)
        near[row] = False
        who = np.flatnonzero(near)
        out = self._predicted_paths(np.concatenate([[row], who]), span, timeline, time)
        others = self._others(row, who, out[:, 1:], timeline.tempo)
        stays = _shortfall(out[:, :1], others)[0]
        if stays <= MIN_GAIN:
            return  # no escape can reduce this by GAIN
        moment = Moment(self._dancers, np.array([row], np.int32), span, timeline, time)
        nodes = self._cutting.candidates()
        trouble = self._escape_shortfall(moment, nodes, others)
        cost = self._cutting.distances(moment, nodes)[0] + SHORTFALL_WEIGHT * trouble
        ends = self._ends(moment, nodes)
        cost += SHORTFALL_WEIGHT * np.hypot(*np.maximum(np.abs(ends) - self._half_stage, 0.0).T)
        cost += TARGET_WEIGHT * np.hypot(*(ends - self._targets()[row]).T)
        best = int(np.argmin(cost))
        if trouble[best] < stays - MIN_GAIN:
            self._cut(moment, nodes[best : best + 1], span, timeline)
            self.count += 1

    def _predicted_paths(self, rows: Int64, span: MeasureSpan, timeline: Timeline, time: float) -> Float64:
        """Predict the dancers `rows` (n,) in the next quarter beats without changes, (ESCAPE_QUARTERS, n, 2) [m]."""
        beat = timeline.beat_at(time)
        quarters = np.arange(1, ESCAPE_QUARTERS + 1) / MOMENTS_PER_BEAT
        return np.stack(
            [self._dancers.predicted_hips(span.fraction(beat + quarter), rows) for quarter in quarters.tolist()]
        )

    def _others(self, row: int, who: Int64, out: Float64, tempo: float) -> Float64:
        """Return positions and contact distances of all others near `row`: x, z, distance [m], (M, ESCAPE_QUARTERS, 3).

        The others are the dancers `who` (n,), predicted at `out` (ESCAPE_QUARTERS, n, 2) [m], and the obstacles.
        """
        model, around = self._motion.model, self._motion.surroundings
        things = around.obstacles[: around.obstacle_count].astype(np.float64)
        seconds = np.arange(1, ESCAPE_QUARTERS + 1)[:, None, None] / MOMENTS_PER_BEAT * 60.0 / tempo
        found = np.empty((ESCAPE_QUARTERS, len(who) + len(things), 3))
        found[:, : len(who), :2] = out
        found[:, len(who) :, :2] = things[:, :2] + seconds * things[:, 3:5]
        found[:, :, 2] = np.concatenate([model.radius[who], things[:, 2]]) + model.radius[row]
        return found.transpose(1, 0, 2)

    def _escape_shortfall(self, moment: Moment, nodes: Int32, others: Float64) -> Float64:
        """Return the clearance shortfall [m] of an escape through each of `nodes` (C,), (C,)."""
        moments = self._dancers.graph.moments
        now = int(moments.at(moment.phase)[0])
        at = np.minimum(now + np.arange(1, ESCAPE_QUARTERS + 1), moments.hips.shape[1] - 1)
        turn = moment.facing[0] - moments.facing[nodes, now]
        way = moments.hips[nodes[:, None], at] - moments.hips[nodes, now][:, None]
        place = moment.hips[0] + turn_vectors(way, np.broadcast_to(turn[:, None], way.shape[:2]))
        return _shortfall(place.transpose(1, 0, 2), others)

    def _ends(self, moment: Moment, nodes: Int32) -> Float64:
        """Return where the measure would end with each of `nodes` (C,), (C, 2) [m]."""
        moments = self._dancers.graph.moments
        now = int(moments.at(moment.phase)[0])
        turn = moment.facing[0] - moments.facing[nodes, now]
        return np.asarray(moment.hips[0] + turn_vectors(moments.hips[nodes, -1] - moments.hips[nodes, now], turn))


def _shortfall(ways: Float64, others: Float64) -> Float64:
    """Return the shortfall of each of `ways` (ESCAPE_QUARTERS, C, 2) from MARGIN to the `others`
    (M, ESCAPE_QUARTERS, 3) [m]: the sum of the worst and the mean, (C,)."""
    lacks = np.empty(ways.shape[1])
    escape_margins(lacks, np.ascontiguousarray(ways), np.ascontiguousarray(others), MARGIN)
    return lacks


PUSH_AHEAD: Final = np.array([0.1, 0.2, 0.3, 0.4])
"""Times of predicted positions [s]. Dancers who would touch on straight lines to them are pushed apart. One time is
not enough: hips swing within a beat, so a contact may lie in between."""
PUSH_MARGIN: Final = 0.13
"""Gap that a push leaves between two bodies [m]."""
PUSH_STIFFNESS: Final = 36.0
"""Rate at which a push follows the missing gap, critically damped [1/s]. At 24, recorded dancers who were thrown
together came within 0.495 m."""
MAX_PUSH_SPEED: Final = 1.0
"""Largest speed of a push [m/s]: a faster one cannot end before the next dancer."""
MAX_PUSH_ACCELERATION: Final = 15.0
"""Largest change of the speed of a push [m/s²]: more looks like a blow."""


class ContactResolver:
    """Pushes apart dancers who are about to touch, and displaces their measures and paths."""

    def __init__(
        self, correction: "RootCorrection", next_correction: "NextCorrection", path_separation: PathSeparation
    ) -> None:
        self._correction, self._next_correction, self._path_separation = correction, next_correction, path_separation
        count = len(correction.node)
        self._soon = np.zeros((len(PUSH_AHEAD), count, 2), np.float32)
        self._fractions = np.zeros(1 + len(PUSH_AHEAD))
        self._speed: Float64 = np.zeros((count, 2))
        """Speed at which each dancer is pushed [m/s], (A, 2)."""
        self.count = 0
        """Dancer ticks since the start in which a dancer was pushed to avoid contact, at the cost of foot slide."""

    def tick(self, fraction: float, rate: float) -> None:
        """Advance by one tick at `fraction` of the measure, which advances at `rate` [1/s]."""
        carried, dancers = self._correction, self._correction.dancers
        paths, present, then, later = carried.paths, dancers.present, self._next_correction.paths, dancers.coming
        self._fractions[:] = fraction
        self._fractions[1:] += PUSH_AHEAD * rate
        goes_on = dancers.decided and self._next_correction.traced

        def part(begin: int, end: int) -> None:
            extrapolate_paths(
                paths.path, paths.share, present.correction, present.aim_origin,
                then.path, then.share, later.correction, later.aim_origin, goes_on, dancers.graph.window,
                self._fractions, dancers.drawn_hips, self._soon, begin, end,
            )  # fmt: skip

        run_rows(part, len(self._speed), least=4 * RANGE)
        moved = self._path_separation.push_apart(
            dancers.drawn_hips, self._soon, margin=PUSH_MARGIN, stiffness=PUSH_STIFFNESS, dt=TICK
        )
        if moved is None and not self._speed.any():
            dancers.push_velocity[:] = 0.0
            return
        wanted = np.zeros_like(self._speed) if moved is None else moved / TICK
        wanted *= np.minimum(1.0, MAX_PUSH_SPEED / np.maximum(np.hypot(*wanted.T), 1e-9))[:, None]
        change = wanted - self._speed
        size = np.hypot(*change.T)[:, None]
        self._speed += change * np.minimum(1.0, MAX_PUSH_ACCELERATION * TICK / np.maximum(size, 1e-9))
        self._speed[np.abs(self._speed).max(axis=1) < 1e-4] = 0.0
        # no acceleration keeps a push from ending before a third dancer
        self._path_separation.slow_down(dancers.drawn_hips, self._speed, wanted, margin=PUSH_MARGIN)
        self._displace(self._speed * TICK)

    def _displace(self, displacement: Float64) -> None:
        """Displace the measures of all dancers, and all state derived from them, by `displacement` (A, 2) [m]."""
        carried, coming, dancers = self._correction, self._next_correction, self._correction.dancers
        carried.motion.partners.share_push(displacement, dancers.drawn_hips)
        carried.keep_on_stage(
            displacement, dancers.drawn_hips.astype(np.float64), np.maximum(carried.room, np.abs(dancers.drawn_hips))
        )
        displacement[np.abs(displacement) < 1e-7] = 0.0
        dancers.push_velocity[:] = displacement / TICK
        self.count += int(np.count_nonzero(displacement.any(axis=1)))
        for danced in dancers.measures():
            danced.placement[:, :2] += displacement
        for place in (carried.begin, carried.end, coming.end):
            place += displacement
        for paths in (carried.paths, coming.paths):
            paths.path += displacement[:, None].astype(np.float32)
