"""Takes: other clips of the same step that may be mixed into a measure, live (T044-T047)."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32, Int64
from live.motion.step_clip import StepClip

if TYPE_CHECKING:
    from live.graph.step_library import StepLibrary


NO_TAKE = -1
MAX_TAKES: Final = 64
"""Takes of one node. Of a measure with more, each has others, evenly over all, so that all of them are mixed in."""


@dataclass(frozen=True, slots=True, eq=False)
class Takes:
    """For each of N nodes, the nodes with the same measure of the same step in another take, as compressed rows."""

    start: Int32
    """Takes of node u are start[u] to start[u + 1], shape (N + 1,)."""
    node: Int32
    """Nodes, in library order."""

    def count(self, nodes: Int32) -> Int32:
        """Return the number of other takes of each of `nodes` (A,), (A,)."""
        return np.asarray(self.start[nodes + 1] - self.start[nodes], np.int32)

    def draw(self, nodes: Int32, random: Float64) -> Int32:
        """Return one take for each of `nodes` (A,) by its `random` in [0, 1), NO_TAKE if there is none, (A,)."""
        count = self.count(nodes)
        place = self.start[nodes] + (random * count).astype(np.int32)
        found = (
            self.node[np.minimum(place, max(len(self.node) - 1, 0))] if len(self.node) else np.full_like(nodes, NO_TAKE)
        )
        return np.where(count > 0, found, NO_TAKE).astype(np.int32)


def find_takes(library: "StepLibrary", leaving: npt.NDArray[np.bool_] | None = None) -> Takes:
    """Return all takes of a library. Only clips of one structural variation are mixed (T046): same foot, same poses.

    The rule is that of `check_same_structure`. Measures of a stream (T037) and those that are `leaving` (N,) are not
    takes of any other.
    """
    numbers: dict[tuple[object, ...], int] = {}
    # key of a take: all that must be equal but the side; -1 if the clip has no takes
    kind = np.array([-1 if c.in_stream else numbers.setdefault(_kind(c), len(numbers)) for c in library.clips])
    foot = np.array([("", "left", "right").index(clip.leading_foot) for clip in library.clips])
    mirrored = np.array([clip.mirrored for clip in library.clips])
    clip = library.node_clip
    place = kind[clip].astype(np.int64) * (int(library.node_measure.max()) + 1) + library.node_measure
    place[kind[clip] < 0] = -1
    if leaving is not None:
        place[leaving] = -1
    order = np.argsort(place, kind="stable")
    pairs = [np.zeros((2, 0), np.int64)]
    for group in np.split(order, np.flatnonzero(np.diff(place[order])) + 1):
        if len(group) < 2 or place[group[0]] < 0:
            continue
        own = clip[group]
        if len(group) > MAX_TAKES + 1:
            pairs += _spread_pairs(group, 2 * foot[own] + mirrored[own])
            continue
        left, right, side = foot[own] == 1, foot[own] == 2, mirrored[own]
        told = (left | right)[:, None] & (left | right)[None]
        same = np.where(told, left[:, None] == left[None], side[:, None] == side[None])
        pairs.append(group[np.stack(np.nonzero(same & (own[:, None] != own[None])))])
    node, take = np.concatenate(pairs, axis=1)
    start = np.searchsorted(np.sort(node), np.arange(library.node_count + 1))
    return Takes(start.astype(np.int32), take[np.lexsort((take, node))].astype(np.int32))


def _spread_pairs(group: Int64, structure: Int64) -> list[Int64]:
    """Return pairs of node and take (2, n) for each structure in a large group of takes: MAX_TAKES for each at most."""
    found = []
    for code in np.unique(structure):
        nodes = group[structure == code]
        count = min(MAX_TAKES, len(nodes) - 1)
        if count:
            apart = (np.arange(count) * (len(nodes) - 1)) // count + 1
            other = nodes[(np.arange(len(nodes))[:, None] + apart) % len(nodes)]
            found.append(np.stack([np.repeat(nodes, count), other.reshape(-1)]))
    return found


def _kind(clip: StepClip) -> tuple[object, ...]:
    return (clip.step, clip.measures, clip.beats_per_measure, clip.begin_pose, clip.end_pose, clip.weight_transfer)
