"""Transitions: distances between measure ends and starts (T032-T034, K001-K003), joins (T031-T036), retiming (T140).

The distance is that of two point clouds of the skeleton over a window, after the rigid 2D motion of the second that
brings it nearest to the first. All pairs at once are one complex matrix product (K003): with the floor coordinates of a
centred cloud as complex numbers a = √w (x + iz), the best rotation is the argument of aᴴb and

D = |a|² + |b|² + |y_a|² + |y_b|² - 2 |aᴴb| - 2 y_a·y_b .

Retiming (T140): if a dancer lands slightly off the beat, the best place to leave a step is not exactly at its last
sample. Each end and beginning of a step may move by up to a share of a measure; the part between is played faster or
slower, so the dance keeps to the metre. A node has one end and one beginning for all its edges, because most of a
measure is danced before the next one is chosen.
"""

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Bool, Float64, Int32, Int64
from live.graph.build.blend_feasibility import Blends
from live.graph.build.components import strong_components
from live.graph.build.metric import WINDOW_SAMPLES, FlatClouds, Metric, joint_weights, window_weights
from live.graph.build.nearest_pairs import EdgeLimits, PairCodes, aligned, kept_edges, near_pairs
from live.graph.step_library import StepLibrary, travel_of, window_samples
from live.graph.structure_rules import StructureCodes, may_follow_between, structure_codes, variation_codes
from live.graph.takes import take_kinds
from live.motion.pose.pose_pipeline import ClipStore, PosePipeline
from live.motion.skeleton import SKELETON

__all__ = [
    "WINDOW_SAMPLES",
    "Transitions",
    "all_pairs",
    "clouds",
    "joint_weights",
    "transition_windows",
    "window_weights",
]


@dataclass(frozen=True, slots=True, eq=False)
class Transitions:
    """For every ordered pair of nodes (u, v): from the end of u to the start of v (N nodes)."""

    distance: Float64
    """Root of the weighted mean squared distance of the aligned clouds [m], shape (N, N)."""
    yaw: Float64
    """Rotation that brings v's axes into u's [rad], shape (N, N)."""
    shift: Float64
    """Translation that follows it (x, z) [m], shape (N, N, 2)."""


_POSED: Final = 1 << 14
"""Samples that are posed at a time."""


def clouds(library: StepLibrary, samples: Float64) -> Float64:
    """Return world positions of the joints at fractional samples (N, K) of the library, shape (N, K, J, 3) [m]."""
    return posed(library.store, samples)


def posed(store: ClipStore, samples: Float64) -> Float64:
    """Return world positions of the joints at fractional samples (N, K) of clips, shape (N, K, J, 3) [m]."""
    flat = samples.reshape(-1)
    position = np.empty((len(flat), SKELETON.joint_count, 3))
    pipeline = PosePipeline(min(_POSED, max(len(flat), 1)))
    for begin in range(0, len(flat), _POSED):
        part = flat[begin : begin + _POSED]
        pipeline.sample[0, : len(part)] = part
        position[begin : begin + len(part)] = pipeline.run(store)[0][: len(part)]
    return position.reshape(*samples.shape, SKELETON.joint_count, 3)


def transition_windows(library: StepLibrary, window: float) -> tuple[Float64, Float64]:
    """Return clouds of the last and of the lead-in `window` (share of the measure) of every node: two (N, K, J, 3)."""
    length = (library.node_last - library.node_first) * window
    end = window_samples(library.node_last - length, library.node_last, WINDOW_SAMPLES)
    start = window_samples(library.node_first - length, library.node_first, WINDOW_SAMPLES)
    start = np.maximum(start, library.node_lead[:, None])
    return clouds(library, end), clouds(library, start)


def all_pairs(first: Float64, second: Float64, metric: Metric | None = None) -> Transitions:
    """Return K003 for all pairs of clouds `first` (N, K, J, 3) and `second` (M, K, J, 3), in one matrix product.

    Allocates some ten arrays of (N, M); for large libraries with a threshold see `near_pairs`.
    """
    metric = Metric.of() if metric is None else metric
    a, b = FlatClouds.of(first, metric), FlatClouds.of(second, metric)
    product = a.floor.conj() @ b.floor.T
    squared = a.size[:, None] + b.size[None] - 2.0 * np.abs(product) - 2.0 * (a.height @ b.height.T)
    motion = aligned(product, a.centre[:, None], b.centre[None])
    return Transitions(np.sqrt(np.maximum(squared, 0.0)), motion[..., 2], motion[..., :2])


_NODES: Final = 1024
"""Nodes whose clouds are posed at a time."""


