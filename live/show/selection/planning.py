"""Plan of all dancers' next measure, computed in small pieces spread over ticks.

The pieces simulate a copy of the agents ahead, determine the wanted steps, positions and headings, search the motion
graph for some dancers at a time, and draft the chosen measures.
"""

import math
from functools import partial

import numpy as np
import numpy.typing as npt

from live.agents.prediction import LookAhead
from live.clock.timeline import Timeline
from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import Choosing
from live.show.background_work import Piece, Pieces
from live.show.dancers.dancers import Dancers
from live.show.dancers.measure_state import Danced
from live.show.group.group_motion import GroupMotion
from live.show.measure_span import MeasureSpan
from live.show.patch.background_check import Drafting
from live.show.patch.patch import Patch
from live.show.selection.choices import Choices
from live.show.selection.step_search import AT_A_TIME, Searching
from live.show.selection.step_targets import Aims

Int32 = npt.NDArray[np.int32]


class Planning:
    """The plan of A dancers for one measure. Call `begin`, run its `pieces`, then `finish` and `forget`."""

    def __init__(
        self, patch: Patch, dancers: Dancers, motion: GroupMotion, aims: Aims, choices: Choices, group: Int32
    ) -> None:
        """`take_graph` must be called before anything else."""
        self._dancers, self._motion, self._group = dancers, motion, group
        self._aims, self._choices = aims, choices
        self._drafting = Drafting(dancers, choices, aims)
        self._searching = Searching(patch, dancers, motion, aims, choices)
        self.pieces = Pieces()
        """The remaining pieces."""
        self._looked = False  # whether headings have been advanced

    def take_graph(self, graph: MotionGraph, choosing: Choosing) -> None:
        """Switch to this graph. Called while no next measure is decided."""
        self._drafting.take_graph(graph, choosing)
        self._searching.take_graph(graph, choosing)

    def set_seconds(self, seconds: float) -> None:
        """Set the duration of a measure [s]."""
        self._searching.seconds = seconds

    @property
    def draft(self) -> Danced:
        """The draft so far."""
        return self._drafting.draft

    @property
    def begun(self) -> bool:
        """Whether a plan has begun or is complete."""
        return bool(self.pieces) or self._searching.asked

    def begin(self, span: MeasureSpan, timeline: Timeline, time: float) -> None:
        """Begin to plan the measure after `span`."""
        left = max(0.0, span.end - timeline.beat_at(time))
        beat = 60.0 / timeline.tempo
        seconds = (left + timeline.beats_per_measure) * beat
        # a ripple has many delays; rounded to quarters of a beat to limit the number of predictions
        late = np.round(4.0 * self._dancers.variation.late * timeline.beats_per_measure) / 4.0
        self._motion.look(time, seconds, self._dancers.present.end_heading(), late)
        steps = math.ceil((seconds + float(late.max()) * beat) / LookAhead.STEP) + len(np.unique(late))
        self.pieces.begin(self._planned(steps, span.number + 1))
        self._looked = False

    def _planned(self, steps: int, measure: int) -> list[Piece]:
        """Return the pieces of the planning of `measure`, with `steps` coarse steps of look-ahead.

        Their weights estimate their time in about hundredths of a millisecond: a constant and a part per dancer.
        """
        count, variation, search = len(self._group), self._dancers.variation, self._searching
        rows = [slice(row, min(row + AT_A_TIME, count)) for row in range(0, count, AT_A_TIME)]
        return [
            *[(3 + 0.055 * count, partial(self._motion.work, 1))] * steps,
            (32 + 0.2 * count, self._look),
            *[
                (45 + 0.04 * count, partial(self._aims.ask, index, measure, self._choices))
                for index in self._aims.order
            ],
            (32 + 0.15 * count, search.limit),
            *[(5 + 0.65 * (some.stop - some.start), partial(search.choose, some)) for some in rows],
            (2, search.lead),
            *[(45, partial(search.follow, slice(row, row + AT_A_TIME))) for row in self._pairs_by_pieces()],
            (5, search.catch_up),
            (40 + 0.05 * count, partial(self._drafting.vary, measure)),
            (22 + 0.03 * count, self._mix),
            (22 + 0.04 * count, self._turn),
            (15, partial(variation.drift.foresee, measure + 3)),
        ]

    def _pairs_by_pieces(self) -> range:
        """Return the first pair of each piece in which followers choose."""
        return range(0, len(self._motion.partners.leader), AT_A_TIME)

    def _look(self) -> None:
        self._motion.work(1 << 20)
        self._aims.look(self._choices)
        self._looked = True

    def _mix(self) -> None:
        self._drafting.mix(self._searching.axes, self._searching.on_support)

    def _turn(self) -> None:
        self._drafting.turn(self._searching.axes)

    def give_up(self) -> None:
        """Drop the plan and undo its headings, so that the measure can be planned again."""
        self.drop()
        if self._looked:
            self._aims.headings.take_back()

    def drop(self) -> None:
        """Drop the plan without undoing its headings."""
        self.pieces.clear()
        self._searching.forget()

    def finish(self, measure: int) -> None:
        """Run the remaining pieces of the planning of `measure`, and repeat those for replaced present measures."""
        self.pieces.finish()
        if self._searching.catch_up():
            self._drafting.vary(measure)
            self._mix()
            self._turn()

    def forget(self) -> None:
        """Clear the plan after its measure is decided."""
        self._searching.forget()
