"""Transitions in an interval around the measure line, the measure re-timed to it (T140).

Where a dancer lands a little before or after the beat, the best place to leave a step is not exactly at its last
sample. Every measure that ends a step may end up to a share of a measure earlier or later, and every one that begins a
step may begin so; what lies between is danced quicker or slower, so the dance keeps to the metre. A node has one end
and one beginning for all its edges, because most of a measure is danced before it is decided what comes next.
"""

from dataclasses import replace
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.build.flat import FlatClouds
from live.graph.build.joins import JoinRule, window_clouds
from live.graph.step_library import StepLibrary, travel_of
from live.graph.transition_rules import may_follow_between

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

OFFSETS: Final = 5
"""Places that are tried on each side, the measure line among them."""
SWEEPS: Final = 2
_BLOCK: Final = 256


def retimed(library: StepLibrary, rule: JoinRule, interval: float) -> StepLibrary:
    """The library with the ends and beginnings of its steps moved by up to `interval` (a share of the measure).

    Each end in turn goes where it is nearest to the beginnings as they are by then, and each beginning likewise: what
    counts is the sum over all pairs of exp(-(distance / threshold)²), which never falls. Lines inside steps of several
    measures stay, and so does every line where moving it gains nothing. ValueError for an interval outside [0, 0.25].
    """
    if not 0.0 <= interval <= 0.25:
        raise ValueError(f"interval around the measure line {interval}: a share of the measure from 0 to 0.25 expected")
    if interval == 0.0:
        return library
    shares = np.array(sorted(np.linspace(-interval, interval, OFFSETS), key=abs))  # the line itself wins a draw
    leaves = np.flatnonzero(library.node_measure == library.node_measures - 1)
    enters = np.flatnonzero(library.node_measure == 0)
    ends, begins = (_clouds(library, nodes, line, rule, shares) for nodes, line in (
        (leaves, library.node_last), (enters, library.node_first)))  # fmt: skip
    out, into = np.zeros(len(leaves), np.int64), np.zeros(len(enters), np.int64)
    allowed = _Allowed(library, leaves, enters)
    for _ in range(SWEEPS):
        out = _gains(ends, _picked(begins, into), rule.threshold, allowed, turned=False).argmax(axis=0)
        into = _gains(begins, _picked(ends, out), rule.threshold, allowed, turned=True).argmax(axis=0)
    first, last = library.node_first.copy(), library.node_last.copy()
    last[leaves] = _moved(library, leaves, library.node_last, shares[out])
    first[enters] = _moved(library, enters, library.node_first, shares[into])
    return replace(library, node_first=first, node_last=last, node_travel=travel_of(library.clip_root, first, last))


class _Allowed:
    """Which of the first nodes the second may follow, in blocks."""

    def __init__(self, library: StepLibrary, first: Int64, second: Int64) -> None:
        self._library, self._first, self._second = library, first, second

    def block(self, part: slice, turned: bool) -> npt.NDArray[np.bool_]:
        """Rows `part` of the table, or, `turned`, of its transpose."""
        if turned:
            return may_follow_between(self._library, self._first, self._second[part]).T
        return may_follow_between(self._library, self._first[part], self._second)


def _moved(library: StepLibrary, nodes: Int64, line: Float64, share: Float64) -> Float64:
    """The samples `line` of some nodes, moved by a share of the measure, within their clips."""
    ends = np.array([library.clips[clip].clip.sample_count - 1.0 for clip in library.node_clip[nodes]])
    size = library.node_last[nodes] - library.node_first[nodes]
    low = library.node_lead[nodes]
    return np.asarray(np.clip(line[nodes] + share * size, low, low + ends))


def _clouds(library: StepLibrary, nodes: Int64, line: Float64, rule: JoinRule, shares: Float64) -> list[FlatClouds]:
    """Clouds of the windows before the lines of some nodes, for every share by which they may be moved."""
    found = []
    for share in shares:
        moved = line.copy()
        moved[nodes] = _moved(library, nodes, line, np.full(len(nodes), share))
        found.append(window_clouds(library, moved, rule).chosen(nodes))
    return found


def _picked(clouds: list[FlatClouds], choice: Int64) -> FlatClouds:
    """For every node the cloud of its chosen offset."""
    return FlatClouds.joined([clouds[number].chosen(np.array([n])) for n, number in enumerate(choice)])


def _gains(own: list[FlatClouds], other: FlatClouds, threshold: float, allowed: _Allowed, turned: bool) -> Float64:
    """How near each node is to all others with each offset, (OFFSETS, N)."""
    gains = np.zeros((len(own), len(own[0])))
    for number, flat in enumerate(own):
        for begin in range(0, len(flat), _BLOCK):
            part = slice(begin, min(begin + _BLOCK, len(flat)))
            product = np.abs(flat.floor[part].conj() @ other.floor.T) + flat.height[part] @ other.height.T
            squared = flat.size[part, None] + other.size - 2.0 * product
            nearness = np.exp(-np.maximum(squared, 0.0) / threshold**2) * allowed.block(part, turned)
            gains[number, part] = nearness.sum(axis=1)
    return gains