@dataclass(frozen=True, slots=True)
class JoinSettings:
    """Settings for joins and edges."""

    window: float = 0.1875
    """Length of a transition as a share of the measure (T036)."""
    threshold: float = 0.16
    """Largest distance of the aligned clouds [m] (T034)."""
    metric: Metric = field(default_factory=Metric.of)
    limits: EdgeLimits = field(default_factory=EdgeLimits)
    """How many edges a node keeps."""
    prune: bool = True
    """Whether dead ends are removed from the graph (T037); the joins keep them."""


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
        """Return the joins between nodes that are `alive` (N,)."""
        if alive.all():
            return self
        return self.select(alive[self.source] & alive[self.target])

    def select(self, kept: Bool) -> "Joins":
        """Return the joins that are `kept` (E,)."""
        return Joins(self.source[kept], self.target[kept], self.cost[kept], self.transform[kept])


@dataclass(frozen=True, slots=True, eq=False)
class Boundaries:
    """The clouds at both ends of N nodes, kept for comparison with nodes that are inserted later."""

    ends: FlatClouds
    """Clouds of the last `window` of each measure."""
    starts: FlatClouds
    """Clouds of the `window` before each measure."""

    @classmethod
    def of(cls, library: StepLibrary, rule: JoinSettings) -> "Boundaries":
        """Compute the clouds of all nodes of a library."""
        return cls(window_clouds(library, library.node_last, rule), window_clouds(library, library.node_first, rule))

    def joined(self, other: "Boundaries") -> "Boundaries":
        """Return the clouds of these nodes followed by those of `other`."""
        return Boundaries(FlatClouds.joined([self.ends, other.ends]), FlatClouds.joined([self.starts, other.starts]))


def find_joins(library: StepLibrary, boundaries: Boundaries, rule: JoinSettings) -> Joins:
    """Return the joins of a library that the rule's limits keep, and the links between them.

    Within a step of several measures each leads only to the next (T039), of its own clip or of another take. Variations
    (T142) have none: they are only mixed in.
    """
    everything = np.arange(library.node_count)
    search = _JoinSearch(library, boundaries, rule)
    joins = _united(search.between(everything, everything), _inner(library, everything), library.node_count)
    joins = _united(joins, search.between_takes(everything, everything), library.node_count)
    return search.linked(search.kept(joins))


def extend_joins(library: StepLibrary, boundaries: Boundaries, joins: Joins, old: int, rule: JoinSettings) -> Joins:
    """Return the joins of a library whose first `old` nodes have `joins`; the result is that of `find_joins`.

    Only pairs with a new node are compared: 2N distances per new node instead of N² in all.
    """
    before, new = np.arange(old), np.arange(old, library.node_count)
    search = _JoinSearch(library, boundaries, rule)
    joins = _united(joins, _inner(library, new), library.node_count)
    for first, second in ((before, new), (new, np.arange(library.node_count))):
        joins = _united(joins, search.between(first, second), library.node_count)
        joins = _united(joins, search.between_takes(first, second), library.node_count)
    return search.linked(search.kept(joins))


def reduce_joins(
    library: StepLibrary, boundaries: Boundaries, joins: Joins, leaving: Bool, rule: JoinSettings
) -> Joins:
    """Return `joins` without those that begin a step at a node that is `leaving` (N,), or enter its clip.

    A node that loses some has others that the limits left out before; they are searched again.
    """
    lost = leaving[joins.target] & (library.node_clip[joins.target] != library.node_clip[joins.source])
    lost |= leaving[joins.target] & (library.node_measure[joins.target] == 0)
    rows = np.unique(joins.source[lost]).astype(np.int64)
    search = _JoinSearch(library, boundaries, rule)
    joins = joins.select(~lost)
    for more in (search.between(rows, np.flatnonzero(~leaving)), search.between_takes(rows, np.flatnonzero(~leaving))):
        joins = _united(joins, more, library.node_count)
    return search.linked(search.kept(joins), leaving)


