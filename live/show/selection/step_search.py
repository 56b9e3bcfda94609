"""Search of the motion graph for each dancer's next measure, some dancers at a time (T068-T070)."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64, Int32
from live.base.motion_parameters import FACE_AVERAGE, OBEDIENCE, TURN_ON_SUPPORT
from live.graph.motion_graph import MotionGraph
from live.graph.select.candidates import wrap_angle
from live.graph.select.selector import CORRECTION_COST, PLACE_COST, WRONG_COST, StepSelector, with_direction
from live.show.dancers.partners import Partners
from live.show.dancers.root_correction import MIN_CORRECTION_SHARE
from live.show.patch.patch import Patch
from live.show.selection.choices import StepChoices

if TYPE_CHECKING:
    from live.show.dancers.dancers import Dancers
    from live.show.group.group_motion import GroupMotion
    from live.show.selection.step_targets import StepTargets


TURNS: Final = (0.0, math.pi / 2.0, math.pi, -math.pi / 2.0)
"""Dancers who would be left behind may turn by these angles from their way [rad] instead, ..."""
SHORTFALL_COST: Final = 4.0
"""... at this cost of each metre that they still lack ..."""
TURNED_COST: Final = 0.12
"""... and of a squared radian from the wanted heading, ..."""
TURNED_GAIN: Final = 0.8
"""... if it all costs less by this: 0.2 m."""
MAX_BATCH: Final = 256
"""Most dancers whose measures are chosen in one piece; ..."""
MIN_BATCH: Final = 6
"""... for fewer a piece of its own costs more than their search."""
BATCHES: Final = 20
"""So many pieces at least are the dancers of a large show."""


class StepSearch:
    """Search for A dancers; the results are written to `choices`.

    Call `prepare`, then `choose` for all dancers, `choose_turned` for the `turned_batches`, `set_follower_targets`, and
    `choose_followers` for all pairs; `choose_replaced` at any time after that.
    """

    def __init__(
        self, patch: Patch, dancers: "Dancers", motion: "GroupMotion", targets: "StepTargets", choices: StepChoices
    ) -> None:
        """`set_graph` must be called before anything else."""
        self._patch, self._dancers, self._motion = patch, dancers, motion
        self._targets, self._choices = targets, choices
        self._search_nodes = np.full(len(targets.step), -1, np.int32)
        self._arguments: tuple[Any, ...] = ()
        nobody = np.zeros(0, np.int32)
        self._following: tuple[Int32, Int32, Int32] = nobody, nobody, nobody
        self._behind: list[npt.NDArray[np.intp]] = []
        self.seconds = 2.0
        """Duration of a measure [s]."""

    def set_graph(self, graph: MotionGraph, choosing: StepSelector) -> None:
        """Switch to this graph. Called while no next measure is decided."""
        self._choosing = choosing
        self._give = np.minimum(graph.node_reach_margin, self._patch.locomotion.correction_m)
        self._usual_give = float(np.median(self._give))

    def apply_patch(self, fresh: "StepSearch") -> None:
        """Apply the correction limits of another patch."""
        self._give, self._usual_give = fresh._give, fresh._usual_give

    @property
    def prepared(self) -> bool:
        """Whether the arguments of the search are set."""
        return bool(self._arguments)

    def clear(self) -> None:
        """Clear the arguments of the search."""
        self._arguments = ()
        self._behind.clear()

    @property
    def axes(self) -> Float64:
        """End axes of the present measures, as used by the search: x, z, angle, its cosine and sine, (A, 5)."""
        return np.asarray(self._arguments[1])

    @property
    def on_support(self) -> Float64:
        """`Variation.on_support` as used by the search, (A,)."""
        return np.asarray(self._arguments[6][:, 0])

    def prepare(self) -> None:
        """Limit the targets to the dancers' reach, and set the arguments of the search."""
        variation, limits = self._dancers.variation, self._patch.locomotion
        share = MIN_CORRECTION_SHARE + (1.0 - MIN_CORRECTION_SHARE) * variation[OBEDIENCE]
        self._choosing.set_limits(
            seconds=self.seconds, turn=math.radians(limits.turn_deg), correction=limits.correction_m
        )
        self._targets.limit_targets(self._choices, share * self._usual_give)
        self._search_nodes[:] = self._dancers.node
        self._arguments = (
            self._search_nodes,
            with_direction(self._dancers.present.end_placement()),
            with_direction(np.column_stack([self._choices.target, self._targets.heading])),
            self._targets.row,
            self._targets.ahead,
            self._motion.partners.wanted_sides(
                variation.sides, self._dancers.graph.library.node_side[self._search_nodes]
            ),
            np.column_stack([variation[TURN_ON_SUPPORT], variation[FACE_AVERAGE], share]),
            self._choices.outputs,
        )

    def choose(self, rows: slice) -> None:
        """Choose the next measures of these dancers. Those who would not get where they should are kept for
        `turned_batches`."""
        self._choosing.choose(rows, *self._arguments)
        behind = rows.start + np.flatnonzero(self._choices.edge[rows, 0] >= 0)
        within = _corrected(self._choices.target[behind], self._choices.outputs, behind)
        short = self._shortfalls(behind, within, self._choices.end[behind])
        self._behind.append(behind[short > self._targets.turn_shortfall[behind]])

    def turned_batches(self) -> list[npt.NDArray[np.intp]]:
        """Return those for whom `choose_turned` is to be called, in pieces."""
        behind = np.concatenate([*self._behind, np.zeros(0, np.intp)])
        self._behind.clear()
        return [behind[some] for some in batches(len(behind), batch_size(len(self._search_nodes)))]

    def _shortfalls(self, rows: npt.NDArray[np.intp], corrected: Float64, end: Float64) -> Float64:
        """Return how far from their wishes dancers `rows` (n,) get who are `corrected` (n,) [m] from `end` (n, 4)."""
        return np.asarray(np.maximum(np.hypot(*(self._choices.wish[rows] - end[:, :2]).T) - corrected, 0.0))

    def choose_turned(self, rows: npt.NDArray[np.intp]) -> None:
        """Choose again for the dancers `rows` (n,), who may turn along their ways, against them or across.

        The turn is that of the best unmixed measure; then all are searched for this turn.
        """
        choices, targets, out = self._choices, self._targets, self._arguments[-1]
        goal, wanted = choices.wish[rows], targets.heading[rows]
        way = goal - choices.start_position[rows]
        path = np.arctan2(way[:, 0], way[:, 1])
        every = np.tile(rows, len(TURNS))
        turned = np.add.outer(TURNS, path).ravel()
        found = self._search_turned(every, turned, mixed=False)
        costs = found.cost + TURNED_COST * wrap_angle(turned - np.tile(wanted, len(TURNS))) ** 2
        heading = turned.reshape(len(TURNS), -1)[costs.reshape(len(TURNS), -1).argmin(axis=0), np.arange(len(rows))]

        short = self._shortfalls(rows, _corrected(choices.target[rows], out, rows), choices.end[rows])
        cost = _cost(short, choices.terms[rows, 0]) - TURNED_GAIN
        found = self._search_turned(rows, heading, mixed=True)
        better = found.cost + TURNED_COST * wrap_angle(heading - wanted) ** 2 < cost
        who, end = rows[better], found.results[3]
        targets.heading[who] = heading[better]
        reached = (found.corrected / np.maximum(found.corrected + found.shortfall, 1e-9))[:, None]
        choices.target[who] = (end[:, :2] + reached * (goal - end[:, :2]))[better]
        for array, result in zip(out, found.results, strict=True):
            array[who] = result[better]
        self._arguments[2][rows] = with_direction(np.column_stack([choices.target[rows], targets.heading[rows]]))

    def _search_turned(self, rows: npt.NDArray[np.intp], heading: Float64, *, mixed: bool) -> "_Found":
        """Search the measures with which the dancers `rows` (n,) get to their wishes with `heading` (n,) [rad]."""
        node, placement, _, row, ahead, side, manner, out = self._arguments
        goal = self._choices.wish[rows]
        results: Any = tuple(np.ascontiguousarray(array[rows]) for array in out)
        self._choosing.choose(
            slice(0, len(rows)), node[rows], placement[rows], with_direction(np.column_stack([goal, heading])),
            row[rows], ahead, side[rows], manner[rows], results, mixed=mixed,
        )  # fmt: skip
        corrected = _corrected(goal, results, np.arange(len(rows)))
        shortfall = self._shortfalls(rows, corrected, results[3])
        return _Found(results, corrected, shortfall, _cost(shortfall, results[2][:, 0]))

    def set_follower_targets(self) -> None:
        """Set the followers' targets from the ends of their leaders' measures, which are chosen already."""
        partners = self._motion.partners
        self._following = partners.follower, partners.follower, partners.follower
        if len(partners.leader):
            self._following = set_follower_targets(
                partners, self._choosing, self._choices, self._targets.heading, self._arguments
            )

    def choose_followers(self, pairs: slice) -> None:
        """Choose the next measures of the followers of these pairs."""
        rows, sides, nodes = (array[pairs] for array in self._following)
        if len(rows):
            choose_followers(rows, sides, nodes, self._choosing, self._choices, self._arguments)

    def choose_replaced(self) -> bool:
        """Choose again for dancers whose present measure was replaced since the search. Returns whether there are
        any."""
        node = self._dancers.node
        changed = np.flatnonzero(self._search_nodes != node)
        if not len(changed):
            return False
        self._search_nodes[changed] = node[changed]
        self._arguments[1][changed] = with_direction(self._dancers.present.end_placement())[changed]
        for row in changed.tolist():
            self.choose(slice(row, row + 1))
        for rows in self.turned_batches():
            self.choose_turned(rows)
        return True


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Measures of n dancers that a search found."""

    results: Any
    """As `StepChoices.outputs`."""
    corrected: Float64
    """How far they are corrected [m], (n,)."""
    shortfall: Float64
    """How far from their wishes they end [m], (n,)."""
    cost: Float64
    """Without that of their headings, (n,)."""


def batch_size(dancers: int) -> int:
    """Return of how many dancers at a time a show of so many chooses the measures."""
    return min(max(dancers // BATCHES, MIN_BATCH), MAX_BATCH)


def batches(count: int, size: int) -> list[slice]:
    """Return slices of at most `size` that together are the rows 0 to `count` - 1."""
    return [slice(row, min(row + size, count)) for row in range(0, count, size)]


def _corrected(target: Float64, out: tuple[Any, ...], at: npt.NDArray[np.integer]) -> Float64:
    """Return how far measures in the rows `at` (n,) of `out`, chosen for `target` (n, 2) [m], are corrected [m]."""
    square = ((target - out[3][at, :2]) ** 2).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(PLACE_COST * square - out[2][at, 0, 0], 0.0) / (PLACE_COST - CORRECTION_COST)))


def _cost(shortfall: Float64, terms: Float64) -> Float64:
    """Return the cost of measures (n,) that end `shortfall` (n,) [m] from the wish, with `terms` (n, 5) of theirs."""
    return np.asarray(SHORTFALL_COST * shortfall + terms[:, 1:].sum(axis=1))


OTHER_STEP_COST: Final = 0.5
"""Cost of another measure than the leader's for followers who look the same way: more than most joins or a
correction of half a metre, less than a place error of a quarter beyond it."""
TOO_FAR: Final = 0.4
"""A follower whose measure, though corrected, would end farther than this [m] from the target may dance either side of
the step."""


def set_follower_targets(
    partners: Partners,
    choosing: StepSelector,
    choices: StepChoices,
    heading: Float64,
    search_arguments: tuple[Any, ...],
) -> tuple[Int32, Int32, Int32]:
    """Set the targets of followers after all dancers chose; `search_arguments` are those of `StepSelector.choose`.

    A leader ends where clip and correction lead, with the heading that the turn reaches. Both are written to the
    targets and to `heading` (A,) [rad], together with the followers' targets. Returns the followers (P,), the sides
    they want: the mirror image of the leader's side for facing pairs, else the same side; and the measures they want:
    the leader's, below 0 for facing pairs, who go opposite ways in their steps.
    """
    node, _, wish, _, _, _, manner, _ = search_arguments
    lead, follow = partners.leader, partners.follower
    end, edge = choices.end[lead], choices.edge[lead, 0]
    chosen = np.where(edge < 0, node[lead], choosing.graph.edge_target[np.maximum(edge, 0)])
    way = choices.target[lead] - end[:, :2]
    most = manner[lead, 2] * np.minimum(choosing.graph.node_reach_margin[chosen], choosing.facts[chosen, 3])
    reached = end[:, :2] + way * np.minimum(1.0, most / np.maximum(np.hypot(*way.T), 1e-9))[:, None]
    facing = heading[lead] - end[:, 3]
    lost = edge < 0  # cannot happen in a pruned graph
    reached[lost], facing[lost] = choices.target[lead][lost], heading[lead][lost]
    partners.set_follower_targets(reached, facing, choices.target, heading)
    wish[follow] = with_direction(np.column_stack([choices.target[follow], heading[follow]]))
    return follow, partners.follower_sides(choosing.graph.library.node_side[chosen]), partners.follower_nodes(chosen)


def choose_followers(
    rows: Int32,
    sides: Int32,
    nodes: Int32,
    choosing: StepSelector,
    choices: StepChoices,
    search_arguments: tuple[Any, ...],
) -> None:
    """Choose again for the followers `rows` (n,) who want these `sides` (n,) and `nodes` (n,), below 0 for any.

    Staying together counts more than dancing the same step on the same feet: followers who end too far away choose
    from both sides.
    """
    row, ahead = search_arguments[3], search_arguments[4]
    # wrong measures for each row and leader's measure that occur, and how much another measure than the leader's counts
    count = ahead.shape[1] + 1
    kinds, kind = np.unique(row[rows].astype(np.int64) * count + nodes + 1, return_inverse=True)
    of, node = np.divmod(kinds, count)
    wrong = ahead[of] + np.where(node == 0, 0.0, OTHER_STEP_COST / WRONG_COST)[:, None]
    led = np.flatnonzero(node)
    wrong[led, node[led] - 1] = ahead[of[led], node[led] - 1]
    _choose(rows, sides, kind.astype(np.int32), wrong, choosing, search_arguments)
    off = np.hypot(*(choices.end[rows, :2] - choices.target[rows]).T)
    far = rows[off - _corrected(choices.target[rows], choices.outputs, rows) > TOO_FAR]
    if len(far):
        _choose(far, np.zeros(len(far), np.int32), row[far], ahead, choosing, search_arguments)


def _choose(
    rows: Int32, sides: Int32, row: Int32, ahead: Float64, choosing: StepSelector, search_arguments: tuple[Any, ...]
) -> None:
    """Choose for the dancers `rows` (n,) with these `sides` (n,) and rows `row` (n,) of `ahead` (R, N)."""
    node, placement, wish, _, _, _, manner, out = search_arguments
    results: Any = tuple(np.ascontiguousarray(array[rows]) for array in out)
    choosing.choose(
        slice(0, len(rows)), node[rows], placement[rows], wish[rows], row, ahead, sides, manner[rows], results
    )
    for array, result in zip(out, results, strict=True):
        array[rows] = result
