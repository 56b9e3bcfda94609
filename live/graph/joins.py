"""Joins: every pair of measures that may be danced one after the other, before dead ends are pruned (T031-T036)."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.library import StepLibrary, window_samples
from live.graph.metric.flat import FlatClouds
from live.graph.metric.near import Pairs, near_pairs
from live.graph.metric.weights import Metric
from live.graph.structure import structure_codes
from live.graph.transition import clouds

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

_NODES: Final = 1024
"""Nodes whose clouds are posed at a time."""


@dataclass(frozen=True, slots=True)
class JoinRule:
    """What makes a join."""

    window: float = 0.1875
    """Length of a transition as a share of the measure (T036)."""
    threshold: float = 0.16
    """Largest distance of the aligned clouds [m] (T034)."""
    metric: Metric = field(default_factory=Metric.of)


@dataclass(frozen=True, slots=True, eq=False)
class Joins:
    """E ordered pairs of nodes, sorted by source, then target."""

    source: Int32
    target: Int32
    cost: Float64
    """Distance of the aligned clouds [m], shape (E,); 0 within a step."""
    transform: Float64
    """x, z [m], yaw [rad] that place the target's clip in the axes of the source's (K001), shape (E, 3)."""

    def among(self, alive: Bool) -> "Joins":
        """Those between nodes that are `alive` (N,)."""
        if alive.all():
            return self
        kept = alive[self.source] & alive[self.target]
        return Joins(self.source[kept], self.target[kept], self.cost[kept], self.transform[kept])


def find_joins(library: StepLibrary, rule: JoinRule) -> Joins:
    """All joins of a library; within a step of several measures each one leads to the next alone (T039)."""
    everything = np.arange(library.node_count)
    return _merged(library, [_inner(library, everything), _between(library, rule, everything, everything)])


def joins_with(library: StepLibrary, joins: Joins, old: int, rule: JoinRule) -> Joins:
    """The joins of a library whose first `old` nodes have `joins`: as `find_joins` finds them.

    Only pairs that hold a new node are compared: the metric is asked 2N times for each new one, not N² times in all.
    """
    before, new = np.arange(old), np.arange(old, library.node_count)
    parts = [
        joins,
        _inner(library, new),
        _between(library, rule, before, new),
        _between(library, rule, new, np.arange(library.node_count)),
    ]
    return _merged(library, parts)


def _inner(library: StepLibrary, nodes: npt.NDArray[np.int64]) -> Joins:
    """The measures of one clip are neighbours in the library."""
    source = nodes[library.node_measure[nodes] < library.node_measures[nodes] - 1].astype(np.int32)
    count = len(source)
    return Joins(source, source + np.int32(1), np.zeros(count), np.zeros((count, 3)))


def _between(
    library: StepLibrary, rule: JoinRule, first: npt.NDArray[np.int64], second: npt.NDArray[np.int64]
) -> Joins:
    """Joins from the nodes `first` that end a step to the nodes `second` that begin one."""
    leaves = first[library.node_measure[first] == library.node_measures[first] - 1]
    enters = second[library.node_measure[second] == 0]
    codes = structure_codes(library)
    pairs: Pairs = near_pairs(
        flat_ends(library, leaves, rule),
        flat_starts(library, enters, rule),
        rule.threshold,
        (codes.leaving[leaves], codes.entering[enters]),
    )
    source, target = leaves[pairs.row].astype(np.int32), enters[pairs.column].astype(np.int32)
    return Joins(source, target, pairs.distance, pairs.motion)


def flat_ends(library: StepLibrary, nodes: npt.NDArray[np.int64], rule: JoinRule) -> FlatClouds:
    """Clouds of the last `window` of the measures `nodes`."""
    return _flat(library, nodes, library.node_last, rule)


def flat_starts(library: StepLibrary, nodes: npt.NDArray[np.int64], rule: JoinRule) -> FlatClouds:
    """Clouds of the `window` before the measures `nodes`."""
    return _flat(library, nodes, library.node_first, rule)


def _flat(library: StepLibrary, nodes: npt.NDArray[np.int64], line: Float64, rule: JoinRule) -> FlatClouds:
    """Clouds of the window before the samples `line` (N,), some nodes at a time."""
    parts = []
    for begin in range(0, max(len(nodes), 1), _NODES):
        own = nodes[begin : begin + _NODES]
        length = (library.node_last[own] - library.node_first[own]) * rule.window
        samples = window_samples(line[own] - length, line[own], len(rule.metric.window))
        samples = np.maximum(samples, library.node_lead[own, None])
        parts.append(FlatClouds.of(clouds(library, samples), rule.metric))
    return parts[0] if len(parts) == 1 else FlatClouds.joined(parts)


def _merged(library: StepLibrary, parts: list[Joins]) -> Joins:
    source, target, cost, transform = (
        np.concatenate([getattr(part, name) for part in parts]) for name in Joins.__slots__
    )
    order = np.argsort(source.astype(np.int64) * library.node_count + target, kind="stable")
    return Joins(source[order], target[order], cost[order], transform[order])
