"""Joins: every pair of measures that may be danced one after the other, before dead ends are pruned (T031-T036)."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.build.blend_feasibility import blendable
from live.graph.build.flat import FlatClouds
from live.graph.build.nearest_pairs import near_pairs
from live.graph.build.transition import clouds
from live.graph.build.weights import Metric
from live.graph.step_library import StepLibrary, window_samples
from live.graph.transition_rules import StructureCodes, structure_codes

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
Bool = npt.NDArray[np.bool_]

_NODES: Final = 1024
"""Nodes whose clouds are posed at a time."""


@dataclass(frozen=True, slots=True)
class JoinRule:
    """What makes a join, and an edge of it."""

    window: float = 0.1875
    """Length of a transition as a share of the measure (T036)."""
    threshold: float = 0.16
    """Largest distance of the aligned clouds [m] (T034)."""
    metric: Metric = field(default_factory=Metric.of)
    prune: bool = True
    """Whether dead ends are left out of the graph (T037); the joins hold them anyway."""


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
        return self.chosen(alive[self.source] & alive[self.target])

    def chosen(self, kept: Bool) -> "Joins":
        """Those that are `kept` (E,)."""
        return Joins(self.source[kept], self.target[kept], self.cost[kept], self.transform[kept])


@dataclass(frozen=True, slots=True, eq=False)
class Boundaries:
    """The clouds at both ends of N nodes, kept so that what comes later can be compared with them."""

    ends: FlatClouds
    """Of the last `window` of each measure."""
    starts: FlatClouds
    """Of the `window` before each measure."""

    @classmethod
    def of(cls, library: StepLibrary, rule: JoinRule) -> "Boundaries":
        """Of all nodes of a library."""
        return cls(window_clouds(library, library.node_last, rule), window_clouds(library, library.node_first, rule))

    def joined(self, other: "Boundaries") -> "Boundaries":
        """Of this one's nodes, then the other's."""
        return Boundaries(FlatClouds.joined([self.ends, other.ends]), FlatClouds.joined([self.starts, other.starts]))


def find_joins(library: StepLibrary, boundaries: Boundaries, rule: JoinRule) -> Joins:
    """All joins of a library; within a step of several measures each one leads to the next alone (T039)."""
    everything = np.arange(library.node_count)
    codes = structure_codes(library)
    inner = _inner(library, everything)
    return _merged(_between(library, boundaries, codes, rule, everything, everything), inner, library.node_count)


def joins_with(library: StepLibrary, boundaries: Boundaries, joins: Joins, old: int, rule: JoinRule) -> Joins:
    """The joins of a library whose first `old` nodes have `joins`: as `find_joins` finds them.

    Only pairs that hold a new node are compared: the metric is asked 2N times for each new one, not N² times in all.
    """
    before, new = np.arange(old), np.arange(old, library.node_count)
    codes = structure_codes(library)
    more = _inner(library, new)
    for first, second in ((before, new), (new, np.arange(library.node_count))):
        more = _merged(more, _between(library, boundaries, codes, rule, first, second), library.node_count)
    return _merged(joins, more, library.node_count)


def _inner(library: StepLibrary, nodes: Int64) -> Joins:
    """The measures of one clip are neighbours in the library."""
    source = nodes[library.node_measure[nodes] < library.node_measures[nodes] - 1].astype(np.int32)
    count = len(source)
    return Joins(source, source + np.int32(1), np.zeros(count), np.zeros((count, 3)))


def _between(
    library: StepLibrary, boundaries: Boundaries, codes: StructureCodes, rule: JoinRule, first: Int64, second: Int64
) -> Joins:
    """Joins from the nodes `first` that end a step to the nodes `second` that begin one; both are ranges."""
    leaves = first[library.node_measure[first] == library.node_measures[first] - 1]
    enters = second[library.node_measure[second] == 0]
    pairs = near_pairs(
        boundaries.ends.chosen(leaves),
        boundaries.starts.chosen(enters),
        rule.threshold,
        (codes.leaving[leaves], codes.entering[enters]),
    )
    source, target = leaves[pairs.row].astype(np.int32), enters[pairs.column].astype(np.int32)
    good = blendable(library, rule.window, source, target, pairs.motion[:, 2])
    return Joins(source[good], target[good], pairs.distance[good], pairs.motion[good])


def window_clouds(library: StepLibrary, line: Float64, rule: JoinRule) -> FlatClouds:
    """Clouds of the window before the samples `line` (N,), some nodes at a time."""
    parts = []
    for begin in range(0, library.node_count, _NODES):
        own = slice(begin, begin + _NODES)
        length = (library.node_last[own] - library.node_first[own]) * rule.window
        samples = window_samples(line[own] - length, line[own], len(rule.metric.window))
        samples = np.maximum(samples, library.node_lead[own, None])
        parts.append(FlatClouds.of(clouds(library, samples), rule.metric))
    return parts[0] if len(parts) == 1 else FlatClouds.joined(parts)


def _merged(many: Joins, few: Joins, nodes: int) -> Joins:
    """Both, sorted; `nodes` is how many there are in all."""
    if not len(few.source):
        return many
    key, more = (joins.source.astype(np.int64) * nodes + joins.target for joins in (many, few))
    order = np.argsort(more)
    place = np.searchsorted(key, more[order])
    arrays = ((getattr(many, name), getattr(few, name)[order]) for name in Joins.__slots__)
    return Joins(*(np.insert(old, place, new, axis=0) for old, new in arrays))
