"""Following a path: for each measure the clip, mixture and turn that keep a dancer on the line (T067-T070).

A beam of hypotheses is led from measure to measure. Each knows where the dancer really is by then, so what one measure
misses the next one makes up for (T068); and a step that is wanted later is never lost, because what every node still
costs until the end in steps other than the wanted ones is counted beforehand, exactly.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.graph.motion_graph import MotionGraph
from live.graph.search.followed_path import FollowedPath
from live.graph.search.path import Targets
from live.graph.search.wrong_steps import cost_to_go, wrong_steps
from live.graph.select.candidates import Candidates, find_candidates
from live.graph.select.placing import begun, joined, next_axes, turn_vectors, wrapped

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]

BEAM: Final = 48
MOST_ROWS: Final = 40_000
"""Candidates weighed for one measure; of more, those whose own clips come nearest, so that any graph is quick."""
PER_NODE: Final = 6
"""Hypotheses kept in one node: the others would differ by hairs."""
HEADING: Final = 0.05
"""A radian off the heading costs as much as this many square metres off the place..."""
EDGE: Final = 0.05
"""... and a metre between the poses of a join..."""
TURN: Final = 0.005
"""... a radian of turning in a measure, for who can go there without turns back and forth does..."""
WRONG: Final = 1e4
"""... and a measure of another step: more than any place on the stage."""
NEAR: Final = 0.1
FAR: Final = 20.0
"""A place farther than NEAR [m] from its target costs FAR times the square of what it is beyond that, besides: one
measure that is far off is seen, many that are a little off are not."""
CORRECTED: Final = 0.3
"""A square metre of correction costs this."""


def follow_path(
    graph: MotionGraph,
    targets: Targets,
    *,
    seconds: float,
    wanted: npt.ArrayLike | None = None,
    fits: Bool | None = None,
    correction_m: float = 0.0,
    candidates: Candidates | None = None,
    beam: int = BEAM,
) -> FollowedPath:
    """Dance along `targets` (M measures of `seconds`), beginning at the first of them.

    `wanted` (M,) are steps by index, `ANY` for no matter which; `fits` (M, N) says more exactly which nodes may be
    danced when (see `Specification`; with both, what fits both). Where nothing that fits can be reached, something
    else is danced, in as few measures as possible. `correction_m` [m]: by so much the hips may be moved each measure
    beyond what the clips do; held feet hide it as far as legs reach.
    Deterministic. ValueError for arrays of other lengths, or no measure.
    """
    count = targets.measures
    if count < 1 or not seconds > 0.0:
        raise ValueError(f"{count} measures of {seconds} s: at least one, longer than 0, expected")
    wrong = wrong_steps(graph, count, wanted, fits)
    search = _Search(
        graph, candidates if candidates is not None else find_candidates(graph), targets, seconds, correction_m, beam
    )
    return search.run(wrong, cost_to_go(graph, wrong))


@dataclass(frozen=True, slots=True, eq=False)
class _Front:
    """B hypotheses after a measure."""

    cost: Float64
    """All costs up to here but that of this measure's end, which is known only when the next clip joins, (B,)."""
    node: Int32
    hips: Float64
    """(B, 2)"""
    heading: Float64
    back: Int32
    """Rows of the front before, (B,)."""
    row: Int32
    """Candidates, (B,)."""
    turn: Float64
    correction: Float64
    """(B, 2)"""
    joined_at: Float64
    """Where the hips were when this measure began, and how far the body faced from the target then, (B, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    graph: MotionGraph
    candidates: Candidates
    targets: Targets
    seconds: float
    correction_m: float
    beam: int

    def run(self, wrong: Bool, to_go: Float64) -> FollowedPath:
        fronts = [self._begin(wrong[0], to_go[0])]
        for n in range(1, len(wrong)):
            fronts.append(self._continue(fronts[-1], n, wrong[n], to_go[n]))
        last = fronts[-1]
        return self._result(
            fronts, int(np.argmin(last.cost + self._end_cost(len(wrong), last.hips, last.heading))), wrong
        )

    def _begin(self, wrong: Bool, to_go: Float64) -> _Front:
        """Every step that can be begun, at the first place of the path."""
        library, first = self.graph.library, self.targets
        node = np.flatnonzero(self.graph.alive & np.isfinite(to_go)).astype(np.int32)
        if (library.node_measure[node] == 0).any():
            node = node[library.node_measure[node] == 0]
        if not len(node):
            raise ValueError("no step can be begun: nothing in the graph leads on")
        count = len(node)
        placement = begun(
            self.graph, node, np.tile(first.place[0], (count, 1)), np.full(count, first.heading[0])
        )  # fmt: skip
        start = np.column_stack([np.tile(first.place[0], (count, 1)), np.zeros(count)])
        cost = WRONG * wrong[node].astype(np.float64)
        return self._weigh(1, np.zeros(count, np.int32), cost, node, placement, start, to_go)

    def _continue(self, front: _Front, n: int, wrong: Bool, to_go: Float64) -> _Front:
        """All that can follow the hypotheses of `front` in measure n."""
        graph, library = self.graph, self.graph.library
        axes = next_axes(graph, front.node, front.hips, front.heading)
        first, last = graph.edge_start[front.node], graph.edge_start[front.node + 1]
        back = np.repeat(np.arange(len(front.node), dtype=np.int32), last - first)
        edge = np.concatenate([np.arange(a, b) for a, b in zip(first, last, strict=True)])
        node = graph.edge_target[edge]
        ahead = wrong[node] + to_go[node]
        useful = ahead <= ahead.min() + 1.0  # a detour costs more than any place on the stage
        back, edge, node = back[useful], edge[useful], node[useful]
        placement = joined(axes[back], graph.edge_transform[edge])
        hips = placement[:, :2] + turn_vectors(graph.node_start[node], placement[:, 2])
        heading = placement[:, 2] + graph.node_facing_start[node]
        inner = library.node_measure[node] > 0
        hips[inner], heading[inner] = front.hips[back[inner]], front.heading[back[inner]]
        cost = front.cost[back] + WRONG * wrong[node] + EDGE * graph.edge_cost[edge]
        cost += self._end_cost(n, hips, heading)
        off = wrapped(heading - self.targets.heading[n])
        return self._weigh(n + 1, back, cost, node, placement, np.column_stack([hips, off]), to_go)

    def _end_cost(self, line: int, hips: Float64, heading: Float64) -> Float64:
        error = np.hypot(*(hips - self.targets.place[line]).T)
        off = wrapped(heading - self.targets.heading[line])
        return np.asarray(error**2 + FAR * np.maximum(error - NEAR, 0.0) ** 2 + HEADING * off**2)

    def _weigh(
        self, line: int, back: Int32, cost: Float64, node: Int32, placement: Float64, start: Float64, to_go: Float64
    ) -> _Front:
        """The best candidates of all `node` (n,), each laid down at its placement, for the measure before `line`."""
        entry = self._worth_trying(line, cost, node, placement, to_go)
        count = np.diff(self.candidates.first)[node[entry]]
        before = np.repeat(np.cumsum(count) - count, count)
        row = np.repeat(self.candidates.first[node[entry]], count) + np.arange(count.sum()) - before
        entry = np.repeat(entry, count)
        return self._best_of(line, row.astype(np.int32), entry, back, cost, node, placement, start, to_go)

    def _worth_trying(
        self, line: int, cost: Float64, node: Int32, placement: Float64, to_go: Float64
    ) -> npt.NDArray[np.int64]:
        """Rows of `node`: all, or, of too many, those whose own clips, unmixed, come nearest."""
        count = np.diff(self.candidates.first)[node]
        if count.sum() <= MOST_ROWS:
            return np.arange(len(node))
        row = self.candidates.first[node]
        _, _, hips, heading = self._ends(line, row, placement)
        score = cost + self._end_cost(line, hips, heading) + WRONG * to_go[node]
        order = np.argsort(score, kind="stable")
        return np.sort(order[np.cumsum(count[order]) <= MOST_ROWS])

    def _ends(self, line: int, row: Int32, placement: Float64) -> tuple[Float64, Float64, Float64, Float64]:
        """Turn (n,), correction (n, 2), hips (n, 2) and heading (n,) of candidates `row` (n,) at `placement` (n, 3)."""
        candidates = self.candidates
        most = candidates.most_turn(self.seconds)[candidates.node[row]]
        turn = wrapped(self.targets.heading[line] - placement[:, 2] - candidates.facing[row])
        turn = np.clip(turn, -most, most)
        hips, heading = candidates.turned_end(row, placement, turn)
        correction = self.targets.place[line] - hips
        size = np.maximum(np.hypot(*correction.T), 1e-9)
        correction *= np.minimum(1.0, self.correction_m / size)[:, None]
        return turn, correction, hips + correction, heading

    def _best_of(
        self, line: int, row: Int32, entry: npt.NDArray[np.int64], back: Int32, cost: Float64, node: Int32,
        placement: Float64, start: Float64, to_go: Float64,
    ) -> _Front:  # fmt: skip
        """The front of the best candidates `row` (n,), each for the row `entry` (n,) of the other arrays."""
        turn, correction, hips, heading = self._ends(line, row, placement[entry])
        spent = cost[entry] + TURN * turn**2 + CORRECTED * (correction**2).sum(axis=1)
        score = spent + self._end_cost(line, hips, heading) + WRONG * to_go[node[entry]]
        best = _best(score, node[entry], self.beam)
        return _Front(
            cost=spent[best], node=node[entry[best]], hips=hips[best], heading=heading[best], back=back[entry[best]],
            row=row[best], turn=turn[best], correction=correction[best], joined_at=start[entry[best]],
        )  # fmt: skip

    def _result(self, fronts: list[_Front], index: int, wrong: Bool) -> FollowedPath:
        picks = []
        for front in reversed(fronts):
            picks.append(index)
            index = int(front.back[index])
        rows = list(zip(fronts, reversed(picks), strict=True))
        row = np.array([front.row[pick] for front, pick in rows])
        node = np.array([front.node[pick] for front, pick in rows], np.int32)
        begins = np.array([front.joined_at[pick] for front, pick in rows])
        last, pick = rows[-1]
        off = wrapped(last.heading[pick : pick + 1] - self.targets.heading[-1])
        ends = np.vstack([begins[1:], [[*last.hips[pick], off[0]]]])
        return FollowedPath(
            node=node,
            take=self.candidates.take[row],
            share=self.candidates.share[row],
            turn=np.array([front.turn[pick] for front, pick in rows]),
            correction=np.array([front.correction[pick] for front, pick in rows]),
            place=ends[:, :2],
            error=np.hypot(*(ends[:, :2] - self.targets.place[1:]).T),
            heading_error=np.abs(ends[:, 2]),
            wrong=wrong[np.arange(len(node)), node],
        )


def _best(score: Float64, node: Int32, beam: int) -> npt.NDArray[np.int64]:
    """Rows of the lowest scores, at most PER_NODE for one node and `beam` in all, the lowest first."""
    order = np.argsort(score, kind="stable")[: 40 * beam]
    grouped = np.argsort(node[order], kind="stable")
    sorted_node = node[order][grouped]
    begins = np.flatnonzero(np.concatenate(([True], sorted_node[1:] != sorted_node[:-1])))
    place = np.arange(len(order)) - np.repeat(begins, np.diff(np.concatenate((begins, [len(order)]))))
    rank = np.empty(len(order), np.int64)
    rank[grouped] = place
    return np.asarray(order[rank < PER_NODE][:beam], np.int64)