class _JoinSearch:
    """Search for joins between the steps of a library."""

    def __init__(self, library: StepLibrary, boundaries: Boundaries, rule: JoinSettings) -> None:
        self._library, self._boundaries, self._rule = library, boundaries, rule
        self._codes: StructureCodes = structure_codes(library)
        self._variation = variation_codes(library)
        itself = ~library.unjoined
        self._leaves = (library.node_measure == library.node_measures - 1) & itself
        self._enters = (library.node_measure == 0) & itself

    def between(
        self, first: Int64, second: Int64, label: Int32 | None = None, limits: EdgeLimits | None = None
    ) -> Joins:
        """Return joins from those of the nodes `first` that end a step to those of `second` that begin one.

        With a `label` (N,) they must differ in it, and the nearest of each label count instead of steps.
        """
        library, boundaries, rule = self._library, self._boundaries, self._rule
        leaves, enters = first[self._leaves[first]], second[self._enters[second]]
        codes = PairCodes(
            self._codes.leaving[leaves],
            self._codes.entering[enters],
            library.node_step[enters] if label is None else label[enters],
            self._variation[enters] if label is None else label[enters],
            None if label is None else (label[leaves], label[enters]),
        )
        pairs = near_pairs(
            boundaries.ends.select(leaves), boundaries.starts.select(enters), rule.threshold, codes,
            rule.limits if limits is None else limits, Blends.of(library, rule.window, leaves, enters),
        )  # fmt: skip
        source, target = leaves[pairs.row].astype(np.int32), enters[pairs.column].astype(np.int32)
        return Joins(source, target, pairs.distance, pairs.motion)

    def between_takes(self, first: Int64, second: Int64) -> Joins:
        """Return joins from those of the nodes `first` inside a step to the next measure of its other takes in
        `second`."""
        library, boundaries, rule = self._library, self._boundaries, self._rule
        kind = take_kinds(library)[library.node_clip]
        inside = library.node_measure < library.node_measures - 1
        leaves, enters = first[inside[first] & (kind[first] >= 0)], second[library.node_measure[second] > 0]
        size = int(library.node_measure.max(initial=0)) + 2
        place = (kind * size + library.node_measure).astype(np.int32)
        leaving, entering = np.full((len(leaves), 2), -1, np.int32), np.full((len(enters), 2), -1, np.int32)
        leaving[:, 0], entering[:, 0] = place[leaves] + 1, place[enters]
        entering[kind[enters] < 0, 0] = np.iinfo(np.int32).max  # a measure of a stream is nobody's take
        codes = PairCodes(
            leaving, entering, library.node_step[enters], self._variation[enters],
            (library.node_clip[leaves], library.node_clip[enters]),
        )  # fmt: skip
        pairs = near_pairs(
            boundaries.ends.select(leaves), boundaries.starts.select(enters), rule.threshold, codes, rule.limits,
            Blends.of(library, rule.window, leaves, enters),
        )  # fmt: skip
        source, target = leaves[pairs.row].astype(np.int32), enters[pairs.column].astype(np.int32)
        return Joins(source, target, pairs.distance, pairs.motion)

    def kept(self, joins: Joins) -> Joins:
        """Return those of some joins, of which none is missing that the limits keep."""
        library = self._library
        return joins.select(
            kept_edges(
                joins.source, joins.target, joins.cost, library.node_step, self._variation, library.node_count,
                self._rule.limits,
            )
        )  # fmt: skip

    def linked(self, joins: Joins, leaving: Bool | None = None) -> Joins:
        """Return joins with the links that the limits left out: the graph is connected as without limits (T037).

        The nearest join from each node to each other strongly connected component is added. So whatever leads from one
        component to another with all joins does so with these. `leaving` (N,): nodes that nothing is linked to.
        """
        library = self._library
        label = strong_components(library.node_count, joins.source, joins.target)
        inside = label == np.argmax(np.bincount(label))
        open_ = np.ones(library.node_count, np.bool_) if leaving is None else ~leaving
        for first, second in ((~inside, open_), (inside, open_ & ~inside)):
            links = self.between(np.flatnonzero(first), np.flatnonzero(second), label, _LINKS)
            joins = _united(joins, links, library.node_count)
        return joins


_LINKS: Final = EdgeLimits(per_node=1 << 30, per_variation=1, into=0)
"""One edge from a node to each component."""


def _inner(library: StepLibrary, nodes: Int64) -> Joins:
    """Return the joins within clips; the measures of one clip are neighbours in the library."""
    inside = (library.node_measure[nodes] < library.node_measures[nodes] - 1) & ~library.unjoined[nodes]
    source = nodes[inside].astype(np.int32)
    count = len(source)
    return Joins(source, source + np.int32(1), np.zeros(count), np.zeros((count, 3)))


def _united(many: Joins, few: Joins, nodes: int) -> Joins:
    """Return both, sorted, each pair once; `nodes` is the total number of nodes."""
    key, more = (joins.source.astype(np.int64) * nodes + joins.target for joins in (many, few))
    place = np.searchsorted(key, more)
    new = np.ones(len(more), np.bool_)
    there = place < len(key)
    new[there] = key[place[there]] != more[there]
    if not new.any():
        return many
    order = np.argsort(more[new])
    arrays = ((getattr(many, name), getattr(few, name)[new][order]) for name in Joins.__slots__)
    return Joins(*(np.insert(old, place[new][order], added, axis=0) for old, added in arrays))


def window_clouds(library: StepLibrary, line: Float64, rule: JoinSettings) -> FlatClouds:
    """Return clouds of the window before the samples `line` (N,), some nodes at a time."""
    parts = []
    for begin in range(0, library.node_count, _NODES):
        own = slice(begin, begin + _NODES)
        length = (library.node_last[own] - library.node_first[own]) * rule.window
        samples = window_samples(line[own] - length, line[own], len(rule.metric.window))
        samples = np.maximum(samples, library.node_lead[own, None])
        parts.append(FlatClouds.of(clouds(library, samples), rule.metric))
    return parts[0] if len(parts) == 1 else FlatClouds.joined(parts)


