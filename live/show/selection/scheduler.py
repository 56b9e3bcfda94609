"""Scheduler: measure lines, look-ahead and the choice of every dancer's next step, a beat ahead of the line (T038).

From LOOK_BEATS before the line on the next measure is planned, so much in each tick that it is done a beat before it.
Then what was found is laid down where the dancers will really end; at the line everybody crosses, and nothing is
searched. The way a dancer is still off after her step is spread over that measure (position targets, T068).
"""

import math
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import joined
from live.graph.select.selector import Choosing
from live.show.dancers.dancers import Dancers
from live.show.dancers.root_correction_control import Carrying
from live.show.group.group_motion import GroupMotion
from live.show.measure_span import MeasureSpan
from live.show.patch.patch import Patch
from live.show.score.canon import Programme
from live.show.score.group_programs import take_programmes
from live.show.selection.choices import Choices, behind
from live.show.selection.nearest_steps import decide_nearest
from live.show.selection.planning import Planning
from live.show.selection.step_targets import Aims

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

LOOK_BEATS: Final = 1.75
"""Beats before the measure line at which the look-ahead begins."""
DECIDE_BEATS: Final = 1.0
"""Beats before it at which the next steps are chosen: never later than the blend begins."""
ANEW_TICKS: Final = 8.0
"""With fewer ticks until the decision the planning of a measure is not begun anew."""


class Scheduler:
    """Decides for A dancers in their groups; deterministic."""

    def __init__(
        self,
        patch: Patch,
        dancers: Dancers,
        motion: GroupMotion,
        programmes: list[Programme],
        group: Int32,
        choosing: Choosing | None = None,
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures; `choosing` is that of the
        dancers' graph if it is known."""
        self._patch = patch
        self._dancers = dancers
        self._motion = motion
        self._group = group
        self.programmes = programmes
        self.carrying = Carrying(patch, dancers, motion)
        self.aims = Aims(patch, dancers, motion, programmes, group)
        self.order = self.aims.order
        self.speed: Float32 = self.aims.speed
        """Top speed of each agent [m/s], shape (A,)."""
        count = len(group)
        self.choices = Choices(count)
        self._planning = Planning(patch, dancers, motion, self.aims, self.choices, group)
        self.take_graph(dancers.graph, choosing or Choosing.of(dancers.graph))
        self.last_target: Float64 | None = None
        """Where the dancers were last sent, no farther than their steps reach [m], (A, 2); None before the first
        decision."""
        self.last_heading = np.zeros(count)
        """What they were to face there [rad], shape (A,)."""
        self.detours = 0
        """How often a dancer could not dance the wanted step at once, since the start."""
        self.dead_ends = 0
        """How often a dancer found no next measure and repeated hers, since the start."""

    def take_graph(self, graph: MotionGraph, choosing: Choosing) -> None:
        """Choose in this graph from now on; called when nobody's next measure is decided."""
        self.choosing = choosing
        self._planning.take_graph(graph, choosing)
        self.aims.take_graph(graph, choosing)
        self.foresight = self.aims.foresight

    def take_patch(self, fresh: "Scheduler") -> None:
        """Take over what groups dance. Called when nobody's next measure is decided."""
        take_programmes(self.programmes, fresh.programmes, fresh._patch)
        self.aims.reorder()

    def farthest(self) -> Float64:
        """How far each dancer's steps go in one measure [m]: the farthest of her group's, shape (A,)."""
        return self.aims.farthest()

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Let the agents of each group go as fast as its steps and the correction can follow."""
        self._planning.set_seconds(timeline.beats_per_measure * 60.0 / timeline.tempo)
        self.aims.set_speed(measure, timeline)

    @property
    def at_rest(self) -> bool:
        """Whether no measure is half planned."""
        return not self._planning.pieces

    # -- the planning of one measure -----------------------------------------------------------------------------

    def work(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Do this tick's share of the planning for the measure after `span`."""
        if self._dancers.decided:
            return
        left = span.end - timeline.beat_at(time)
        # a measure that "this is the one" has stretched reaches its blend more than a beat before its end
        blends = span.fraction(timeline.beat_at(time + TICK)) >= 1.0 - self._dancers.graph.window
        if left <= DECIDE_BEATS or blends:
            self.decide(span, timeline, time)
            return
        if self.at_rest:
            if left > max(LOOK_BEATS, DECIDE_BEATS + 2.0 * TICK) or self._planning.begun:
                return
            self._planning.begin(span, timeline, time)
            return
        ticks = math.ceil((left - DECIDE_BEATS) * 60.0 / timeline.tempo / TICK)
        self._planning.pieces.work(ticks)

    def plan_anew(self, span: MeasureSpan, timeline: Timeline, time: float) -> bool:
        """Forget what is planned of the measure after `span`, and plan it again; False if it is too late for that."""
        if self._dancers.decided:
            return False
        if not self._planning.begun:
            return True
        if (span.end - timeline.beat_at(time) - DECIDE_BEATS) * 60.0 / timeline.tempo < ANEW_TICKS * TICK:
            return False
        self._planning.give_up()
        for programme in self.programmes:
            programme.take_back(span.number + 1)
        return True

    def drop_plan(self) -> None:
        """Forget what is half planned, for nobody will finish it; what was decided stays."""
        self._planning.drop()

    # -- the decision --------------------------------------------------------------------------------------------

    def decide(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Choose the next measure of every dancer now, finishing what is not planned yet."""
        if not self._planning.begun:
            self._planning.begin(span, timeline, time)
        self._planning.finish(span.number + 1)
        self._take()
        self._planning.forget()
        self.last_target, self.last_heading = self.choices.target.copy(), self.aims.heading.copy()

    def _take(self) -> None:
        """Lay down the chosen measures where the dancers will be, and add what they need to end in place."""
        dancers, graph, choices = self._dancers, self._dancers.graph, self.choices
        coming, edge = dancers.coming, choices.edge[:, 0]
        hips, _, axes = dancers.present.ends_and_axes()  # by now: the present measure may have been aimed anew
        coming.copy_from(self._planning.draft)
        coming.placement[:] = joined(axes, graph.edge_transform[np.maximum(edge, 0)])
        stuck = edge < 0
        if stuck.any():  # cannot happen in a pruned graph; a dancer who is stuck repeats her measure
            self.dead_ends += int(stuck.sum())
            coming.placement[stuck] = axes[stuck]
        self.detours += int(
            np.count_nonzero((choices.step >= 0) & (graph.library.node_step[coming.node] != choices.step))
        )
        self.carrying.decided(hips, choices.target, choices.wish)

    def decide_nearest(self, half: npt.NDArray[np.floating]) -> None:
        """Choose without any plan, of what may follow what is nearest; `half` (2,) [m]: of the stage."""
        begin = decide_nearest(self._dancers, half)
        end = self._dancers.coming.end_position()
        self.carrying.decided(begin, end, end)

    # -- what there is to say ------------------------------------------------------------------------------------

    def behind(self) -> dict[str, Any]:
        """How near to where they are sent the dancers of each group get, and what should be recorded (T075)."""
        return behind(
            self.choices,
            self._group,
            tuple(section.name for section in self._patch.group),
            self._dancers.graph.library.steps,
            self._motion.present,
        )
