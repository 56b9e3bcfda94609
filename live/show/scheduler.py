"""Scheduler: measure lines, look-ahead and the choice of every dancer's next step, a beat ahead of the line (T038).

Within a measure: 1.5 beats before its end the agents are run ahead on a copy, a few coarse steps per tick; one beat
before its end the motion graph is asked for each dancer's next measure; at the line everybody crosses, and nothing is
searched. The way a dancer is still off after her step is spread over that measure (position targets, T068).
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.look_ahead import LookAhead
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.graph.candidates import QUICKEST_TURN
from live.graph.kernels import choose_edges
from live.graph.motion_graph import MotionGraph
from live.show.carrying import Carrying
from live.show.danced import Danced
from live.show.dancers import Dancers
from live.show.echo import Echo, Programme
from live.show.foresight import Foresight
from live.show.group_motion import GroupMotion
from live.show.measure import MeasureSpan
from live.show.patch import Patch

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

LOOK_BEATS = 1.5
"""Beats before the measure line at which the look-ahead begins."""
DECIDE_BEATS = 1.0
"""Beats before it at which the next steps are chosen: never later than the blend begins."""

# a metre off the place, a radian off the heading, a metre between poses, a measure away from the wanted step, a mirror
# image where the group wants none (dearer than any place on the stage, cheaper than another step)
WEIGHTS = np.array([1.0, 0.6, 0.8, 40.0, 20.0])


class Scheduler:
    """Decides for A dancers in their groups; deterministic."""

    def __init__(
        self,
        patch: Patch,
        dancers: Dancers,
        motion: GroupMotion,
        programmes: list[Programme],
        group: Int32,
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures."""
        self._patch = patch
        self._dancers = dancers
        self._motion = motion
        self.carrying = Carrying(patch, dancers, motion)
        self.programmes = programmes
        self.order = sorted(range(len(programmes)), key=lambda index: isinstance(programmes[index], Echo))
        """The groups in the order in which they are asked: whoever echoes another one after her."""
        self._group = group
        self._looking = False
        self._seconds = 2.0
        count = len(group)
        self.speed: Float32 = np.zeros(count, np.float32)
        """Top speed of each agent [m/s]: what its dancer's steps can follow, shape (A,)."""
        self._edge = np.zeros(count, np.int32)
        self._wanted = np.zeros(count, np.int32)
        self._row = np.zeros(count, np.int32)
        self.take_graph(dancers.graph)
        self.last_target: Float64 | None = None
        """Where the dancers were last sent [m], shape (A, 2); None before the first decision."""
        self.last_heading = np.zeros(count)
        """What they were to face there [rad], shape (A,)."""
        self.detours = 0
        """How often a dancer could not dance the wanted step at once, since the start."""
        self.dead_ends = 0
        """How often a dancer found no next measure and repeated hers, since the start."""

    def take_graph(self, graph: MotionGraph) -> None:
        """Choose in this graph from now on; called when nobody's next measure is decided."""
        library = graph.library
        self.foresight = Foresight(graph)
        self._ahead = np.zeros((2 * len(self.programmes), library.node_count))
        reach = [library.reach(step) for step in range(len(library.steps))]
        # how far one measure of each step goes [m]; last, as for ANY_STEP, of the farthest
        self._reach = np.array([*reach, max(reach)])
        for programme in self.programmes:
            programme.take_graph(graph)

    def farthest(self) -> Float64:
        """How far each dancer's steps go in one measure [m]: the farthest of her group's, shape (A,)."""
        most = np.zeros(len(self._group))
        for index, programme in enumerate(self.programmes):
            steps = [*programme.steps, *([] if programme.travel_step is None else [programme.travel_step])]
            most[self._group == index] = max(float(self._reach[step]) for step in steps)
        return most

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Let the agents of each group go as fast as its steps and the correction can follow."""
        seconds = self._seconds = timeline.beats_per_measure * 60.0 / timeline.tempo
        for index in self.order:
            programme, members = self.programmes[index], self._group == index
            step = programme.wanted(measure, self._dancers.node[members])
            steps = [step] if programme.travel_step is None else [step, programme.travel_step]
            reach = max(float(self._reach[s]) for s in steps)
            self.speed[members] = (reach + 0.2 * self._patch.locomotion.correction_m) / seconds

    def work(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Do this tick's share of the planning for the measure after `span`."""
        if self._dancers.decided:
            return
        beat = timeline.beat_at(time)
        left = span.end - beat
        # a measure that "this is the one" has stretched reaches its blend more than a beat before its end
        blends = span.fraction(timeline.beat_at(time + TICK)) >= 1.0 - self._dancers.graph.window
        if left <= DECIDE_BEATS or blends:
            self.decide(span, timeline, time)
            return
        if not self._looking and left <= max(LOOK_BEATS, DECIDE_BEATS + 2.0 * TICK):
            seconds = max(0.0, (left + timeline.beats_per_measure) * 60.0 / timeline.tempo)
            self._look(time, seconds, timeline)
            self._looking = True
            ticks = max(1.0, (left - DECIDE_BEATS) * 60.0 / timeline.tempo / TICK)
            late = float(self._dancers.variation.late.max()) * timeline.beats_per_measure * 60.0 / timeline.tempo
            self._share = math.ceil((seconds + late) / LookAhead.STEP / ticks)
        if self._looking:
            self._motion.work(self._share)

    def _look(self, time: float, seconds: float, timeline: Timeline) -> None:
        late = self._dancers.variation.late * timeline.beats_per_measure
        self._motion.look(time, seconds, self._dancers.present.end_heading(), late)

    def decide(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Choose the next measure of every dancer now, finishing the look-ahead first."""
        if not self._looking:
            left = max(0.0, span.end - timeline.beat_at(time))
            seconds = (left + timeline.beats_per_measure) * 60.0 / timeline.tempo
            self._look(time, seconds, timeline)
        self._motion.work(1 << 20)
        self._looking = False
        dancers, graph = self._dancers, self._dancers.graph
        placement = dancers.present.end_placement()
        target, known, planned = self._motion.ahead()
        heading = self._headings(dancers.present.end_position(), target)
        heading[known] = planned[known]
        self._choose_steps(span.number + 1, target)
        choose_edges(
            dancers.node,
            placement,
            target,
            heading,
            self._row,
            self._ahead,
            graph.edge_start,
            graph.edge_target,
            graph.edge_cost,
            graph.edge_transform,
            graph.node_end,
            graph.node_facing,
            dancers.variation.sides,
            graph.library.node_side,
            WEIGHTS,
            self._edge,
            dancers.coming.placement,
        )
        self._take(span.number + 1, placement, target, heading)
        self.last_target, self.last_heading = target, heading

    def _choose_steps(self, measure: int, target: Float64) -> None:
        """The step each dancer should dance: her group's, or its travel step if the way is too far for that."""
        limits = self._patch.locomotion
        way = np.hypot(*(target - self._dancers.present.end_position()).T)
        for index in self.order:
            programme, members = self.programmes[index], self._group == index
            step = programme.wanted(measure, self._dancers.node[members])
            self._wanted[members] = step
            self._row[members] = 2 * index
            self._ahead[2 * index] = self.foresight.sequence(programme.coming, programme.into)
            if programme.travel_step is not None and self._reach[programme.travel_step] > self._reach[step]:
                far = members & (way > self._reach[step] + 0.5 * limits.correction_m)
                self._wanted[far] = programme.travel_step
                self._row[far] = 2 * index + 1
                self._ahead[2 * index + 1] = self.foresight.step(programme.travel_step)

    def _headings(self, start: Float64, target: Float64) -> Float64:
        """Where each dancer should face at the end of the next measure [rad]."""
        heading = np.zeros(len(start))
        for index, section in enumerate(self._patch.group):
            members = self._group == index
            if section.facing == "path":
                way = target[members] - start[members]
                moving = np.hypot(*way.T) > 0.25
                heading[members] = np.where(moving, np.arctan2(way[:, 0], way[:, 1]), 0.0)
            elif section.facing == "centre":
                way = np.array(section.centre) - target[members]
                heading[members] = np.arctan2(way[:, 0], way[:, 1])
        passing = self._motion.entrances.passing  # whoever comes or goes looks where she goes
        way = target[passing] - start[passing]
        heading[passing] = np.where(np.hypot(*way.T) > 0.25, np.arctan2(way[:, 0], way[:, 1]), heading[passing])
        return heading

    def _take(self, measure: int, placement: Float64, target: Float64, heading: Float64) -> None:
        """Write the chosen measures and what must be added to them to end in place."""
        dancers, graph, limits = self._dancers, self._dancers.graph, self._patch.locomotion
        coming, stuck = dancers.coming, self._edge < 0
        if stuck.any():  # cannot happen in a pruned graph; a dancer who is stuck repeats her measure
            self.dead_ends += int(stuck.sum())
            coming.placement[stuck] = placement[stuck]
        coming.node[:] = np.where(stuck, dancers.node, graph.edge_target[np.maximum(self._edge, 0)])
        wrong = (self._wanted >= 0) & (graph.library.node_step[coming.node] != self._wanted)
        self.detours += int(np.count_nonzero(wrong))
        dancers.variation.draw(measure, coming)
        most = np.minimum(
            math.radians(limits.turn_deg), QUICKEST_TURN * self._seconds / graph.node_quickest[coming.node]
        )
        coming.correction[:] = coming.aimed[:] = 0.0
        off = heading - self._own_heading(coming)
        coming.correction[:, 2] = np.clip(np.arctan2(np.sin(off), np.cos(off)), -most, most)
        self.carrying.settle(target)

    def _own_heading(self, coming: Danced) -> Float64:
        """Heading that each dancer would end with, or have on the average (T122), if nothing were added, (A,) [rad]."""
        average = self._dancers.variation.face_average
        own = coming.own_end()[1]
        off = self._dancers.graph.node_facing_mean[coming.node] - own
        return np.asarray(coming.placement[:, 2] + own + average * np.arctan2(np.sin(off), np.cos(off)))
