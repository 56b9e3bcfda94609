"""Finder of the unconnected pair of measures that could most easily be joined (T034, T135, T136)."""

import math
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64, Int64
from live.graph.build.metric import WINDOW_SAMPLES
from live.graph.build.transitions import all_pairs, clouds, transition_windows
from live.graph.motion_graph import MotionGraph
from live.graph.step_library import window_samples
from live.graph.structure_rules import initial_side, plain_pose

_ROWS: Final = 512
"""Nodes compared with all others at once."""
_RULE_COST: Final = 1e3
"""Cost of a broken structure rule: more than any distance [m]."""


class NearestPair:
    """Compares ends and beginnings of a graph's nodes; results are cached."""

    def __init__(self, graph: MotionGraph) -> None:
        self._graph = graph
        library = graph.library
        clips = [library.clips[clip] for clip in library.node_clip]
        self._end = np.array([plain_pose(clip.end_pose) for clip in clips])
        self._begin = np.array([plain_pose(clip.begin_pose) for clip in clips])
        self._side = np.array([initial_side(clip) for clip in clips])
        self._transfers = np.array([clip.weight_transfer for clip in clips])
        self._clouds: tuple[Float64, Float64] | None = None
        self._known: dict[bytes, tuple[int, int]] = {}
        self.distance: dict[tuple[int, int], float] = {}
        """Distances of the pairs found [m] (K002)."""

    def find(self, last: Bool, first: Bool) -> tuple[int, int]:
        """Return the pair of nodes (N,) that end and begin which breaks the fewest rules, and of those the nearest."""
        key = np.packbits([last, first]).tobytes()
        if key not in self._known:
            self._known[key] = self._search(np.flatnonzero(last), np.flatnonzero(first))
        return self._known[key]

    def poses_clash(self, u: int, v: int) -> bool:
        """Whether u ends in another pose than that in which v begins (T136)."""
        return bool(self._clashes(np.array([u]), np.array([v]))[0, 0])

    def repeats(self, u: int, v: int) -> bool:
        """Whether v repeats u on the same side although the weight is on the other foot (T135)."""
        return bool(self._repeats(np.array([u]), np.array([v]))[0, 0])

    def _search(self, last: Int64, first: Int64) -> tuple[int, int]:
        if self._clouds is None:
            self._clouds = transition_windows(self._graph.library, self._graph.window)
        ends, starts = self._clouds
        best, pair, nearest = math.inf, (int(last[0]), int(first[0])), math.inf
        for begin in range(0, len(last), _ROWS):
            rows = last[begin : begin + _ROWS]
            distance = all_pairs(ends[rows], starts[first], self._graph.rule.metric).distance
            worth = distance + _RULE_COST * self._clashes(rows, first) + _RULE_COST * self._repeats(rows, first)
            u, v = np.unravel_index(np.argmin(worth), worth.shape)
            if worth[u, v] < best:
                best, pair, nearest = float(worth[u, v]), (int(rows[u]), int(first[v])), float(distance[u, v])
        self.distance[pair] = nearest
        return pair

    def _clashes(self, u: Int64, v: Int64) -> Bool:
        end, begin = self._end[u][:, None], self._begin[v][None]
        return np.asarray((end != begin) & (end != "") & (begin != ""))

    def _repeats(self, u: Int64, v: Int64) -> Bool:
        step = self._graph.library.node_step
        same = (step[u][:, None] == step[v][None]) & (self._side[u][:, None] == self._side[v][None])
        return np.asarray(same & self._transfers[u][:, None] & self._transfers[v][None])


def joint_gaps(graph: MotionGraph, u: int, v: int) -> Float64:
    """Return how far apart each joint is at the join of the nodes u and v [m], after the best alignment, shape (J,)."""
    library, window, metric = graph.library, graph.window, graph.rule.metric
    length = (library.node_last - library.node_first) * window
    end = window_samples((library.node_last - length)[[u]], library.node_last[[u]], WINDOW_SAMPLES)
    start = window_samples((library.node_first - length)[[v]], library.node_first[[v]], WINDOW_SAMPLES)
    first = clouds(library, end)
    second = clouds(library, np.maximum(start, library.node_lead[[v]][:, None]))
    near = all_pairs(first, second, metric)
    yaw, shift = float(near.yaw[0, 0]), near.shift[0, 0]
    floor = (second[0, ..., 0] + 1j * second[0, ..., 2]) * np.exp(-1j * yaw) + complex(*shift)
    there = np.stack([floor.real, second[0, ..., 1], floor.imag], axis=-1)
    squared = ((first[0] - there) ** 2).sum(axis=-1)
    return np.asarray(np.sqrt(metric.window @ squared), np.float64)
