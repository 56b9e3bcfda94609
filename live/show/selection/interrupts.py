"""Changes of step within a measure: live cues, and short-term collision avoidance.

A cue waits for the next half beat, so that the change is visible on it. A dancer about to collide with a dancer or a
performer cuts at once to a step that leads away or stands. Collision avoidance has priority over cues. After a cut
(`clip_cut.py`), the measure continues as usual.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.entrances.entrances import ON
from live.base.arrays import Bool, Float64, Int32
from live.clock.timeline import Timeline
from live.control.events.events import StepNow
from live.show.dancers.collision_avoidance import CollisionAvoidance
from live.show.dancers.dancers import Dancers
from live.show.patch.patch import Patch
from live.show.score.step_names import find_step
from live.show.selection.clip_cut import ClipCutter, Moment
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.scheduler import Scheduler


PLANNING_BEATS: Final = 2.0
"""From this many beats before the line on, the next measure may be planned already."""
NO_STEP: Final = -1


@dataclass(frozen=True, slots=True, eq=False)
class _Cue:
    """A step for the dancers `who` (A,) from the next half beat on, and for `measures` whole measures after it."""

    step: int
    who: Bool
    measures: int
    groups: tuple[int, ...]
    """Groups that are completely selected: their programmes continue with the step."""
    words: str
    """The selection."""


class Interrupts:
    """The interrupts of one show. `cue` is called for events, `tick` once a tick, after the planning."""

    def __init__(self, patch: Patch, dancers: Dancers, motion: "GroupMotion", scheduler: "Scheduler") -> None:
        count = len(motion.casting.group)
        self._dancers, self._motion, self._scheduler = dancers, motion, scheduler
        self.clip_cutter = ClipCutter(dancers)
        self._cues: list[_Cue] = []
        self._half: tuple[int, int] | None = None
        self._decided = False
        self._step: Int32 = np.full(count, NO_STEP, np.int32)  # the step after a cut that the plan does not include
        self._unplanned: Bool = np.zeros(count, np.bool_)
        self._collision_avoidance = CollisionAvoidance(dancers, motion, self._targets, self.clip_cutter, self._cut)
        self.cue_count = 0
        """Number of cues that have acted."""

    @property
    def avoidance_count(self) -> int:
        """Number of times a dancer has left the step because of a collision."""
        return self._collision_avoidance.count

    def _targets(self) -> Float64:
        """Return the targets of all dancers for the end of the present measure, (A, 2) [m]."""
        return self._scheduler.root_correction.predicted

    def cue(self, event: StepNow) -> None:
        """Queue a cue. Raises UnknownStep for an unknown step, PersonError for unknown words in the selection."""
        step = find_step(self._dancers.graph, event.name)
        casting = self._motion.casting
        who = casting.select(event.group, self._motion.state.position)
        groups = tuple(index for index in range(len(casting.names)) if who[casting.group == index].all())
        self._cues.append(_Cue(step, who, math.ceil(event.measures), groups, event.group.strip()))

    def statistics(self) -> dict[str, int]:
        """Return statistics for the status: cues that have acted, dancers cut by them, and dancers cut by collision
        avoidance."""
        return {
            "cues": self.cue_count,
            "cut": self.clip_cutter.cuts - self.avoidance_count,
            "avoided": self.avoidance_count,
        }

    def clear(self) -> None:
        """Drop cues that have not acted yet."""
        self._cues.clear()

    def tick(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Cut the dancers who must leave their step at the tick at `time` [s]."""
        self._dancers.inertia.update_age(time)  # a frame drawn since the last tick has left ages of another time
        if self._decided and self._dancers.decided and self._unplanned.any():
            self._replan()  # not in the tick of the decision, to limit its load
        self._decided = self._dancers.decided
        half = span.number, math.floor(2.0 * timeline.beats_per_measure * span.fraction(timeline.beat_at(time)) + 1e-9)
        if half != self._half:
            self._half = half
            for cue in self._cues:
                self._apply_cue(cue, span, timeline, time)
            self._cues.clear()
        self._collision_avoidance.tick(span, timeline, time)

    # -- cues ----------------------------------------------------------------------------------------------------

    def _apply_cue(self, cue: _Cue, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        self.cue_count += 1
        planned = self._dancers.decided or span.end - timeline.beat_at(time) <= PLANNING_BEATS
        measures = cue.measures - planned
        if measures > 0:
            self._call(cue, measures)
        rows = np.flatnonzero(cue.who & self._on_stage).astype(np.int32)
        if not len(rows):
            return
        moment = Moment(self._dancers, rows, span, timeline, time)
        nodes = self.clip_cutter.candidates(cue.step)
        best = np.argmin(self.clip_cutter.distances(moment, nodes), axis=1)
        self._cut(moment, nodes[best], span, timeline, step=cue.step if cue.measures else None)

    def _call(self, cue: _Cue, measures: int) -> None:
        """Let the programs of a cue's groups and subgroups continue with its step."""
        scheduler, casting = self._scheduler, self._motion.casting
        for index in cue.groups:
            scheduler.programmes[index].call(cue.step, measures=measures)
            scheduler.subgroups.call(index, cue.step, measures=measures)
        others = cue.who & ~np.isin(casting.group, cue.groups)
        if others.any() and scheduler.subgroups.has_room(others):
            for program in scheduler.subgroups.request(cue.words, others):
                program.call(cue.step, measures=measures)

    @property
    def _on_stage(self) -> Bool:
        """Whether each dancer is on the stage, shape (A,). Dancers who enter or leave are not cut."""
        return np.asarray(self._motion.entrances.state == ON)

    def _cut(
        self, moment: Moment, node: Int32, span: MeasureSpan, timeline: Timeline, *, step: int | None = None
    ) -> None:
        """Cut, and replace the next measure accordingly: at once, or, while it is being planned, after that."""
        self.clip_cutter.cut(moment, node, step)
        if not self._dancers.decided and span.end - timeline.beat_at(moment.time) <= PLANNING_BEATS:
            self._step[moment.rows], self._unplanned[moment.rows] = NO_STEP if step is None else step, True

    def _replan(self) -> None:
        """Choose the next measure again for dancers whose cut came after their planning had begun."""
        dancers, rows = self._dancers, np.flatnonzero(self._unplanned).astype(np.int32)
        planned = dancers.graph.library.node_step[dancers.coming.node[rows]]
        step = np.where(self._step[rows] == NO_STEP, planned, self._step[rows]).astype(np.int32)
        self.clip_cutter.choose_next(rows, dancers.present, dancers.coming, step=step)
        self._unplanned[:], self._step[:] = False, NO_STEP
