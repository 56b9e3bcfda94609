"""Draft of each dancer's next measure: variations, mixture of two takes, and turns of the chosen steps."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Float64, Int32
from live.base.motion_parameters import FACE_AVERAGE
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import own_end, turn_vectors, wrap_angle
from live.graph.select.selector import StepSelector
from live.graph.takes import NO_TAKE
from live.show.dancers.measure_state import MeasureState
from live.show.selection.choices import StepChoices

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.selection.step_targets import StepTargets


SHARE_REFINEMENT: Final = 0.125
"""Half the spacing of the shares of T069: a chosen share is refined within this range."""
MIN_END_DISTANCE: Final = 0.1
"""The share is not refined for the end position if two takes end nearer to each other than this [m]."""
MAX_END_SHIFT: Final = 0.1
"""A mixture drawn for variety moves the end of a measure by at most this distance [m]."""


class MeasureDraft:
    """Works out the next measure of every dancer: call `vary`, `mix` and `turn`, in this order."""

    def __init__(self, dancers: "Dancers", choices: StepChoices, aims: "StepTargets") -> None:
        """`set_graph` must be called first."""
        self._dancers, self._choices, self._aims = dancers, choices, aims
        self.draft = MeasureState(dancers.graph, len(dancers.node))

    def set_graph(self, graph: MotionGraph, choosing: StepSelector) -> None:
        """Switch to this graph; no dancer's next measure is decided then."""
        self.draft.graph = graph
        self._choosing = choosing

    def vary(self, measure: int) -> None:
        """Set the nodes of the chosen steps and draw each dancer's variation of them."""
        dancers, choices, draft = self._dancers, self._choices, self.draft
        graph, edge = dancers.graph, choices.edge
        choices.node[:] = np.where(edge < 0, -1, graph.edge_target[np.maximum(edge, 0)])
        draft.node[:] = np.where(edge[:, 0] < 0, dancers.node, choices.node[:, 0])
        draft.decided = True
        dancers.variation.draw(measure, draft)

    def mix(self, axes: Float64, support: Float64) -> None:
        """Set the mixtures that the choice needs, else those drawn for variety.

        `axes` and `support` are those with which the step was selected.
        """
        choices, draft, graph = self._choices, self.draft, self._dancers.graph
        candidates = self._choosing.candidates
        row = np.maximum(choices.candidate[:, 0], 0)
        needed = (choices.candidate[:, 0] >= 0) & (candidates.take[row] != NO_TAKE)
        if draft.take_share[0].any():
            end, _ = own_end(graph, draft.node, draft.take, np.ones(len(draft.node)))
            stray = np.hypot(*(end - graph.node_end[draft.node]).T)
            most = MAX_END_SHIFT / np.maximum(stray, 1e-9)
            draft.take_share[0] = np.minimum(draft.take_share[0], most)
        draft.take[needed] = candidates.take[row[needed]]
        draft.take_share[0, needed] = self._refined(row, axes, support)[needed]
        # arms follow one clip, the nearer one, so that they are not blurred; or the other by the share that was drawn
        drawn = draft.take_share[1, needed]
        draft.take_share[1, needed] = np.where(draft.take_share[0, needed] > 0.5, 1.0 - drawn, drawn)

    def turn(self, axes: Float64) -> None:
        """Set each dancer's turn beyond the measure's own; headings stay as they are until the decision."""
        draft, graph = self.draft, self._dancers.graph
        yaw = axes[:, 2] + graph.edge_transform[np.maximum(self._choices.edge[:, 0], 0), 2]
        draft.clear_correction()
        most = self._choosing.max_turns[draft.node, 0]
        draft.correction[:, 2] = np.clip(wrap_angle(self._aims.heading - yaw - self._local_heading(draft)), -most, most)

    def _refined(self, row: Int32, axes: Float64, support: Float64) -> Float64:
        """Shares (A,) with which candidates `row` (A,) end nearest to their targets, within half a step of T069."""
        candidates, choices, graph = self._choosing.candidates, self._choices, self._dancers.graph
        yaw = axes[:, 2] + graph.edge_transform[np.maximum(choices.edge[:, 0], 0), 2] + support * choices.end[:, 2]
        share = candidates.share[row]
        way = candidates.end[row] - graph.node_end[candidates.node[row]]
        way = turn_vectors(way / np.maximum(share, 0.25)[:, None], yaw)  # from the clip's end to the other take's
        off = choices.target - choices.end[:, :2]
        more = (off * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), MIN_END_DISTANCE**2)
        return np.asarray(share + np.clip(more, -SHARE_REFINEMENT, SHARE_REFINEMENT))

    def _local_heading(self, danced: MeasureState) -> Float64:
        """Heading at the end of each measure, or its average (T122), in the clip's own axes, (A,) [rad]."""
        own = danced.own_end()[1]
        average = self._dancers.variation[FACE_AVERAGE]
        return np.asarray(own + average * wrap_angle(self._dancers.graph.node_facing_mean[danced.node] - own))
