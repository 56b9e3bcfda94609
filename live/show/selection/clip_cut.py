"""Cuts: switches dancers to other clips within a measure, at the same phase, without a visible jump.

The new clip is chosen by pose and velocity at this phase of the measure (`graph/moments`). It is aligned with the
dancer's body and with the support feet; the remaining difference is faded out by inertialization. The beat is kept,
as the phase is. The next measure follows along the edges of the graph as usual.
"""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float32, Float64, Int32
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.graph.build.metric import joint_weights
from live.graph.build.transitions import clouds
from live.graph.node_features import body_features
from live.graph.select.candidates import following_placement, turn_vectors, wrap_angle
from live.motion.editing.foot_correction import ANKLES, BALLS
from live.motion.pose.foot_lock_kernels import HELD
from live.motion.pose.pose_pipeline import PoseSkeleton
from live.show.dancers.measure_state import MeasureState
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers


PLANTED_WEIGHT: Final = 2.0
"""Weight of a foot on the floor before and after a cut in the alignment of the new clip; all joints together: 1."""
MAX_FOOT_SHIFT: Final = 0.15
"""Most that such feet may move the new clip from the alignment of the whole body [m]."""
LATER_MEASURE_COST: Final = 0.1
"""Added distance of a later measure of a step [m] ..."""
WRONG_SIDE_COST: Final = 1.0
"""... and of a mirror image that the group does not want [m]."""
NEXT_MEASURE_WEIGHTS = np.array([1.0, 0.6, 0.8, 20.0])
"""Cost weights of the measure after a cut: position error² [m²], heading error² [rad²], pose distance [m], another
step."""


