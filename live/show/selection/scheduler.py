"""Scheduler of step selection: plans the next measure of all dancers and decides it a beat before the line (T038).

From LOOK_BEATS before the line on, the next measure is planned over several ticks, to be done a beat before the line;
thousands of dancers are planned from up to a beat earlier on.
Then the chosen clips are placed where the present measures will actually end. Nothing is searched at the line itself.
The remaining position error of a step is spread over the measure (position targets, T068).
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float32, Float64, Int32
from live.clock.ticks import TICK
from live.clock.timeline import Timeline
from live.control.events.event import ControlEvent
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import following_placement
from live.graph.select.selector import StepSelector
from live.show.dancers.dancers import Dancers
from live.show.dancers.root_correction_control import RootCorrectionControl
from live.show.patch.patch import Patch
from live.show.score.canon import StepSource
from live.show.score.group_programs import update_programs
from live.show.score.subgroups import Subgroups
from live.show.selection.choices import StepChoices, reachability_report, tempo_report
from live.show.selection.nearest_steps import decide_nearest
from live.show.selection.planning import MeasurePlan
from live.show.selection.step_targets import StepTargets
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion


LOOK_BEATS: Final = 1.75
"""Beats before the measure line at which the look-ahead begins, ..."""
MORE_LOOK_BEATS: Final = 1.0
"""... and so many more for CROWD dancers and more: their planning would fill the frames, ..."""
FEW, CROWD = 1000, 5000
"""... but none for FEW dancers, who answer to newer events."""
DECIDE_BEATS: Final = 1.0
"""Beats before it at which the next steps are decided: never later than the blend begins."""
SUBGROUPS: Final = -1
"""Key of the subgroups' sequences among the values that can be edited."""
MIN_REPLAN_TICKS: Final = 8.0
"""With fewer ticks until the decision, the planning of a measure is not restarted."""


