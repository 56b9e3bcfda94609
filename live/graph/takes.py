"""Takes: the other clips of the same step that may be mixed into a measure, live (T044-T047)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.graph.library import StepLibrary
from live.motion.editing.same_step import check_same_structure
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

NO_TAKE = -1


@dataclass(frozen=True, slots=True, eq=False)
class Takes:
    """For each of N nodes the nodes that hold the same measure of the same step in another take, as compressed rows."""

    start: Int32
    """Takes of node u are start[u] to start[u + 1], shape (N + 1,)."""
    node: Int32
    """Nodes, in the order of the library."""

    def count(self, nodes: Int32) -> Int32:
        """How many other takes each of `nodes` (A,) has, (A,)."""
        return np.asarray(self.start[nodes + 1] - self.start[nodes], np.int32)

    def draw(self, nodes: Int32, chance: Float64) -> Int32:
        """One take for each of `nodes` (A,) by its `chance` in [0, 1), NO_TAKE where there is none, (A,)."""
        count = self.count(nodes)
        place = self.start[nodes] + (chance * count).astype(np.int32)
        found = (
            self.node[np.minimum(place, max(len(self.node) - 1, 0))] if len(self.node) else np.full_like(nodes, NO_TAKE)
        )
        return np.where(count > 0, found, NO_TAKE).astype(np.int32)


def find_takes(library: StepLibrary) -> Takes:
    """All takes of a library. Only clips of one structural variation are mixed (T046): same foot, same poses."""
    fits: dict[tuple[int, int], bool] = {}
    rows: list[list[int]] = []
    for u in range(library.node_count):
        same = (library.node_step == library.node_step[u]) & (library.node_measure == library.node_measure[u])
        row = []
        for v in np.flatnonzero(same):
            a, b = int(library.node_clip[u]), int(library.node_clip[v])
            pair = (min(a, b), max(a, b))
            if a != b and pair not in fits:
                fits[pair] = _fit(library.clips[a], library.clips[b])
            if a != b and fits[pair]:
                row.append(int(v))
        rows.append(row)
    start = np.cumsum([0, *map(len, rows)])
    return Takes(start.astype(np.int32), np.array([v for row in rows for v in row], np.int32))


def _fit(a: StepClip, b: StepClip) -> bool:
    try:
        check_same_structure(a, b)
    except ValueError:
        return False
    return True