class Moment:
    """Poses and velocities of the dancers `rows` (n,) at one moment, before a cut."""

    def __init__(self, dancers: "Dancers", rows: Int32, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        self.rows, self.time, self.dt = rows, time, TICK
        self.fraction = span.fraction(timeline.beat_at(time))
        self.other_fraction, later = (span.fraction(timeline.beat_at(time + dt)) for dt in (-TICK, TICK))
        if self.fraction - self.other_fraction < 0.9 * (later - self.fraction):  # the measure has just begun
            self.dt, self.other_fraction = -TICK, later
        self.body = self.sample_poses(dancers)
        """World positions (2, n, J, 3) and rotations (2, n, J, 4) now and `dt` [s] before."""
        which, phase = dancers.measure_and_phase(self.fraction)
        self.which, self.phase = which[rows], phase[rows]
        self.held = dancers.lock.state[rows, :, HELD] > 0.0
        per_measure = 1.0 / (self.fraction - self.other_fraction) if self.fraction != self.other_fraction else 0.0
        now = self.body[0][0].astype(np.float64)
        self.feature, self.hips, self.facing = body_features(now, (now - self.body[0][1]) * per_measure, self.held)

    def sample_poses(self, dancers: "Dancers") -> tuple[Float32, Float32]:
        """Return the bodies now and `dt` before, from the dancers' present state."""
        now = dancers.raw_poses(self.rows, self.fraction, self.time)
        then = dancers.raw_poses(self.rows, self.other_fraction, self.time - self.dt)
        return np.stack([now[0], then[0]]), np.stack([now[1], then[1]])


class ClipCutter:
    """Cuts A dancers to other clips. Deterministic."""

    def __init__(self, dancers: "Dancers") -> None:
        self._dancers = dancers
        self._joints = joint_weights()
        self._parents = PoseSkeleton.whole().parents
        self.cuts = 0
        """Number of cuts since the start, per dancer."""

    def candidates(self, step: int | None = None) -> Int32:
        """Return the nodes that may be cut to: alive, and of `step` if one is given, (C,)."""
        graph = self._dancers.graph
        chosen = graph.alive if step is None else graph.alive & (graph.library.node_step == step)
        return np.flatnonzero(chosen).astype(np.int32)

    def distances(self, moment: Moment, nodes: Int32) -> Float64:
        """Return the distances of the bodies from each of `nodes` (C,) at their phase [m], (n, C)."""
        library = self._dancers.graph.library
        away = self._dancers.graph.moments.distance(moment.feature.astype(np.float32), moment.phase, nodes)
        away += LATER_MEASURE_COST * (library.node_measure[nodes] > 0)
        sides = self._dancers.variation.sides[moment.rows]
        return np.asarray(away + WRONG_SIDE_COST * (sides[:, None] * library.node_side[nodes] < 0))

    def cut(self, moment: Moment, node: Int32, step: int | None = None) -> None:
        """Switch the dancers to `node` (n,) at their phases. Measures decided after that are replaced: with `step`, or
        (None) with the step that was decided."""
        dancers, rows = self._dancers, moment.rows
        placement = self._aligned_placement(moment, node)
        dancers.release_planned_feet(rows)
        for which, danced in enumerate(dancers.measures()):
            own = moment.which == which
            danced.replace_node(rows[own], node[own], placement[own])
        dancers.inertia.clear(rows)
        self._replace_next_measures(moment, step)
        after = moment.sample_poses(dancers)
        dancers.inertia.cut(rows, moment.body, after, self._parents, time=moment.time, dt=moment.dt)
        dancers.inertia.update_age(moment.time)
        way = (moment.body[0][0] - after[0][0])[:, list(ANKLES)][..., (0, 2)]
        dancers.landing.begin(rows, np.hypot(way[..., 0], way[..., 1]))
        self.cuts += len(rows)

    def _aligned_placement(self, moment: Moment, node: Int32) -> Float64:
        """Return the placements of the clips of `node` (n,) that match the bodies at their phase, (n, 3).

        The whole body determines the rotation (K001), and feet on the floor in both clips, if any, the translation.
        """
        library = self._dancers.graph.library
        first = library.node_first[node]
        sample = first + moment.phase * (library.node_last[node] - first)
        own, new = moment.body[0][0].astype(np.float64), clouds(library, sample[:, None])[:, 0]
        planted = moment.held & library.clip_contact[np.rint(sample).astype(np.int64)]
        weight = np.tile(self._joints, (len(node), 1))
        for joints in (ANKLES, BALLS):
            weight[:, list(joints)] += 0.5 * PLANTED_WEIGHT * planted
        p, q = own[..., 0] + 1j * own[..., 2], new[..., 0] + 1j * new[..., 2]
        total = weight.sum(1)
        p_mean, q_mean = (weight * p).sum(1) / total, (weight * q).sum(1) / total
        turn = (weight * np.conj(q - q_mean[:, None]) * (p - p_mean[:, None])).sum(1)
        turn /= np.maximum(np.abs(turn), 1e-12)  # exp(-i yaw)
        shift = p_mean - turn * q_mean
        feet = [*ANKLES, *BALLS]
        stands = np.concatenate([planted, planted], axis=1)
        count = stands.sum(1)
        exact = ((p - turn[:, None] * q)[:, feet] * stands).sum(1) / np.maximum(count, 1)
        pull = np.where(count > 0, exact - shift, 0.0)
        shift += pull * np.minimum(1.0, MAX_FOOT_SHIFT / np.maximum(np.abs(pull), 1e-9))
        return np.column_stack([shift.real, shift.imag, -np.angle(turn)])

    def _replace_next_measures(self, moment: Moment, step: int | None) -> None:
        """Replace decided measures after the present ones along the graph's edges."""
        measures = self._dancers.measures()
        for which in (0, 1):
            own, then = measures[which], measures[which + 1]
            rows = moment.rows[(moment.which <= which)]
            rows = rows[then.node[rows] >= 0]
            if len(rows):
                planned = self._dancers.graph.library.node_step[then.node[rows]]
                self.choose_next(rows, own, then, step=planned if step is None else np.full_like(planned, step))

    def choose_next(self, rows: Int32, own: MeasureState, then: MeasureState, *, step: Int32) -> None:
        """Choose the measure of the dancers `rows` (n,) after `own`, along the graph's edges, and write it to `then`.

        It is the nearest to `step` (n,) and to the previous content of `then`.
        """
        graph = self._dancers.graph
        old_end, old_heading = then.end_position()[rows], then.end_heading()[rows]
        axes, node = own.end_placement()[rows], own.node[rows]
        start, stop = graph.edge_start[node], graph.edge_start[node + 1]
        most = int((stop - start).max(initial=0))
        if not most:
            return
        edge = np.minimum(start[:, None] + np.arange(most), np.maximum(stop - 1, 0)[:, None])
        placement = following_placement(np.repeat(axes, most, axis=0), graph.edge_transform[edge.reshape(-1)])
        after = graph.edge_target[edge]
        end = placement[:, :2] + turn_vectors(graph.node_end[after.reshape(-1)], placement[:, 2])
        off = np.hypot(*(end.reshape(len(rows), most, 2) - old_end[:, None]).T).T
        facing = placement[:, 2] + graph.node_facing[after.reshape(-1)]
        turned = wrap_angle(facing.reshape(len(rows), most) - old_heading[:, None])
        cost = (
            NEXT_MEASURE_WEIGHTS[0] * off**2
            + NEXT_MEASURE_WEIGHTS[1] * turned**2
            + NEXT_MEASURE_WEIGHTS[2] * graph.edge_cost[edge]
        )
        cost += NEXT_MEASURE_WEIGHTS[3] * ((step >= 0)[:, None] & (graph.library.node_step[after] != step[:, None]))
        best = np.argmin(cost, axis=1)
        place = placement.reshape(len(rows), most, 3)[np.arange(len(rows)), best]
        then.replace_node(rows, after[np.arange(len(rows)), best], np.ascontiguousarray(place))