class Scheduler:
    """Decides the next steps of A dancers. Deterministic."""

    def __init__(
        self,
        patch: Patch,
        dancers: Dancers,
        motion: "GroupMotion",
        programmes: list[StepSource],
        subgroups: Subgroups,
        group: Int32,
        choosing: StepSelector | None = None,
    ) -> None:
        """`group` (A,) is shared with the show, which may change it between measures; `choosing` is the selector of the
        dancers' graph if it exists already."""
        self._patch = patch
        self._dancers = dancers
        self._motion = motion
        self._group = group
        self.programmes, self.subgroups = programmes, subgroups
        self.root_correction = RootCorrectionControl(patch, dancers, motion)
        self.targets = StepTargets(patch, dancers, motion, programmes, subgroups, group)
        self.order = self.targets.order
        self.speed: Float32 = self.targets.speed
        """Top speed of each agent [m/s], shape (A,)."""
        count = len(group)
        self._look_beats = LOOK_BEATS + MORE_LOOK_BEATS * min(max((count - FEW) / (CROWD - FEW), 0.0), 1.0)
        self.choices = StepChoices(count)
        self._planning = MeasurePlan(patch, dancers, motion, self.targets, self.choices, group)
        self.set_graph(dancers.graph, choosing or StepSelector.of(dancers.graph))
        self.last_target: Float64 | None = None
        """Targets of the last decision, within the steps' reach [m], (A, 2); None before the first decision."""
        self.last_wish: Float64 | None = None
        """The same before they were limited: the agents as steering predicts them [m], (A, 2)."""
        self.last_heading = np.zeros(count)
        """Target headings of the last decision [rad], shape (A,)."""
        self.detours = 0
        """Number of decisions in which a dancer could not dance the wanted step at once, since the start."""
        self.dead_ends = 0
        """Number of decisions in which a dancer had no next measure and repeated the present one, since the start."""

    def set_graph(self, graph: MotionGraph, choosing: StepSelector) -> None:
        """Switch to this graph. Called while no next measure is decided."""
        self.choosing = choosing
        self._planning.set_graph(graph, choosing)
        self.targets.set_graph(graph, choosing)
        self.step_costs = self.targets.step_costs

    def apply_patch(self, fresh: "Scheduler") -> None:
        """Apply the groups' programmes of another patch. Called while no next measure is decided."""
        update_programs(self.programmes, fresh.programmes, fresh._patch)
        self.targets.reorder()

    def edited_values(self, event: ControlEvent) -> dict[int, Any]:
        """Return the sequences set live, by group and of subgroups, see `EditablePart`."""
        values: dict[int, Any] = {index: one.live_sequence or None for index, one in enumerate(self.programmes)}
        return {**values, SUBGROUPS: self.subgroups.sequences}

    def restore_values(self, values: Mapping[int, Any]) -> None:
        """See `EditablePart`."""
        for index, wanted in values.items():
            if index == SUBGROUPS:
                self.subgroups.restore_sequences(wanted)
            elif wanted is None:
                self.programmes[index].release()
            else:
                self.programmes[index].set_sequence(list(wanted))

    def step_reach(self) -> Float64:
        """Return the reach in one measure of the group's farthest step, for each dancer [m], shape (A,)."""
        return self.targets.step_reach()

    def set_speed(self, measure: int, timeline: Timeline) -> None:
        """Set the agents' top speeds to what the group's steps and the correction can follow."""
        self._planning.set_seconds(timeline.beats_per_measure * 60.0 / timeline.tempo)
        self.targets.set_speed(measure, timeline)

    @property
    def at_rest(self) -> bool:
        """Whether no measure is partly planned."""
        return not self._planning.pieces

    # -- the planning of one measure -----------------------------------------------------------------------------

    def work(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Do this tick's share of the planning for the measure after `span`."""
        if self._dancers.decided:
            return
        left = span.end - timeline.beat_at(time)
        # in a measure that a tap has stretched, the blend begins more than a beat before the end
        blends = span.fraction(timeline.beat_at(time + TICK)) >= 1.0 - self._dancers.graph.window
        if left <= DECIDE_BEATS or blends:
            self.decide(span, timeline, time)
            return
        if self.at_rest:
            if left > max(self._look_beats, DECIDE_BEATS + 2.0 * TICK) or self._planning.begun:
                return
            self._planning.begin(span, timeline, time)
            return
        ticks = math.ceil((left - DECIDE_BEATS) * 60.0 / timeline.tempo / TICK)
        self._planning.pieces.run_share(ticks)

    def replan(self, span: MeasureSpan, timeline: Timeline, time: float) -> bool:
        """Drop the plan of the measure after `span`, so that it is planned again. Returns False if it is too late."""
        if self._dancers.decided:
            return False
        if not self._planning.begun:
            return True
        if (span.end - timeline.beat_at(time) - DECIDE_BEATS) * 60.0 / timeline.tempo < MIN_REPLAN_TICKS * TICK:
            return False
        self._planning.cancel()
        for programme in self.programmes:
            programme.undo(span.number + 1)
        self.subgroups.undo(span.number + 1)
        return True

    def drop_plan(self) -> None:
        """Drop a plan that will not be finished. Decisions stay."""
        self._planning.drop()

    # -- the decision --------------------------------------------------------------------------------------------

    def decide(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Decide the next measure of all dancers now, after finishing the planning."""
        if not self._planning.begun:
            self._planning.begin(span, timeline, time)
        self._planning.finish(span.number + 1)
        self._apply_choices()
        self._planning.clear()
        self.last_target, self.last_heading = self.choices.target.copy(), self.targets.heading.copy()
        self.last_wish = self.choices.wish.copy()

    def _apply_choices(self) -> None:
        """Place the chosen measures where the present ones will end, and pass them to the root correction."""
        dancers, graph, choices = self._dancers, self._dancers.graph, self.choices
        coming, edge = dancers.coming, choices.edge[:, 0]
        hips, _, axes = dancers.present.ends_and_axes()  # current: the present measure may have been re-aimed
        coming.copy_from(self._planning.draft)
        coming.placement[:] = following_placement(axes, graph.edge_transform[np.maximum(edge, 0)])
        stuck = edge < 0
        if stuck.any():  # cannot happen in a pruned graph; such dancers repeat their measure
            self.dead_ends += int(stuck.sum())
            coming.placement[stuck] = axes[stuck]
        self.detours += int(
            np.count_nonzero((choices.step >= 0) & (graph.library.node_step[coming.node] != choices.step))
        )
        self.root_correction.accept_decision(hips, choices.target, choices.wish)

    def must_decide(self, span: MeasureSpan, beat: float) -> bool:
        """Whether the measure after `span` must be decided at `beat`, and is not."""
        return not self._dancers.decided and span.end - beat <= DECIDE_BEATS

    def decide_nearest(self, half: npt.NDArray[np.floating]) -> None:
        """Decide without a plan: the nearest measure that may follow; `half` (2,) [m]: half sizes of the stage."""
        begin = decide_nearest(self._dancers, half)
        end = self._dancers.coming.end_position()
        self.root_correction.accept_decision(begin, end, end)

    # -- report --------------------------------------------------------------------------------------------------

    def tempo_report(self, bpm: float) -> list[dict[str, Any]]:
        """Return the recorded steps that are danced outside the limits of their tempo at `bpm`."""
        return tempo_report(self.choosing, self._dancers.node[self._motion.present], bpm)

    def reachability_report(self) -> dict[str, Any]:
        """Return the distances of each group's dancers from their targets, and recordings that would help (T075)."""
        return reachability_report(
            self.choices,
            self._group,
            tuple(section.name for section in self._patch.group),
            self._dancers.graph.library.steps,
            self._motion.present,
        )
