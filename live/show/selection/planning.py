"""Plan of all dancers' next measure, computed in small pieces spread over ticks.

The pieces simulate a copy of the agents ahead, determine the wanted steps, positions and headings, search the motion
graph for some dancers at a time, and draft the chosen measures.
"""

import math
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from live.agents.prediction import CrowdPrediction
from live.base.arrays import Int32
from live.clock.timeline import Timeline
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.show.background_work import Task, TaskQueue
from live.show.dancers.measure_state import MeasureState
from live.show.patch.patch import Patch
from live.show.selection.choices import StepChoices
from live.show.selection.measure_draft import MeasureDraft
from live.show.selection.step_search import StepSearch, batch_size, batches
from live.show.stages.measure_span import MeasureSpan

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.step_targets import StepTargets


PAIRS_PER_PIECE: Final = 48
"""Most pairs whose followers choose in one piece."""


class MeasurePlan:
    """The plan of A dancers for one measure. Call `begin`, run its `pieces`, then `finish` and `clear`."""

    def __init__(
        self,
        patch: Patch,
        dancers: "Dancers",
        motion: "GroupMotion",
        targets: "StepTargets",
        choices: StepChoices,
        group: Int32,
    ) -> None:
        """`set_graph` must be called before anything else."""
        self._dancers, self._motion, self._group = dancers, motion, group
        self._targets, self._choices = targets, choices
        self._drafter = MeasureDraft(dancers, choices, targets)
        self._search = StepSearch(patch, dancers, motion, targets, choices)
        self.pieces = TaskQueue()
        """The remaining pieces."""
        self._looked = False  # whether headings have been advanced

    def set_graph(self, graph: MotionGraph, choosing: StepSelector) -> None:
        """Switch to this graph. Called while no next measure is decided."""
        self._drafter.set_graph(graph, choosing)
        self._search.set_graph(graph, choosing)

    def set_seconds(self, seconds: float) -> None:
        """Set the duration of a measure [s]."""
        self._search.seconds = seconds

    @property
    def draft(self) -> MeasureState:
        """The draft so far."""
        return self._drafter.draft

    @property
    def begun(self) -> bool:
        """Whether a plan has begun or is complete."""
        return bool(self.pieces) or self._search.prepared

    def begin(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Begin to plan the measure after `span`."""
        left = max(0.0, span.end - timeline.beat_at(time))
        beat = 60.0 / timeline.tempo
        seconds = (left + timeline.beats_per_measure) * beat
        # a ripple has many delays; rounded to quarters of a beat to limit the number of predictions
        late = np.round(4.0 * self._dancers.variation.delays * timeline.beats_per_measure) / 4.0
        self._motion.begin_lookahead(time, seconds, self._dancers.present.end_heading(), late)
        steps = math.ceil((seconds + float(late.max()) * beat) / CrowdPrediction.STEP) + len(np.unique(late))
        self.pieces.extend(self._build_pieces(steps, span.number + 1))
        self._looked = False

    def _build_pieces(self, steps: int, measure: int) -> list[Task]:
        """Return the pieces of the planning of `measure`, with `steps` coarse steps of look-ahead.

        Their weights estimate their time in about hundredths of a millisecond: a constant and a part per dancer.
        """
        count, variation, search = len(self._group), self._dancers.variation, self._search
        rows = batches(count, batch_size(count))
        pairs = batches(len(self._motion.partners.leader), PAIRS_PER_PIECE)
        return [
            *[(3 + 0.055 * count, partial(self._motion.run_lookahead, 1))] * steps,
            (32 + 0.2 * count, self._set_wishes),
            *[
                (45 + 0.04 * count, partial(self._targets.set_wanted_step, index, measure, self._choices))
                for index in self._targets.assign(measure)
            ],
            (32 + 0.15 * count, search.prepare),
            *[(5 + 0.4 * (some.stop - some.start), partial(search.choose, some)) for some in rows],
            (1, self._turn_those_behind),
            (2, search.set_follower_targets),
            *[(45, partial(search.choose_followers, some)) for some in pairs],
            (5, search.choose_replaced),
            (40 + 0.05 * count, partial(self._drafter.vary, measure)),
            (22 + 0.03 * count, self._mix),
            (22 + 0.04 * count, self._turn),
            (15, partial(variation.drift.draw_knots, measure + 3)),
        ]

    def _turn_those_behind(self) -> None:
        """Insert the pieces in which those choose again who would not get where they should."""
        search = self._search
        self.pieces.insert(
            (10 + 2.5 * len(rows), partial(search.choose_turned, rows)) for rows in search.turned_batches()
        )

    def _set_wishes(self) -> None:
        self._motion.run_lookahead(1 << 20)
        self._targets.set_wishes(self._choices)
        self._looked = True

    def _mix(self) -> None:
        self._drafter.mix(self._search.axes, self._search.on_support)

    def _turn(self) -> None:
        self._drafter.turn(self._search.axes)

    def cancel(self) -> None:
        """Drop the plan and undo its headings, so that the measure can be planned again."""
        self.drop()
        if self._looked:
            self._targets.headings.undo()

    def drop(self) -> None:
        """Drop the plan without undoing its headings."""
        self.pieces.clear()
        self._search.clear()

    def finish(self, measure: int) -> None:
        """Run the remaining pieces of the planning of `measure`, and repeat those for replaced present measures."""
        self.pieces.run_all()
        if self._search.choose_replaced():
            self._drafter.vary(measure)
            self._mix()
            self._turn()

    def clear(self) -> None:
        """Clear the plan after its measure is decided."""
        self._search.clear()
