"""Interrupts: what acts within the measure, at once: cues "now", and collisions that no planning has prevented.

A cue waits for the next half beat, so that the change is seen on it. Whoever would be met within a moment, by
another dancer or by somebody real, leaves her step at once for one that goes away or stands; collision safety always
wins. Both are cuts (`show/cutting.py`), after which the measure goes on as usual.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.threats.kernels import find_threatened
from live.agents.wings.entrances import ON
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.control.events import StepNow
from live.graph.moments.moments import PER_BEAT
from live.graph.placing import turn_vectors
from live.show.cutting import Cutting, Moment
from live.show.dancers import Dancers
from live.show.group_motion import GroupMotion
from live.show.measure import MeasureSpan
from live.show.patch import Patch
from live.show.programme import find_step
from live.show.scheduler import Scheduler

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

AHEAD: Final = (0.4, 0.8)
"""Seconds ahead at which everybody is looked for: dancers meet dancers at the first of them, and things and real
performers, of whom no plan knows, at any."""
GLANCE_TICKS: Final = 2
"""Ticks from one look ahead to the next: everybody is judged at every fourth tick."""
GRAZE: Final = 0.03
"""Things and real performers may be grazed by so many metres before a dancer leaves her step for them."""
SLACK: Final = 0.2
"""Dancers whose bodies would meet by less than this [m] are carried and pushed apart, which costs them no step."""
PLANNED: Final = 2.0
"""Beats before the line from which on the next measure may be planned already."""
WAY_OUT: Final = 8
"""Quarters of a beat over which a way out is judged."""
MARGIN: Final = 0.15
"""Room [m] that a way out should leave to everybody; what is missing, at the worst and on the average, is trouble..."""
CLOSE: Final = 6.0
"""... of which a metre counts as so many metres between bodies."""
GAIN: Final = 0.06
"""A step is left only if that is worth so many metres of trouble."""
NOTHING: Final = -1


@dataclass(frozen=True, slots=True, eq=False)
class _Cue:
    """A step that dancers `who` (A,) should be in from the next half beat on, and for whole `measures` more."""

    step: int
    who: Bool
    measures: int
    groups: tuple[int, ...]
    """Groups that are meant whole: their programmes go on with the step."""


class Interrupts:
    """The interrupts of one show. Call `cue` for events and `tick` once a tick, after the planning."""

    def __init__(self, patch: Patch, dancers: Dancers, motion: GroupMotion, scheduler: Scheduler) -> None:
        count = len(motion.casting.group)
        self._half_stage = np.array([patch.stage.width / 2, patch.stage.depth / 2])
        self._dancers, self._motion, self._scheduler = dancers, motion, scheduler
        self.cutting = Cutting(dancers)
        self._cues: list[_Cue] = []
        self._half: tuple[int, int] | None = None
        self._step: Int32 = np.full(count, NOTHING, np.int32)  # what must follow a cut that the plan did not know of
        self._unplanned: Bool = np.zeros(count, np.bool_)
        self._ways: Float64 = np.zeros((len(AHEAD) + 1, count, 2))
        self._things: Float64 = np.zeros((len(AHEAD) + 1, len(motion.surroundings.obstacles), 2))
        self._tick = -1
        self._met: Float64 = np.zeros(count)
        self.cues = 0
        """How many cues have acted."""
        self.avoided = 0
        """How often a dancer has left her step because of a collision."""

    def cue(self, event: StepNow) -> None:
        """Take up a cue; UnknownStep for a step that is not there, PersonError for words that mean nobody."""
        step = find_step(self._dancers.graph, event.name)
        casting = self._motion.casting
        who = casting.select(event.group, self._motion.state.position)
        groups = tuple(index for index in range(len(casting.names)) if who[casting.group == index].all())
        self._cues.append(_Cue(step, who, math.ceil(event.measures), groups))

    def figures(self) -> dict[str, int]:
        """For the status: cues that have acted, dancers who left their step for one, and because of a collision."""
        return {"cues": self.cues, "cut": self.cutting.cuts - self.avoided, "avoided": self.avoided}

    def clear(self) -> None:
        """Forget cues that have not acted yet."""
        self._cues.clear()

    def tick(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Cut whoever must leave her step at the tick at `time` [s]."""
        if self._dancers.decided and self._unplanned.any():
            self._go_on()
        half = span.number, math.floor(2.0 * timeline.beats_per_measure * span.fraction(timeline.beat_at(time)) + 1e-9)
        if half != self._half:
            self._half = half
            for cue in self._cues:
                self._act(cue, span, timeline, time)
            self._cues.clear()
        self._look_out(span, timeline, time)

    # -- cues ----------------------------------------------------------------------------------------------------

    def _act(self, cue: _Cue, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        self.cues += 1
        planned = self._dancers.decided or span.end - timeline.beat_at(time) <= PLANNED
        measures = cue.measures - planned
        for index in cue.groups:
            if measures > 0:
                self._scheduler.programmes[index].call(cue.step, measures=measures)
        rows = np.flatnonzero(cue.who & self._here).astype(np.int32)
        if not len(rows):
            return
        moment = Moment(self._dancers, rows, span, timeline, time)
        nodes = self.cutting.candidates(cue.step)
        best = np.argmin(self.cutting.distances(moment, nodes), axis=1)
        self._cut(moment, nodes[best], span, timeline, step=cue.step if cue.measures else None)

    @property
    def _here(self) -> Bool:
        """Who dances on the stage, shape (A,): those who come and go are left alone."""
        return np.asarray(self._motion.entrances.state == ON)

    def _cut(
        self, moment: Moment, node: Int32, span: MeasureSpan, timeline: Timeline, *, step: int | None = None
    ) -> None:
        """Cut, and see to what follows: at once, or, while the next measure is being planned, when that is done."""
        self.cutting.cut(moment, node, step)
        if not self._dancers.decided and span.end - timeline.beat_at(moment.time) <= PLANNED:
            self._step[moment.rows], self._unplanned[moment.rows] = NOTHING if step is None else step, True

    def _go_on(self) -> None:
        """Choose anew what follows for those whose plan did not know of their cut."""
        dancers, rows = self._dancers, np.flatnonzero(self._unplanned).astype(np.int32)
        planned = dancers.graph.library.node_step[dancers.coming.node[rows]]
        step = np.where(self._step[rows] == NOTHING, planned, self._step[rows]).astype(np.int32)
        self.cutting.follow(rows, dancers.present, dancers.coming, step=step)
        self._unplanned[:], self._step[:] = False, NOTHING

    # -- collisions ----------------------------------------------------------------------------------------------

    def _look_out(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Look ahead at every second tick, each time farther; after the last look whoever would be met goes away."""
        self._tick = (self._tick + 1) % (GLANCE_TICKS * len(AHEAD))
        k, rest = divmod(self._tick, GLANCE_TICKS)
        if rest:
            return
        if k == 0:
            self._ways[0] = self._dancers.shown
        if k == 0 or self._motion.surroundings.obstacle_count:  # dancers among themselves need no second look
            ahead = AHEAD[k] - GLANCE_TICKS * TICK * k  # all moments are counted from the first look
            self._ways[k + 1] = self._dancers.ahead(span.fraction(timeline.beat_at(time + ahead)))
        if k < len(AHEAD) - 1:
            return
        around, model = self._motion.surroundings, self._motion.model
        things = around.obstacles
        for n, seconds in enumerate((0.0, *AHEAD)):
            self._things[n] = things[:, :2] + seconds * things[:, 3:5]
        paired = self._motion.partners.of >= 0
        find_threatened(
            self._ways, model.radius, model.responsibility * (self._here & ~paired), self._motion.present,
            np.argsort(self._ways[0, :, 0]), self._things, things[:, 2] + np.float32(SLACK - GRAZE),
            around.obstacle_count, SLACK, self._met,
        )  # fmt: skip
        # who was cut is on her way out already; partners stay together, and are carried or pushed out of the way
        self._met[self._dancers.inertia.settling_now | ~self._here | paired] = 0.0
        rows = np.flatnonzero(self._met).astype(np.int32)
        if len(rows):
            self._avoid(rows, span, timeline, time)

    def _avoid(self, rows: Int32, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """One after the other, those met first at the front, so that each sees where the others now go."""
        out = self._out(span, timeline, time)
        for row in rows[np.argsort(self._met[rows], kind="stable")]:
            moment = Moment(self._dancers, np.array([row], np.int32), span, timeline, time)
            nodes = self.cutting.candidates()
            others = self._others(int(row), out, timeline.tempo)
            trouble, stays = self._trouble(moment, nodes, others), _trouble_of(out[:, row][:, None], others)[0]
            cost = self.cutting.distances(moment, nodes)[0] + CLOSE * trouble
            cost += CLOSE * np.hypot(*np.maximum(np.abs(self._ends(moment, nodes)) - self._half_stage, 0.0).T)
            best = int(np.argmin(cost))
            if trouble[best] < stays - GAIN:
                self._cut(moment, nodes[best : best + 1], span, timeline)
                self.avoided += 1
                out = self._out(span, timeline, time)

    def _out(self, span: MeasureSpan, timeline: Timeline, time: float) -> Float64:
        """Where everybody will be in the next quarters of a beat, as things are, (WAY_OUT, A, 2) [m]."""
        beat = timeline.beat_at(time)
        quarters = np.arange(1, WAY_OUT + 1) / PER_BEAT
        return np.stack([self._dancers.ahead(span.fraction(beat + quarter)) for quarter in quarters.tolist()])

    def _others(self, row: int, out: Float64, tempo: float) -> Float64:
        """Where those who are near will be, and how near to them is too near: x, z, distance [m], (M, WAY_OUT, 3)."""
        model, around = self._motion.model, self._motion.surroundings
        near = self._motion.present & (np.hypot(*(self._ways[0] - self._ways[0, row]).T) < 3.0)
        near[row] = False
        who = np.flatnonzero(near)
        things = around.obstacles[: around.obstacle_count].astype(np.float64)
        seconds = np.arange(1, WAY_OUT + 1)[:, None, None] / PER_BEAT * 60.0 / tempo
        found = np.empty((WAY_OUT, len(who) + len(things), 3))
        found[:, : len(who), :2] = out[:, who]
        found[:, len(who) :, :2] = things[:, :2] + seconds * things[:, 3:5]
        found[:, :, 2] = np.concatenate([model.radius[who], things[:, 2]]) + model.radius[row]
        return found.transpose(1, 0, 2)

    def _trouble(self, moment: Moment, nodes: Int32, others: Float64) -> Float64:
        """How much room [m] the dancer would lack on her way out through each of `nodes` (C,), (C,)."""
        moments = self._dancers.graph.moments
        now = int(moments.at(moment.phase)[0])
        at = np.minimum(now + np.arange(1, WAY_OUT + 1), moments.hips.shape[1] - 1)
        turn = moment.facing[0] - moments.facing[nodes, now]
        way = moments.hips[nodes[:, None], at] - moments.hips[nodes, now][:, None]
        place = moment.hips[0] + turn_vectors(way, np.broadcast_to(turn[:, None], way.shape[:2]))
        return _trouble_of(place.transpose(1, 0, 2), others)

    def _ends(self, moment: Moment, nodes: Int32) -> Float64:
        """Where each of `nodes` (C,) would end the measure, (C, 2) [m]."""
        moments = self._dancers.graph.moments
        now = int(moments.at(moment.phase)[0])
        turn = moment.facing[0] - moments.facing[nodes, now]
        return np.asarray(moment.hips[0] + turn_vectors(moments.hips[nodes, -1] - moments.hips[nodes, now], turn))


def _trouble_of(ways: Float64, others: Float64) -> Float64:
    """What each of `ways` (WAY_OUT, C, 2) lacks of MARGIN to the `others` (M, WAY_OUT, 3) [m]: at the worst and on the
    average, added, (C,)."""
    lacks = np.zeros(ways.shape[:2])
    for other in others:
        away = np.hypot(*(ways - other[:, None, :2]).transpose(2, 0, 1)) - other[:, None, 2]
        lacks = np.maximum(lacks, MARGIN - away)
    return np.asarray(lacks.max(axis=0) + lacks.mean(axis=0))
