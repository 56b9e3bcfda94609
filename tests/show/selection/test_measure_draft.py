"""Measure draft: turns stay within each measure's limit, and mixtures end near their clips."""

import numpy as np

from live.clock.ticks import TICK
from live.graph.select.candidates import own_end
from live.show.selection.measure_draft import MAX_END_SHIFT
from tests.show.made_show import made_show


def run_drafts(seconds=6.0):
    """The show and its draft after each measure line."""
    show = made_show()
    for tick in range(1, int(seconds / TICK)):
        if show.tick(tick * TICK):
            yield show, show.scheduler._planning.draft


def test_turns_and_mixtures_stay_within_limits():
    measures = 0
    for show, draft in run_drafts():
        graph = show.dancers.graph
        assert (np.abs(draft.correction[:, 2]) <= show.scheduler.choosing.max_turns[draft.node, 0] + 1e-12).all()
        assert not draft.correction[:, :2].any()
        assert ((draft.take_share >= 0.0) & (draft.take_share <= 1.0)).all()
        needed = show.scheduler.choices.candidate[:, 0] >= 0
        end, _ = own_end(graph, draft.node, draft.take, np.ones(len(draft.node)))
        stray = np.hypot(*(end - graph.node_end[draft.node]).T) * draft.take_share[0]
        assert (stray[~needed] <= MAX_END_SHIFT + 1e-9).all()
        measures += 1
    assert measures >= 2