OFFSETS: Final = 5
"""Positions tried on each side, including the measure line."""
SWEEPS: Final = 2
_BLOCK: Final = 256


def retime_library(library: StepLibrary, rule: JoinSettings, interval: float) -> StepLibrary:
    """Move the ends and beginnings of a library's steps by up to `interval` (a share of the measure).

    In turn, each end moves to where it is nearest to the current beginnings, and each beginning likewise. The objective
    is the sum over all pairs of exp(-(distance / threshold)²), which never falls. Lines inside steps of several
    measures stay, and so does every line whose move gains nothing. ValueError for an interval outside [0, 0.25].
    """
    if not 0.0 <= interval <= 0.25:
        raise ValueError(f"interval around the measure line {interval}: a share of the measure from 0 to 0.25 expected")
    if interval == 0.0:
        return library
    shares = np.array(sorted(np.linspace(-interval, interval, OFFSETS), key=abs))  # the line itself wins ties
    leaves = np.flatnonzero(library.node_measure == library.node_measures - 1)
    enters = np.flatnonzero(library.node_measure == 0)
    ends, begins = (_clouds(library, nodes, line, rule, shares) for nodes, line in (
        (leaves, library.node_last), (enters, library.node_first)))  # fmt: skip
    out, into = np.zeros(len(leaves), np.int64), np.zeros(len(enters), np.int64)
    allowed = _Allowed(library, leaves, enters)
    for _ in range(SWEEPS):
        out = _offset_scores(ends, _select_offsets(begins, into), rule.threshold, allowed, turned=False).argmax(axis=0)
        into = _offset_scores(begins, _select_offsets(ends, out), rule.threshold, allowed, turned=True).argmax(axis=0)
    first, last = library.node_first.copy(), library.node_last.copy()
    last[leaves] = _shift_lines(library, leaves, library.node_last, shares[out])
    first[enters] = _shift_lines(library, enters, library.node_first, shares[into])
    return replace(library, node_first=first, node_last=last, node_travel=travel_of(library.clip_root, first, last))


class _Allowed:
    """Which of the first nodes may be followed by which of the second, in blocks."""

    def __init__(self, library: StepLibrary, first: Int64, second: Int64) -> None:
        self._library, self._first, self._second = library, first, second

    def block(self, part: slice, turned: bool) -> npt.NDArray[np.bool_]:
        """Return rows `part` of the table, or, if `turned`, of its transpose."""
        if turned:
            return may_follow_between(self._library, self._first, self._second[part]).T
        return may_follow_between(self._library, self._first[part], self._second)


def _shift_lines(library: StepLibrary, nodes: Int64, line: Float64, share: Float64) -> Float64:
    """Return the samples `line` of some nodes, moved by a share of the measure, within their clips."""
    ends = np.array([library.clips[clip].clip.sample_count - 1.0 for clip in library.node_clip[nodes]])
    size = library.node_last[nodes] - library.node_first[nodes]
    low = library.node_lead[nodes]
    return np.asarray(np.clip(line[nodes] + share * size, low, low + ends))


def _clouds(library: StepLibrary, nodes: Int64, line: Float64, rule: JoinSettings, shares: Float64) -> list[FlatClouds]:
    """Return clouds of the windows before the lines of some nodes, for every share by which they may be moved."""
    found = []
    for share in shares:
        moved = line.copy()
        moved[nodes] = _shift_lines(library, nodes, line, np.full(len(nodes), share))
        found.append(window_clouds(library, moved, rule).select(nodes))
    return found


def _select_offsets(clouds: list[FlatClouds], choice: Int64) -> FlatClouds:
    """Return for every node the cloud of its chosen offset."""
    return FlatClouds.joined([clouds[number].select(np.array([n])) for n, number in enumerate(choice)])


def _offset_scores(
    own: list[FlatClouds], other: FlatClouds, threshold: float, allowed: _Allowed, turned: bool
) -> Float64:
    """Return how near each node is to all others with each offset, (OFFSETS, N)."""
    gains = np.zeros((len(own), len(own[0])))
    for number, flat in enumerate(own):
        for begin in range(0, len(flat), _BLOCK):
            part = slice(begin, min(begin + _BLOCK, len(flat)))
            product = np.abs(flat.floor[part].conj() @ other.floor.T) + flat.height[part] @ other.height.T
            squared = flat.size[part, None] + other.size - 2.0 * product
            nearness = np.exp(-np.maximum(squared, 0.0) / threshold**2) * allowed.block(part, turned)
            gains[number, part] = nearness.sum(axis=1)
    return gains
